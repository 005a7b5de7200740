# SPDX-License-Identifier: Apache-2.0
"""Fits the parameters to a recording, with or without a truth, and writes them for fusion_node.

It characterises the sensors, fits candidates from either sensor alone up to the whole fusion, and
chooses the simplest whose error on parts left out of the fit is at most 10 % above the smallest.
Several recordings of the same sensors get one set of parameters; each is then a part. The baselines
are fitted to the same target and written to the same file, for score --params. Without a truth the
target is what S2 says, and errors are measured against a reference reconstructed from both sensors
with hindsight.
"""

from __future__ import annotations

import argparse
import shlex
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from fuzzy_fusion_ros.cli import fleet, options
from fuzzy_fusion_ros.cli.progress import BARS
from fuzzy_fusion_ros.cli.status import DONE, command, say, show
from fuzzy_fusion_ros.parameters.arguments import Parser, called

if TYPE_CHECKING:
    from fuzzy_fusion_ros.jobs.tune import TuneResult

OUTPUT = "tuned.yaml"

NO_NUMBA = (
    "without numba this takes about 100 times as long; install it with the extra `speed`: "
    "pip install '.[speed]'"
)


@command("tune")
def main(arguments: Sequence[str] | None = None) -> int:
    """Tune to one or several bags."""
    given = command_line().parse_args(arguments)
    topics, window = options.topics_of(given), options.window_of(given)
    from fuzzy_fusion_ros.batch.compiled import can_compile
    from fuzzy_fusion_ros.jobs.tune import tune  # after parsing: takes time to import

    options.require_results(given, *given.bag, given.params, more=[given.output])
    if not can_compile():
        say("tune", NO_NUMBA)
    result = tune(
        fleet.bags_of(given),
        given.output,
        parameters=given.params,
        topics=topics,
        **window,
        use_truth=not given.no_truth,
        unit=given.unit,
        seed=given.seed,
        jobs=given.jobs,
        progress=BARS,
    )
    _report(result, given)
    return DONE


def _report(result: TuneResult, given: argparse.Namespace) -> None:
    """Print what was found; draw and write it where asked to."""
    from fuzzy_fusion_ros.tuning import report

    tuned, unit = result.tuned, result.unit
    names = result.names
    odd = report.recording_notes(tuned, unit, len(result.first_of_bags) == 1)
    for name, each, own in zip(names, result.recordings, odd, strict=True):
        for note in each.notes:
            say("tune", f"{each.name}: {note}")
        for note in own:
            say("tune", f"{name}: {note}")
    parts = [report.described(tuned.sensors, unit), report.candidate_lines(tuned, unit)]
    if names[1:]:
        parts.append(report.recording_lines(tuned, unit, names))
    commands = [_offline_command(result, given), f"run the node with: {_node_command(given)}"]
    parts.append([report.outcome(tuned, unit), "parameters written", *commands])
    show("\n\n".join("\n".join(each) for each in parts), on_stderr=given.json == "-")
    if given.plot:
        _plot(result, given.plot)
    if given.report:
        _write_reports(result, given.report)
    if given.json:
        options.write_json(report.as_json(tuned, unit, names), given.json)


def _plot(result: TuneResult, path: str) -> None:
    from fuzzy_fusion_ros.plots.tuning import plot_tuning

    for k, target in _files(result, path):
        plot_tuning(result.tuned.on(k), result.recordings[k].series, result.unit, target)


def _write_reports(result: TuneResult, path: str) -> None:
    from fuzzy_fusion_ros.reports.page import write_page
    from fuzzy_fusion_ros.reports.tune import tune_page

    text, unit = result.text(), result.unit
    for k, target in _files(result, path):
        page = tune_page(
            result.tuned.on(k),
            result.recordings[k].series,
            unit,
            result.names[k],
            result.origin,
            text,
            of_several=len(result.recordings) > 1,
        )
        write_page(page, target)


def _files(result: TuneResult, path: str) -> Iterator[tuple[int, Path]]:
    """Yield for each bag which recording to show, and the file."""
    from fuzzy_fusion_ros.jobs.outputs import one_for_each

    shown = result.first_of_bags
    names = [result.recordings[k].name for k in shown]
    yield from zip(shown, one_for_each(path, names), strict=True)


def _node_command(given: argparse.Namespace) -> str:
    """Return the command that runs the node on the topics that were fitted to."""
    topics = options.other_topics(given, ("s1", "s2"))
    remaps = [text for role, topic in topics.items() for text in ("-r", f"{role}:={topic}")]
    options_of_ros = shlex.join(["--ros-args", "--params-file", given.output, *remaps])
    return f"{called('fusion_node')} {options_of_ros}"


def _offline_command(result: TuneResult, given: argparse.Namespace) -> str:
    """Return the command that scores the parameters, or replays the bags where they lack a truth.

    It scores what was left out of the fit, if there is enough.
    """
    arguments = [*given.bag, "--params", given.output]
    for role, topic in options.other_topics(given).items():
        arguments += [f"--{role}", topic]
    for path in given.field:
        arguments += ["--field", path]
    arguments += ["--channel", given.channel] if given.channel else []
    if result.to_score is None:
        return f"replay with: {called('replay')} {shlex.join(arguments)}"
    for name, limit in zip(("--start", "--end"), result.to_score, strict=True):
        arguments += [] if limit is None else [name, f"{limit:.12g}"]
    arguments += ["--unit", given.unit] if given.unit else []
    return f"score with: {called('score')} {shlex.join(arguments)}"


def command_line() -> Parser:
    """Return the parser of its arguments."""
    parser = Parser("tune", __doc__)
    fleet.add_local_bags(
        parser,
        "read this many bags at a time, each in its own process; fits use all cores {1}",
    )
    parser.add_argument(
        "--output",
        metavar="FILE",
        default=OUTPUT,
        help=f"parameter YAML to write {{{OUTPUT} in the current directory}}",
    )
    options.add_params(parser)
    options.add_topics(parser)
    parser.add_argument("--no-truth", action="store_true", help="ignore the truth topic")
    options.add_window(parser)
    options.add_seed(parser)
    options.add_unit(parser)
    options.add_json(parser)
    options.add_plot(parser)
    options.add_report(parser)
    return parser
