# SPDX-License-Identifier: Apache-2.0
"""Fits the fusion's parameters, and those of the baselines, to a bag."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np

from fuzzy_fusion_ros.bag import BagReader, open_bag
from fuzzy_fusion_ros.baselines import BaselineParameters
from fuzzy_fusion_ros.batch.arrays import Reals, nearest
from fuzzy_fusion_ros.batch.series import held_s2
from fuzzy_fusion_ros.jobs import parameter_file
from fuzzy_fusion_ros.jobs.outputs import require_writable
from fuzzy_fusion_ros.jobs.parameter_file import Source, fusion_parameters
from fuzzy_fusion_ros.jobs.progress import SILENT, Progress
from fuzzy_fusion_ros.offline.check import warnings_of
from fuzzy_fusion_ros.offline.recording import Recording, read_recording
from fuzzy_fusion_ros.offline.topics import Topics, codecs_of
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import replace
from fuzzy_fusion_ros.parameters.writing import writing
from fuzzy_fusion_ros.scoring.join import interpolated
from fuzzy_fusion_ros.tuning import Tuned
from fuzzy_fusion_ros.tuning import tune as fit
from fuzzy_fusion_ros.tuning.reference import in_gaps
from fuzzy_fusion_ros.tuning.report import comments


class TuneResult(NamedTuple):
    """A fit, and what it was made to.

    Attributes:
        tuned: The fit: candidates, errors before and after, characteristics of the sensors.
        recording: What was read of the bag.
        unit: Unit of the signal, ``""`` where it is not known.
        origin: Bag, span and seed, in words.
    """

    tuned: Tuned
    recording: Recording
    unit: str
    origin: str

    @property
    def parameters(self) -> Parameters:
        """The fusion's parameters."""
        return self.tuned.parameters

    @property
    def baselines(self) -> BaselineParameters:
        """The baselines' parameters."""
        return self.tuned.baselines

    def text(self) -> str:
        """Return the parameters as the text of a file for ``fusion_node`` and ``score``."""
        lines = comments(self.tuned, self.unit, self.origin)
        return parameter_file.text(self.parameters, self.baselines, lines)

    def write(self, path: str | Path) -> None:
        """Write the parameters as a file for ``fusion_node`` and ``score``.

        Raises:
            FusionError: The file cannot be written.
        """
        with writing(path) as file:
            file.write_text(self.text(), encoding="utf-8")


def tune(
    bag: str | Path,
    output: str | Path | None = None,
    *,
    parameters: Source = None,
    topics: Topics | None = None,
    start: float | None = None,
    end: float | None = None,
    use_truth: bool = True,
    unit: str | None = None,
    seed: int = 0,
    progress: Progress = SILENT,
) -> TuneResult:
    """Fit the parameters to a bag; the same arguments give the same result.

    Args:
        bag: A rosbag2 directory or an ``.mcap`` file.
        output: YAML file to write the parameters to, if any.
        parameters: What the fit leaves alone, or the YAML file with it; the defaults unless given.
        topics: Where sensors and truth are; ``/s1``, ``/s2`` and ``/truth`` unless given.
        start: Where the span to fit to starts, seconds from the first message of the bag.
        end: Where it ends, seconds from the first message of the bag.
        use_truth: Whether to fit to the bag's truth, if it has one; otherwise the fit is to what
            both sensors say in hindsight.
        unit: Unit of the signal; unless given, that of the message type, if it has one.
        seed: Seed of the optimiser.
        progress: What shows progress; nothing does unless given.

    Raises:
        FusionError: The bag, the parameters or the output cannot be used, or there are too few
            samples to fit to.
    """
    require_writable(output, inputs=[bag, parameters])
    asked = topics or Topics()
    with open_bag(bag) as reader:
        wanted = asked.found_in(reader)
        if use_truth and asked.truth != Topics().truth:
            reader.require_topics(wanted.truth)
        base = _with_types(reader, wanted, fusion_parameters(parameters))
        recording = read_recording(
            reader,
            wanted,
            base,
            start,
            end,
            lambda messages: progress.over(messages, f"reading {Path(bag).name}", unit=" messages"),
        )
        found = warnings_of(reader, wanted, base, start, end)
        recording = recording._replace(notes=(*recording.notes, *found))
    truth = _truth(recording) if use_truth and recording.truth.stamps_ns.size else None
    with progress.counted("tuning", " runs") as advance:
        tuned = fit(recording.series, truth, base, seed, progress=advance)
    result = TuneResult(
        tuned,
        recording,
        recording.unit if unit is None else unit,
        _origin(bag, start, end, seed, tuned.with_truth),
    )
    if output is not None:
        result.write(output)
    return result


def _with_types(bag: BagReader, topics: Topics, parameters: Parameters) -> Parameters:
    """Return the parameters with the types and fields that the sensors have in the bag."""
    bag.require_topics(topics.s1, topics.s2)
    codecs = codecs_of(bag, topics, parameters)
    return replace(
        parameters,
        {
            "s1.type": bag.topics[topics.s1].msgtype,
            "s1.field": codecs["s1"].field.text,
            "s2.type": bag.topics[topics.s2].msgtype,
            "s2.field": codecs["s2"].field.text,
        },
    )


def _truth(recording: Recording) -> Reals:
    """Return the truth at each S1 sample, NaN where it has a gap."""
    stamps_ns = recording.series.s1_ns
    truth = interpolated(recording.truth, stamps_ns, recording.period)
    truth = nearest(truth, held_s2(recording.series), recording.period)
    return np.where(in_gaps(recording.truth.stamps_ns, stamps_ns), np.nan, truth)


def _origin(
    bag: str | Path, start: float | None, end: float | None, seed: int, with_truth: bool
) -> str:
    span = "" if start is end is None else f", --start {start or 0.0:g}"
    span += "" if end is None else f" --end {end:g}"
    target = "its truth" if with_truth else "what both sensors say in hindsight, without a truth"
    return f"{Path(bag).name}{span}, --seed {seed}, fitted to {target}"
