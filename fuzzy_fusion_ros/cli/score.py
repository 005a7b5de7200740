"""Scores the estimate in a bag, S1, S2 and every baseline against the truth.

Truth is joined by header stamp, linearly between its samples, never beyond them; all estimators
are scored at the same stamps. The estimate is the bag's own; for a bag without one the fusion
runs here, with --params. The baselines have the parameters that tune wrote beside ours into the
file of --params; else they are fitted here, by the same optimiser, to the very span that is
scored, so that they look better than they would on any other.
"""

from __future__ import annotations

import argparse
import importlib.util
import sys
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fuzzy_fusion_ros.baselines import BaselineParameters
from fuzzy_fusion_ros.batch.arrays import Reals
from fuzzy_fusion_ros.batch.series import Series
from fuzzy_fusion_ros.cli import options
from fuzzy_fusion_ros.cli.progress import counted, progress
from fuzzy_fusion_ros.cli.status import DONE, FAILED, UsageError, command, say
from fuzzy_fusion_ros.parameters.file import ParameterFileError, load
from fuzzy_fusion_ros.parameters.group import flatten, replace
from fuzzy_fusion_ros.scoring.regression import read_scores, regressions
from fuzzy_fusion_ros.scoring.report import report
from fuzzy_fusion_ros.scoring.score import Fit, Score, score_bag

NODE_OF_BASELINES = "baselines"
"""The entry of a parameter file that holds the parameters of the baselines."""


@command("score")
def main(arguments: Sequence[str] | None = None) -> int:
    """Score one or several bags; return whether nothing got worse."""
    given = _parser().parse_args(arguments)
    before = read_scores(given.baseline) if given.baseline else None
    baselines = baselines_of(given.params) or _fit()
    scores = [_score(given, path, baselines) for path in given.bag]
    for each in scores:
        for note in each.notes:
            say("score", f"{each.name}: {note}")
    print(report(scores), file=sys.stderr if given.json == "-" else sys.stdout)
    if given.plot:
        _plot(scores, given.plot)
    documents = {each.name: each.as_json() for each in scores}
    if given.json:
        options.write_json(_only(documents), given.json)
    return _check(documents, before, given.tolerance) if before is not None else DONE


def _fit() -> Fit | None:
    """Return what fits the baselines, ``None`` where that would take too long."""
    if importlib.util.find_spec("numba") is None:
        say("score", "numba is not installed, so the baselines are not fitted: that takes too long")
        return None

    def fit(series: Series, truth: Reals, where: NDArray[np.bool_]) -> BaselineParameters:
        from fuzzy_fusion_ros.tuning import fit_baselines  # costs start-up time

        with counted("fitting the baselines", " runs") as advance:
            return fit_baselines(series, truth, where, progress=advance).parameters

    return fit


def _score(
    given: argparse.Namespace, path: str, baselines: BaselineParameters | Fit | None
) -> Score:
    start_s, end_s = options.window_of(given)
    scored = score_bag(
        path,
        options.topics_of(given),
        options.parameters_of(given),
        baselines,
        start_s,
        end_s,
        lambda messages: progress(messages, f"reading {path}", unit=" messages"),
    )
    return scored._replace(unit=given.unit if given.unit is not None else scored.unit)


def baselines_of(path: str | None) -> BaselineParameters | None:
    """Return the baselines' parameters in a parameter file, ``None`` if it has none.

    Raises:
        ParameterError: A value is not allowed.
    """
    try:
        values = load(path, NODE_OF_BASELINES) if path else {}
    except ParameterFileError:
        return None
    known = flatten(BaselineParameters())
    own = {name: value for name, value in values.items() if name in known}
    return replace(BaselineParameters(), own) if own else None


def _plot(scores: Sequence[Score], path: str) -> None:
    from fuzzy_fusion_ros.plots.traces import plot_paths, plot_score  # costs start-up time

    for each, target in zip(scores, plot_paths(path, scores), strict=True):
        plot_score(each, target)


def _only(documents: dict[str, dict[str, Any]]) -> dict[str, Any]:
    """Return the one score as it is, several by the names of their bags."""
    return next(iter(documents.values())) if len(documents) == 1 else documents


def _check(documents: dict[str, dict[str, Any]], before: dict[str, Any], percent: float) -> int:
    status = DONE
    for name, document in documents.items():
        earlier = before if len(documents) == 1 else before.get(name)
        if not isinstance(earlier, dict):
            raise UsageError(f"--baseline has no score of {name}: it has {', '.join(before)}")
        for problem in regressions(document, earlier, percent):
            say("score", f"{name}: worse than before by more than {percent:g} %: {problem}")
            status = FAILED
    return status


def _parser() -> options.Parser:
    parser = options.Parser("score", __doc__)
    parser.add_argument(
        "bag", metavar="BAG", nargs="+", help="rosbag2 directory or .mcap; several side by side"
    )
    options.add_params(parser)
    options.add_topics(parser)
    options.add_window(parser)
    options.add_json(parser)
    options.add_plot(parser)
    parser.add_argument(
        "--unit", metavar="TEXT", help="unit of the signal {what standard types say, else none}"
    )
    parser.add_argument(
        "--baseline", metavar="FILE", help="earlier --json; exit 1 if the estimate got worse"
    )
    parser.add_argument(
        "--tolerance",
        metavar="PCT",
        type=options.number(0.0, 1e6),
        default=5.0,
        help="how much worse it may get, in percent {5}",
    )
    return parser
