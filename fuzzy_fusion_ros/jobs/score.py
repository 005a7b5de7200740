# SPDX-License-Identifier: Apache-2.0
"""Scores a bag: the estimate, both sensors and every baseline against the truth."""

from __future__ import annotations

from pathlib import Path

from fuzzy_fusion_ros.baselines import BaselineParameters
from fuzzy_fusion_ros.batch.arrays import Flags, Reals
from fuzzy_fusion_ros.batch.compiled import can_compile
from fuzzy_fusion_ros.batch.series import Series
from fuzzy_fusion_ros.jobs.parameter_file import Source, baseline_parameters, fusion_parameters
from fuzzy_fusion_ros.jobs.progress import SILENT, Progress
from fuzzy_fusion_ros.offline.topics import Topics
from fuzzy_fusion_ros.scoring.score import Fit, Score, score_bag

NOT_FITTED = "numba is not installed, so the baselines were not fitted: it would take too long"


def score(
    bag: str | Path,
    *,
    parameters: Source = None,
    topics: Topics | None = None,
    start: float | None = None,
    end: float | None = None,
    unit: str | None = None,
    fit_baselines: bool = True,
    progress: Progress = SILENT,
) -> Score:
    """Score the estimate in a bag, S1, S2 and every baseline against the truth.

    The estimate is the one in the bag; if there is none, the fusion is run here.

    Args:
        bag: A rosbag2 directory or an ``.mcap`` file, with a truth topic.
        parameters: Of the fusion, or the YAML file with them; the defaults unless given. A file
            that ``tune`` wrote also holds those of the baselines.
        topics: Where sensors, estimate and truth are; ``/s1``, ``/s2``, ``/estimate`` and
            ``/truth`` unless given.
        start: Where scoring starts, seconds from the first message of the bag; every filter runs
            from the first message on.
        end: Where it ends, seconds from the first message of the bag.
        unit: Unit of the signal; unless given, that of the message type, if it has one.
        fit_baselines: Whether baselines that the file does not have are fitted to the span that
            is scored, which takes a while; otherwise they are derived from rates and noise.
        progress: Shows progress; none is shown unless given.

    Raises:
        FusionError: The bag or the parameters cannot be used, or no estimate has a truth.
    """
    wanted = topics or Topics()
    baselines: BaselineParameters | Fit | None = baseline_parameters(parameters, wanted.channel)
    notes: tuple[str, ...] = ()
    if baselines is None and fit_baselines:
        if can_compile():
            baselines = _fit(progress)
        else:
            notes = (NOT_FITTED,)
    scored = score_bag(
        bag,
        wanted,
        fusion_parameters(parameters).channel(wanted.channel),
        baselines,
        start,
        end,
        progress.reading(f"reading {Path(bag).name}"),
    )
    return scored._replace(
        unit=scored.unit if unit is None else unit, notes=(*notes, *scored.notes)
    )


def _fit(progress: Progress) -> Fit:
    def fit(series: Series, truth: Reals, where: Flags) -> BaselineParameters:
        from fuzzy_fusion_ros.tuning import fit_baselines  # costs start-up time

        with progress.counted("fitting the baselines", " runs") as advance:
            return fit_baselines(series, truth, where, progress=advance).parameters

    return fit
