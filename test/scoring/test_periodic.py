# SPDX-License-Identifier: Apache-2.0
"""A heading that wraps, from bag to score: everything is compared the short way."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from bag.recorded import Scalar, write_scalars
from tuning.quick import be_quick

from fuzzy_fusion_ros.bag import open_bag
from fuzzy_fusion_ros.core.periodic import nearest
from fuzzy_fusion_ros.jobs.tune import tune
from fuzzy_fusion_ros.offline.replay import replay
from fuzzy_fusion_ros.offline.topics import Topics
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import replace
from fuzzy_fusion_ros.scoring.score import score_bag

TURN = 2.0 * math.pi
HEADING = replace(Parameters(), {"signal.period": TURN})
LINE = Parameters()
RATE = replace(HEADING, {"s1.kind": "rate"})


def heading(time_s: float) -> float:
    return 0.8 * time_s + 0.3 * math.sin(2.0 * time_s)


def scalars(wraps: bool = True, rate: bool = False) -> list[Scalar]:
    """20 s of S1 at 50 Hz, off by 0.1, S2 at 5 Hz and 0.1 s late, and truth at 20 Hz."""

    def wrapped(value: float) -> float:
        return nearest(value, 0.0, TURN) if wraps else value

    found = []
    for k in range(1000):
        time_s = 0.02 * k
        if k % 5 == 0:
            found.append(Scalar("/truth", time_s, wrapped(heading(time_s))))
        if k % 10 == 0:
            found.append(Scalar("/s2", time_s, wrapped(heading(time_s - 0.1))))
        s1 = 0.82 + 0.6 * math.cos(2.0 * time_s) if rate else wrapped(heading(time_s) + 0.1)
        found.append(Scalar("/s1", time_s, s1))
    return found


@pytest.mark.parametrize(("parameters", "rate"), [(HEADING, False), (RATE, True)])
def test_a_bag_and_its_replay_score_the_same(
    tmp_path: Path, parameters: Parameters, rate: bool
) -> None:
    path = write_scalars(tmp_path / "bag", scalars(rate=rate))
    with open_bag(path) as bag:
        replay(bag, tmp_path / "replayed", Topics(), parameters)
    raw, replayed = (
        score_bag(each, Topics(), parameters) for each in (path, tmp_path / "replayed")
    )
    assert (raw.recomputed, replayed.recomputed) == (True, False)
    assert np.array_equal(raw.values["estimate"], replayed.values["estimate"])
    assert "weight" in replayed.behind
    assert raw.matched > 990
    assert max(raw.scores(name)["max"] for name in raw.values) < 0.8


def test_scores_are_those_of_the_same_signal_without_wraps(tmp_path: Path) -> None:
    wrapped = score_bag(write_scalars(tmp_path / "wrapped", scalars()), Topics(), HEADING)
    line = score_bag(write_scalars(tmp_path / "line", scalars(wraps=False)), Topics(), LINE)
    for name in line.values:
        assert wrapped.scores(name) == pytest.approx(line.scores(name), abs=1e-9)


@pytest.mark.parametrize(("parameters", "rate"), [(HEADING, False), (RATE, True)])
def test_it_is_tuned_to_a_truth_that_wraps(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, parameters: Parameters, rate: bool
) -> None:
    be_quick(monkeypatch)
    path = write_scalars(tmp_path / "bag", scalars(rate=rate))
    result = tune(path, parameters=parameters)
    assert result.parameters.signal.period == TURN
    assert result.tuned.error < 0.1
