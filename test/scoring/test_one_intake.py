# SPDX-License-Identifier: Apache-2.0
"""Score, replay and node take samples through one intake, also while a sensor is silent."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from bag.recorded import Scalar, at, write_scalars

from fuzzy_fusion_ros.bag import open_bag
from fuzzy_fusion_ros.batch.arrays import Reals
from fuzzy_fusion_ros.core.sample import Sample
from fuzzy_fusion_ros.offline.replay import replay
from fuzzy_fusion_ros.offline.topics import Topics
from fuzzy_fusion_ros.online.fusion import Fusion
from fuzzy_fusion_ros.online.verdict import Fused
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import replace
from fuzzy_fusion_ros.scoring.score import Score, score_bag

NEVER = (math.inf, math.inf)
SILENT = {
    "none": (NEVER, NEVER),
    "s1 for 6 s": ((7.0, 13.0), NEVER),
    "s1 at the end": ((12.0, math.inf), NEVER),
    "s2 for 6 s": (NEVER, (7.0, 13.0)),
    "s2 at the start": (NEVER, (0.0, 8.0)),
}
RATE: dict[str, object] = {"s1.kind": "rate", "s1.bias_time_constant": 2.0, "s2.delay": 0.1}
SHORT = {"s1.timeout": 1.0, "s2.timeout": 1.0}


def scalars(s1_silent: tuple[float, float], s2_silent: tuple[float, float]) -> list[Scalar]:
    """Return sin t: S1 at 50 Hz and noisy, S2 at 10 Hz and late, each silent for a while."""
    found = []
    for k in range(1000):
        time_s = 0.02 * k
        found.append(Scalar("/truth", time_s, math.sin(time_s)))
        if k % 5 == 0 and not s2_silent[0] <= time_s < s2_silent[1]:
            found.append(Scalar("/s2", time_s, math.sin(time_s - 0.1)))
        if not s1_silent[0] <= time_s < s1_silent[1]:
            found.append(Scalar("/s1", time_s, math.sin(time_s) + 0.05 * (-1) ** k))
    return found


def both(tmp_path: Path, found: list[Scalar], parameters: Parameters) -> tuple[Score, Score]:
    """Score a bag as it is, and after a replay."""
    path = write_scalars(tmp_path / "raw", found)
    with open_bag(path) as bag:
        replay(bag, tmp_path / "replayed", Topics(), parameters)
    raw, replayed = (
        score_bag(each, Topics(), parameters) for each in (path, tmp_path / "replayed")
    )
    assert (raw.recomputed, replayed.recomputed) == (True, False)
    return raw, replayed


def held_s2(found: list[Scalar], times_s: Reals) -> Reals:
    """Return S2 held, straight from the samples."""
    s2 = [(each.time_s, each.value) for each in found if each.topic == "/s2"]
    return np.array([[value for at_s, value in s2 if at_s <= t + 1e-6][-1] for t in times_s])


@pytest.mark.parametrize("given", [{}, {"trigger": "timer"}, RATE])
@pytest.mark.parametrize("silent", SILENT)
def test_a_score_is_that_after_a_replay(
    tmp_path: Path, given: dict[str, object], silent: str
) -> None:
    parameters = replace(Parameters(), {**given, **SHORT})
    raw, replayed = both(tmp_path, scalars(*SILENT[silent]), parameters)
    assert raw.matched == replayed.matched > 400
    for name in raw.values:
        assert np.array_equal(raw.values[name], replayed.values[name]), name
    assert raw.modes == replayed.modes


@pytest.mark.parametrize("silent", SILENT)
def test_the_baseline_s2_is_s2_held(tmp_path: Path, silent: str) -> None:
    found = scalars(*SILENT[silent])
    path = write_scalars(tmp_path / "raw", found)
    score = score_bag(path, Topics(), replace(Parameters(), SHORT))
    assert np.array_equal(score.values["s2"], held_s2(found, score.time_s))


def test_while_s1_is_silent_estimates_are_scored_at_s2(tmp_path: Path) -> None:
    raw, _ = both(tmp_path, scalars((7.0, 13.0), NEVER), replace(Parameters(), SHORT))
    silent = (raw.time_s > 8.05) & (raw.time_s < 12.95)
    assert np.count_nonzero(silent) == 49
    assert np.array_equal(raw.values["estimate"][silent], raw.values["s2"][silent])
    assert set(raw.modes) == {"FUSED", "S2_ONLY"}


def test_the_recording_gives_what_a_node_would_publish(tmp_path: Path) -> None:
    parameters = replace(Parameters(), SHORT)
    found = scalars((7.0, 13.0), NEVER)
    node = Fusion(parameters)
    published: list[Fused] = []
    for each in found:
        receive = {"/s1": node.on_s1, "/s2": node.on_s2}.get(each.topic)
        if receive is not None:
            published += receive(Sample(at(each.time_s), each.value)).estimates
    raw = score_bag(write_scalars(tmp_path / "raw", found), Topics(), parameters)
    assert raw.of == len(published)
    assert raw.values["estimate"].tolist() == [fused.estimate.value for fused in published]


def test_clocks_apart_and_an_estimate_of_one_sensor_throughout_are_named(tmp_path: Path) -> None:
    """S2's stamps are 5 s behind those of all others: it is always lost."""
    found = [
        each._replace(time_s=each.time_s - 5.0 * (each.topic == "/s2"), log_s=each.time_s)
        for each in scalars(NEVER, NEVER)
    ]
    path = write_scalars(tmp_path / "bag", found)
    score = score_bag(path, Topics(), replace(Parameters(), SHORT))
    assert score.modes == {"S1_ONLY": 1.0}
    notes = "\n".join(score.notes)
    assert "WARN s2's stamps are 5.0 s behind s1's" in notes
    assert "the estimate is s1 alone throughout" in notes


def test_sensors_that_are_equal_are_not_said_to_be_alone(tmp_path: Path) -> None:
    found = [each._replace(value=1.0) for each in scalars(NEVER, NEVER)]
    score = score_bag(write_scalars(tmp_path / "bag", found), Topics(), Parameters())
    assert not [note for note in score.notes if "alone throughout" in note]
