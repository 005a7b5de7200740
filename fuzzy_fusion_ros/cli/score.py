# SPDX-License-Identifier: Apache-2.0
"""Scores the estimate in a bag, S1, S2 and every baseline against the truth.

The truth is interpolated linearly at the header stamps of the estimates, never extrapolated, and
all estimators are scored at the same stamps. The estimate is the one in the bag; if there is none,
the fusion is run here, with --params. The baselines take their parameters from the --params file
if tune wrote it; otherwise the optimiser of tune fits them to the same span that is scored, which
flatters them.
"""

from __future__ import annotations

import argparse
import functools
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from fuzzy_fusion_ros.cli import fleet, options
from fuzzy_fusion_ros.cli.status import DONE, FAILED, command, say, show
from fuzzy_fusion_ros.jobs.fleet import Failure
from fuzzy_fusion_ros.parameters.arguments import Parser
from fuzzy_fusion_ros.parameters.errors import UsageError
from fuzzy_fusion_ros.text.table import bag_table

if TYPE_CHECKING:
    from fuzzy_fusion_ros.scoring.score import Score


@command("score")
def main(arguments: Sequence[str] | None = None) -> int:
    """Score one or several bags; return whether the estimate is no worse than before."""
    given = command_line().parse_args(arguments)
    topics, window = options.topics_of(given), options.window_of(given)
    options.require_results(given, *given.bag, given.params, given.baseline)
    from fuzzy_fusion_ros.jobs.score import score  # after parsing: takes time to import
    from fuzzy_fusion_ros.scoring.regression import read_scores

    before = read_scores(given.baseline) if given.baseline else None
    task = functools.partial(
        score,
        parameters=fleet.absolute(given.params, given),
        topics=topics,
        **window,
        unit=given.unit,
        progress=fleet.progress_of(given),
    )
    bags = fleet.bags_of(given)
    found = dict(zip(bags, fleet.run(task, {each: each for each in bags}, given), strict=True))
    scores = [each for each in found.values() if not isinstance(each, Failure)]
    _report(found, scores, given)
    status = DONE if len(scores) == len(found) else FAILED
    return status if before is None else max(status, _check(scores, before, given.tolerance))


def _report(
    found: Mapping[str, Score | Failure], scores: Sequence[Score], given: argparse.Namespace
) -> None:
    """Print, draw and write the scores."""
    from fuzzy_fusion_ros.scoring.report import report

    for each in scores:
        for note in each.notes:
            say("score", f"{each.name}: {note}")
    text = report(scores[0]) if len(found) == 1 else bag_table(_rows(found))
    show(text, on_stderr=given.json == "-")
    if given.plot:
        _plot(scores, given.plot)
    if given.report:
        _write_reports(scores, given.report, given)
    if given.json:
        documents = {each.name: each.as_json() for each in scores}
        failed = {
            bag: {"error": each.reason} for bag, each in found.items() if isinstance(each, Failure)
        }
        every = documents | failed
        options.write_json(next(iter(every.values())) if len(found) == 1 else every, given.json)


def _rows(found: Mapping[str, Score | Failure]) -> list[tuple[str, ...]]:
    head = ("bag: RMSE", "unit", "s1", "s2", "estimate", "of best", "best baseline")
    rows: list[tuple[str, ...]] = [head]
    for bag, each in found.items():
        if isinstance(each, Failure):
            rows.append(fleet.failed_row(bag, each, len(head)))
            continue
        best = each.best_baseline
        shown = dict.fromkeys(("s1", "s2", "estimate", best))
        rmse = {name: each.scores(name, ("rmse",))["rmse"] for name in shown}
        numbers = [f"{rmse[name]:.4g}" for name in ("s1", "s2", "estimate")]
        ratio = f"{rmse['estimate'] / rmse[best]:.2f}" if rmse[best] > 0.0 else ""
        rows.append((bag, each.unit, *numbers, ratio, f"{best}, {rmse[best]:.4g}"))
    return rows


def _plot(scores: Sequence[Score], path: str) -> None:
    from fuzzy_fusion_ros.jobs.outputs import one_for_each
    from fuzzy_fusion_ros.plots.traces import plot_score

    for each, target in zip(scores, one_for_each(path, [s.name for s in scores]), strict=True):
        plot_score(each, target)


def _write_reports(scores: Sequence[Score], path: str, given: argparse.Namespace) -> None:
    from fuzzy_fusion_ros.jobs.outputs import one_for_each
    from fuzzy_fusion_ros.jobs.parameter_file import fusion_parameters, text_of
    from fuzzy_fusion_ros.reports.page import write_page
    from fuzzy_fusion_ros.reports.score import score_page

    parameters = fusion_parameters(given.params).channel(given.channel)
    source = text_of(given.params)
    for each, target in zip(scores, one_for_each(path, [s.name for s in scores]), strict=True):
        write_page(score_page(each, parameters, source), target)


def _check(scores: Sequence[Score], before: dict[str, Any], percent: float) -> int:
    from fuzzy_fusion_ros.scoring.regression import regressions

    status = DONE
    for each in scores:
        name, document = each.name, each.as_json()
        earlier = before if "estimators" in before else before.get(name)
        if not isinstance(earlier, dict):
            raise UsageError(f"--baseline has no score of {name}; it has {', '.join(before)}")
        for problem in regressions(document, earlier, percent):
            say("score", f"{name}: worse than before by more than {percent:g} %: {problem}")
            status = FAILED
    return status


def command_line() -> Parser:
    """Return the parser of its arguments."""
    parser = Parser("score", __doc__)
    fleet.add_bags(parser)
    options.add_params(parser)
    options.add_topics(parser)
    options.add_window(parser)
    options.add_json(parser)
    options.add_plot(parser)
    options.add_report(parser)
    options.add_unit(parser)
    parser.add_argument(
        "--baseline",
        metavar="FILE",
        help="output of an earlier --json; exit with 1 if the estimate has become worse",
    )
    parser.add_argument(
        "--tolerance",
        metavar="PCT",
        type=options.number(0.0, 1e6),
        default=5.0,
        help="by how many percent it may become worse {5}",
    )
    return parser
