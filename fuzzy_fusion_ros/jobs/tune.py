# SPDX-License-Identifier: Apache-2.0
"""Fits the fusion's parameters, and those of the baselines, to one or several bags."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from contextlib import closing
from itertools import islice
from operator import itemgetter
from pathlib import Path
from typing import NamedTuple

from fuzzy_fusion_ros.bag import BagReader, open_bag
from fuzzy_fusion_ros.baselines import BaselineParameters
from fuzzy_fusion_ros.batch.arrays import Reals, nearest
from fuzzy_fusion_ros.batch.series import held_s2
from fuzzy_fusion_ros.jobs import parameter_file
from fuzzy_fusion_ros.jobs.fleet import Failure, Interrupted, outcomes
from fuzzy_fusion_ros.jobs.outputs import require_writable
from fuzzy_fusion_ros.jobs.parameter_file import Source, baseline_parameters, fusion_parameters
from fuzzy_fusion_ros.jobs.progress import SILENT, Progress
from fuzzy_fusion_ros.offline.check import check_start
from fuzzy_fusion_ros.offline.excerpts import excerpts
from fuzzy_fusion_ros.offline.recording import Recording, read_recording
from fuzzy_fusion_ros.offline.topics import Topics, codecs_of
from fuzzy_fusion_ros.offline.tracks import Track
from fuzzy_fusion_ros.offline.truth import suitability
from fuzzy_fusion_ros.parameters.errors import FusionError
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import flatten, replace
from fuzzy_fusion_ros.parameters.writing import writing
from fuzzy_fusion_ros.scoring.join import interpolated
from fuzzy_fusion_ros.tuning import Trial, Tuned
from fuzzy_fusion_ros.tuning import tune_to as fit
from fuzzy_fusion_ros.tuning.report import comments
from fuzzy_fusion_ros.tuning.tune import why_unusable

_NAMED = 5
"""Most bags that are named one by one."""

_ENOUGH = 10
"""Messages of S1, S2 and truth that a part of a bag has at least if it is worth scoring."""

_LONG_ENOUGH = 0.1
"""Length of what is worth scoring of what was left out of a fit, as a share of what was not."""

Span = tuple[float | None, float | None]
"""Start and end, seconds from the first message of a bag; ``None`` is no limit."""


class TuneResult(NamedTuple):
    """A fit and the recordings that it was made to.

    Attributes:
        tuned: The fit: candidates, errors before and after, characteristics of the sensors.
        recordings: What was read from the bags: each whole, or as excerpts of a long one.
        unit: Unit of the signal, ``""`` where it is not known.
        origin: Bags, span and seed, in words.
        source: The parameters before, with those of channels that were not tuned.
        channel: The channel that was tuned, ``""`` where there are no names.
        to_score: The span to score: what was left out of the fit, or else what was fitted to;
            ``None`` where a bag has no truth.
    """

    tuned: Tuned
    recordings: tuple[Recording, ...]
    unit: str
    origin: str
    source: Source
    channel: str
    to_score: Span | None

    @property
    def parameters(self) -> Parameters:
        """The fusion's parameters."""
        return self.tuned.parameters

    @property
    def baselines(self) -> BaselineParameters:
        """The baselines' parameters."""
        return self.tuned.baselines

    @property
    def names(self) -> list[str]:
        """Name of each recording: its bag, and of an excerpt which it is."""
        return self._named([each.name for each in self.recordings])

    @property
    def first_of_bags(self) -> list[int]:
        """Index of the first recording of each bag."""
        bags = [each.name for each in self.recordings]
        return [bags.index(each) for each in dict.fromkeys(bags)]

    def _named(self, bags: Sequence[str]) -> list[str]:
        paths = [each.name for each in self.recordings]
        return [
            f"{name}, excerpt {paths[: k + 1].count(path)} of {paths.count(path)}"
            if paths.count(path) > 1
            else name
            for k, (name, path) in enumerate(zip(bags, paths, strict=True))
        ]

    def text(self) -> str:
        """Return the parameters as the text of a file for ``fusion_node`` and ``score``.

        ``self_tuning`` is off in it: with it on, what was fitted would be ignored.
        """
        bags = [Path(each.name).name for each in self.recordings]
        lines = comments(self.tuned, self.unit, self.origin, self._named(bags))
        before = fusion_parameters(self.source)
        baselines = {
            name: self.baselines if name == self.channel else baseline_parameters(self.source, name)
            for name in before.by_channel()
        }
        return parameter_file.text(
            replace(before.with_channel(self.channel, self.parameters), {"self_tuning": False}),
            {name: each for name, each in baselines.items() if each is not None},
            lines,
        )

    def write(self, path: str | Path) -> None:
        """Write the parameters as a file for ``fusion_node`` and ``score``.

        Raises:
            FusionError: The file cannot be written.
        """
        with writing(path) as file:
            file.write_text(self.text(), encoding="utf-8")


class _Read(NamedTuple):
    """What was read of a bag.

    Attributes:
        recordings: Its excerpts.
        truths: The truth in each, if there is one.
        base: The parameters with the types of its sensors.
        clocks_agree: Whether one clock stamps both sensors, as far as is known.
        to_score: Spans that can be scored: first what is left out of the fit, if there is enough.
        truth_is_wrong: Whether its truth does not suit the sensors.
    """

    recordings: list[Recording]
    truths: list[Reals | None]
    base: Parameters
    clocks_agree: bool
    to_score: list[Span]
    truth_is_wrong: bool


def tune(
    bag: str | Path | Sequence[str | Path],
    output: str | Path | None = None,
    *,
    parameters: Source = None,
    topics: Topics | None = None,
    start: float | None = None,
    end: float | None = None,
    use_truth: bool = True,
    unit: str | None = None,
    seed: int = 0,
    jobs: int = 1,
    progress: Progress = SILENT,
) -> TuneResult:
    """Fit the parameters to one or several bags; the same arguments give the same result.

    Args:
        bag: A rosbag2 directory or an ``.mcap`` file; or several, of the same sensors, which get
            one set of parameters.
        output: YAML file to write the parameters to, if any.
        parameters: Values that the fit does not change, or a YAML file with them; the defaults
            unless given.
        topics: Where sensors and truth are; ``/s1``, ``/s2`` and ``/truth`` unless given.
        start: Where the span to fit to starts, seconds from the first message of each bag.
        end: Where it ends, seconds from the first message of each bag.
        use_truth: Whether to fit to the truth, if the bags have one; otherwise the fit
            maximises the likelihood of S2.
        unit: Unit of the signal; unless given, that of the message type, if it has one.
        seed: Seed of the optimiser.
        jobs: Number of bags to read at a time, each in a process; 1 reads them in this one.
        progress: Shows progress; none is shown unless given.

    Raises:
        FusionError: A bag, the parameters or the output cannot be used, there are too few samples
            to fit to, or some of the bags have other types or lack the truth that others have.
    """
    bags = [bag] if isinstance(bag, str | Path) else list(bag)
    require_writable(output, inputs=[*bags, parameters])
    task = functools.partial(
        _read,
        parameters=fusion_parameters(parameters),
        topics=topics or Topics(),
        start=start,
        end=end,
        use_truth=use_truth,
        progress=progress if jobs == 1 or len(bags) == 1 else SILENT,
    )
    read = []
    with closing(outcomes(task, bags, jobs)) as found:
        for each in found:
            if isinstance(each, Failure):
                raise FusionError(each.reason)
            if isinstance(each, Interrupted):
                raise KeyboardInterrupt
            read.append(each)
    _require_same_types(read)
    if use_truth:
        _require_truth_in_all_or_none(read)
    recordings = tuple(each for one in read for each in one.recordings)
    trials = [
        Trial(each.series, truth, each.name if len(recordings) > 1 else "", one.clocks_agree)
        for one in read
        for each, truth in zip(one.recordings, one.truths, strict=True)
    ]
    with progress.counted("tuning", " runs") as advance:
        tuned = fit(trials, read[0].base, seed, progress=advance)
    tuned = tuned._replace(truth_is_wrong=any(each.truth_is_wrong for each in read))
    result = TuneResult(
        tuned,
        recordings,
        recordings[0].unit if unit is None else unit,
        _origin(bags, start, end, seed, tuned.with_truth),
        parameters,
        (topics or Topics()).channel,
        next((each for each in read[0].to_score if all(each in r.to_score for r in read)), None),
    )
    if output is not None:
        result.write(output)
    return result


def _read(
    bag: str | Path,
    parameters: Parameters,
    topics: Topics,
    start: float | None,
    end: float | None,
    use_truth: bool,
    progress: Progress,
) -> _Read:
    with open_bag(bag) as reader:
        wanted = topics.found_in(reader)
        if use_truth and topics.truth != Topics().truth:
            wanted.require_in(reader, "truth")
        base = _with_types(reader, wanted, parameters.channel(wanted.channel))
        recording = read_recording(
            reader,
            wanted,
            base,
            start,
            end,
            progress.reading(f"reading {Path(bag).name}"),
        )
        found = check_start(reader, wanted, base, start, end)
        to_score = _to_score(reader, wanted, start, end)
    if not use_truth:
        recording = recording._replace(truth=Track._make(each[:0] for each in recording.truth))
    suits = suitability(recording, base, found)
    recording = recording._replace(notes=(*recording.notes, *suits.lines))
    known = recording.truth.stamps_ns.size > 0
    parts = excerpts(recording)
    truths = [_truth(each) if known else None for each in parts]
    if len(parts) > 1:
        parts, truths = _usable(parts, truths, int(recording.series.s1_ns[0]))
    return _Read(parts, truths, base, found.clocks_agree, to_score, suits.truth_is_wrong)


def _to_score(bag: BagReader, topics: Topics, start: float | None, end: float | None) -> list[Span]:
    """Return the spans of a bag that can be scored, those that are not fitted to first.

    Of these the longest comes first, and each has messages in its second half.
    """
    length = ((bag.end_ns or 0) - (bag.start_ns or 0)) * 1e-9
    first, last = start or 0.0, length if end is None else end
    least = _LONG_ENOUGH * (min(last, length) - first)

    def has_enough(begin: float | None, finish: float | None) -> bool:
        return all(
            len(list(islice(bag.messages([each], begin, finish), _ENOUGH))) == _ENOUGH
            for each in (topics.s1, topics.s2, topics.truth)
        )

    before: tuple[float, float, Span] = (first, 0.5 * first, (None, start))
    after: tuple[float, float, Span] = (length - last, 0.5 * (last + length), (end, None))
    left_out = [
        span
        for duration, middle, span in sorted((after, before), key=itemgetter(0), reverse=True)
        if duration > least and has_enough(middle, span[1])
    ]
    return left_out + ([(start, end)] if has_enough(start, end) else [])


def _usable(
    parts: Sequence[Recording], truths: Sequence[Reals | None], first_ns: int
) -> tuple[list[Recording], list[Reals | None]]:
    """Skip excerpts that cannot be used for fitting, such as those in a gap of the truth.

    Args:
        parts: The excerpts.
        truths: The truth in each, if there is one.
        first_ns: Stamp of the first sample of S1 in the whole recording.

    Raises:
        FusionError: No excerpt can be used for fitting.
    """
    kept, notes, why = [], list(parts[0].notes), ""
    for part, truth in zip(parts, truths, strict=True):
        why = why_unusable(Trial(part.series, truth))
        if why:
            begin, end = (part.series.s1_ns[[0, -1]] - first_ns) * 1e-9
            notes.append(f"the excerpt from {begin:.0f} s to {end:.0f} s is skipped: {why}")
        else:
            kept.append((part, truth))
    if not kept:
        raise FusionError(f"{parts[0].name}: no excerpt can be used for fitting: {why}")
    recordings = [part for part, _ in kept]
    recordings[0] = recordings[0]._replace(notes=tuple(notes))
    return recordings, [truth for _, truth in kept]


def _require_same_types(read: Sequence[_Read]) -> None:
    """Check that one set of parameters can serve all bags.

    Raises:
        FusionError: The sensors of a bag have other types or fields than those of the first.
    """
    first = flatten(read[0].base)
    for each in read[1:]:
        for name, value in flatten(each.base).items():
            if value != first[name]:
                raise FusionError(
                    f"{each.recordings[0].name}: {name} is {value!r}, in "
                    f"{read[0].recordings[0].name} it is {first[name]!r}: tune to bags of the same "
                    "sensors only"
                )


def _require_truth_in_all_or_none(read: Sequence[_Read]) -> None:
    """Check that all errors can be against a truth, or all against a reference.

    Raises:
        FusionError: Some bags have a truth, and others have none.
    """
    without = [each.recordings[0].name for each in read if each.truths[0] is None]
    if without and len(without) < len(read):
        raise FusionError(
            f"{without[0]} has no truth, and other bags have one: leave it out, or ignore the "
            "truth of all bags with --no-truth"
        )


def _with_types(bag: BagReader, topics: Topics, parameters: Parameters) -> Parameters:
    """Return the parameters with the types and fields that the sensors have in the bag."""
    topics.require_in(bag)
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
    return nearest(truth, held_s2(recording.series), recording.period)


def _origin(
    bags: Sequence[str | Path],
    start: float | None,
    end: float | None,
    seed: int,
    with_truth: bool,
) -> str:
    names = [Path(each).name for each in bags]
    shown = ", ".join(names) if len(names) <= _NAMED else f"{names[0]} and {len(names) - 1} more"
    span = "" if start is end is None else f", --start {start or 0.0:g}"
    span += "" if end is None else f" --end {end:g}"
    whose = "its" if len(names) == 1 else "their"
    target = "what both sensors say in hindsight, without a truth"
    return f"{shown}{span}, --seed {seed}, fitted to {f'{whose} truth' if with_truth else target}"
