"""Fits the parameters to a recording, with or without a truth, and writes them for fusion_node.

It prints what the sensors are like, fits candidates from either sensor alone to the whole fusion,
and chooses the first that does well on parts of the recording that it was not fitted to. The
baselines are fitted to the same target and written into the same file, for score --params.
Without a truth it fits to a reference that it reconstructs from both sensors with hindsight.
"""

from __future__ import annotations

import argparse
import importlib.util
import sys
import tempfile
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TextIO

import numpy as np

from fuzzy_fusion_ros.bag import open_bag
from fuzzy_fusion_ros.cli import options
from fuzzy_fusion_ros.cli.progress import counted, progress
from fuzzy_fusion_ros.cli.score import NODE_OF_BASELINES
from fuzzy_fusion_ros.cli.status import DONE, command, say
from fuzzy_fusion_ros.offline.recording import Recording, read_recording
from fuzzy_fusion_ros.offline.topics import Topics, codecs_of
from fuzzy_fusion_ros.parameters.file import dump
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import replace
from fuzzy_fusion_ros.scoring.join import interpolated
from fuzzy_fusion_ros.tuning import Tuned, tune
from fuzzy_fusion_ros.tuning.reference import in_gaps
from fuzzy_fusion_ros.tuning.report import as_json, candidate_lines, comments, described, outcome

OUTPUT = "tuned.yaml"


@command("tune")
def main(arguments: Sequence[str] | None = None) -> int:
    """Tune to a bag."""
    given = _parser().parse_args(arguments)
    _require_writable(given)
    recording, parameters = _read(given)
    for note in recording.notes:
        say("tune", f"{recording.name}: {note}")
    tuned = _tune(given, recording, parameters)
    unit = recording.unit if given.unit is None else given.unit
    out = sys.stderr if given.json == "-" else sys.stdout
    _print([*described(tuned.sensors, unit), "", *candidate_lines(tuned, unit), ""], out)
    with options.writing(given.output):
        write(tuned, given.output, comments(tuned, unit, _origin(given, tuned)))
    if given.plot:
        _plot(tuned, recording, unit, given.plot)
    if given.json:
        options.write_json(as_json(tuned, unit), given.json)
    _print([outcome(tuned, unit), f"written; take it so: {_command(given)}"], out)
    return DONE


def write(tuned: Tuned, path: str | Path, lines: Iterable[str]) -> None:
    """Write the fusion's parameters, and those of the baselines as an entry of their own.

    Args:
        tuned: What came out.
        path: The file, overwritten if it exists.
        lines: Comments to write at the top.

    Raises:
        ParameterError: It cannot be written.
    """
    target = Path(path)
    target.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        second = Path(folder, "baselines.yaml")
        dump(tuned.baselines, second, node_name=NODE_OF_BASELINES)
        dump(tuned.parameters, target, lines)
        with target.open("a", encoding="utf-8") as file:
            file.write(second.read_text(encoding="utf-8"))


def _require_writable(given: argparse.Namespace) -> None:
    """Refuse what cannot be written before the fit, not after it."""
    options.require_writable(given.output, given.json, given.plot)
    if given.plot:
        from fuzzy_fusion_ros.plots.style import require_format  # costs start-up time

        require_format(given.plot)


def _read(given: argparse.Namespace) -> tuple[Recording, Parameters]:
    """Read the recording; also the parameters, with the types and fields that it has."""
    start_s, end_s = options.window_of(given)
    topics = options.topics_of(given)
    parameters = options.parameters_of(given)
    with open_bag(given.bag) as bag:
        if not given.no_truth and topics.truth != Topics().truth:
            bag.require_topics(topics.truth)
        recording = read_recording(
            bag,
            topics,
            parameters,
            start_s,
            end_s,
            lambda messages: progress(messages, f"reading {given.bag}", unit=" messages"),
        )
        codecs = codecs_of(bag, topics, parameters)
        return recording, replace(
            parameters,
            {
                "s1.type": bag.topics[topics.s1].msgtype,
                "s1.field": codecs["s1"].field.text,
                "s2.type": bag.topics[topics.s2].msgtype,
                "s2.field": codecs["s2"].field.text,
            },
        )


def _tune(given: argparse.Namespace, recording: Recording, parameters: Parameters) -> Tuned:
    truth = None
    if not given.no_truth and recording.truth.stamps_ns.size:
        truth = interpolated(recording.truth, recording.series.s1_ns)
        truth[in_gaps(recording.truth.stamps_ns, recording.series.s1_ns)] = np.nan
    if importlib.util.find_spec("numba") is None:
        say("tune", "numba is not installed, so this takes a hundred times longer: install it")
    with counted("tuning", " runs") as advance:
        return tune(recording.series, truth, parameters, given.seed, progress=advance)


def _plot(tuned: Tuned, recording: Recording, unit: str, path: str) -> None:
    from fuzzy_fusion_ros.plots.tuning import plot_tuning  # costs start-up time

    plot_tuning(tuned, recording.series, unit, path)


def _origin(given: argparse.Namespace, tuned: Tuned) -> str:
    start_s, end_s = options.window_of(given)
    span = "" if start_s is end_s is None else f", --start {start_s or 0:g}"
    span += "" if end_s is None else f" --end {end_s:g}"
    against = (
        "its truth" if tuned.with_truth else "no truth: to what both sensors say with hindsight"
    )
    return f"{Path(given.bag).name}{span}, --seed {given.seed}, fitted to {against}"


def _command(given: argparse.Namespace) -> str:
    """Return how to run the node on the topics that were fitted to."""
    topics = options.topics_of(given)
    remaps = [
        f"-r {role}:={topic}"
        for role, topic in (("s1", topics.s1), ("s2", topics.s2))
        if topic != f"/{role}"
    ]
    return " ".join(["fusion_node --ros-args --params-file", given.output, *remaps])


def _print(lines: Iterable[str], out: TextIO) -> None:
    for line in lines:
        print(line, file=out)


def _parser() -> options.Parser:
    parser = options.Parser("tune", __doc__)
    parser.add_argument("bag", metavar="BAG", help="rosbag2 directory or .mcap")
    parser.add_argument(
        "--output",
        metavar="FILE",
        default=OUTPUT,
        help=f"parameter YAML to write {{{OUTPUT}, here}}",
    )
    options.add_params(parser)
    options.add_topics(parser)
    parser.add_argument(
        "--no-truth", action="store_true", help="do as if the bag had no truth, even if it has"
    )
    options.add_window(parser)
    options.add_seed(parser)
    parser.add_argument(
        "--unit", metavar="UNIT", help="unit of the signal {that of S2's type, if it has one}"
    )
    options.add_json(parser)
    options.add_plot(parser)
    return parser
