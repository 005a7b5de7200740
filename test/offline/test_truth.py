# SPDX-License-Identifier: Apache-2.0
"""What is said of S1, S2 and a truth that do not suit each other, and nothing of those that do."""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np
import pytest
from bag.recorded import Scalar, write_scalars

from fuzzy_fusion_ros.bag import open_bag
from fuzzy_fusion_ros.batch.arrays import Reals
from fuzzy_fusion_ros.offline.check import check_start
from fuzzy_fusion_ros.offline.recording import read_recording
from fuzzy_fusion_ros.offline.topics import Topics
from fuzzy_fusion_ros.offline.tracks import Track
from fuzzy_fusion_ros.offline.truth import Suitability, suitability
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import replace

AGREE = "WARN s1 and s2 agree, but"
BAGS = Path(__file__).resolve().parents[2] / "bags"
TIME_S = np.arange(3000) * 0.02
FREQUENCIES = np.array([0.37, 0.83, 1.9])


def signal(time_s: Reals) -> Reals:
    """Return a signal that moves at several frequencies, rad/s."""
    found: Reals = np.sin(np.multiply.outer(time_s, FREQUENCIES) + FREQUENCIES**2).sum(axis=-1)
    return found


def rate(time_s: Reals) -> Reals:
    """Return its time derivative."""
    phases = np.multiply.outer(time_s, FREQUENCIES) + FREQUENCIES**2
    found: Reals = (FREQUENCIES * np.cos(phases)).sum(axis=-1)
    return found


def suited(
    path: Path, changes: dict[str, object] | None = None, start_s: float | None = None
) -> Suitability:
    parameters = replace(Parameters(), changes or {})
    with open_bag(path) as bag:
        found = check_start(bag, Topics(), parameters)
        recording = read_recording(bag, Topics(), parameters)
    return suitability(recording, parameters, found, start_s)


def warned(
    path: Path, changes: dict[str, object] | None = None, start_s: float | None = None
) -> tuple[str, ...]:
    return suited(path, changes, start_s).lines


def recorded(path: Path, truth: Reals, s1: Reals | None = None, s2: Reals | None = None) -> Path:
    """Record S1 at 50 Hz, with bias, drift and noise, S2 at 10 Hz, 0.2 s late, and a truth."""
    random = np.random.default_rng(1)
    if s1 is None:
        s1 = signal(TIME_S) + 0.5 + 0.02 * TIME_S
    if s2 is None:
        s2 = signal(TIME_S - 0.2)
    s1 = s1 + 0.1 * random.standard_normal(TIME_S.size)
    scalars = []
    for k, time_s in enumerate(TIME_S.tolist()):
        scalars += [Scalar("/s1", time_s, s1[k]), Scalar("/truth", time_s, truth[k])]
        if k % 5 == 0:
            scalars.append(Scalar("/s2", time_s, s2[k]))
    return write_scalars(path, scalars)


def frozen() -> Reals:
    """Return a truth that repeats its value from 30 s to 38 s."""
    return np.where((TIME_S >= 30.0) & (TIME_S < 38.0), signal(np.array(30.0)), signal(TIME_S))


@pytest.mark.parametrize(
    ("truth", "said"),
    [
        (-signal(TIME_S), f"{AGREE} the truth has the opposite sign of s2 (correlation -"),
        (
            np.degrees(signal(TIME_S)),
            f"{AGREE} the truth reads 57.3 times what s2 reads: degrees against radians (ratio ",
        ),
        (signal(TIME_S - 0.6), "WARN the truth lags s1 by 0.6"),
        (signal(TIME_S + 0.6), "WARN the truth leads s1 by 0.6"),
        (rate(TIME_S), f"{AGREE} the truth is the rate of s2 (correlation "),
        (
            frozen(),
            "WARN the truth repeats its last value while s1 and s2 move, once from 30.0 s to "
            "38.0 s: ",
        ),
        (
            np.clip(signal(TIME_S), -0.8, 1.0),
            "WARN the truth saturates at -0.8 and 1: ",
        ),
        (
            signal(0.7 * TIME_S[::-1]),
            f"{AGREE} the truth and s2 are correlated no better than by chance (correlation ",
        ),
        (
            np.random.default_rng(2).standard_normal(TIME_S.size),
            f"{AGREE} the truth shows nothing of their motion (correlation ",
        ),
        (
            np.where(TIME_S < 30.0, 1.0, -1.0) * signal(TIME_S),
            f"{AGREE} the truth has the sign of s2 until 29.9 s and the opposite from 30.0 s on (",
        ),
    ],
    ids=[
        *("sign", "unit", "lag", "lead", "rate", "frozen", "saturated", "another", "noise"),
        "changed",
    ],
)
def test_each_fault_of_a_truth_has_its_line(tmp_path: Path, truth: Reals, said: str) -> None:
    (line,) = warned(recorded(tmp_path / "bag", truth))
    assert line.startswith(said)
    assert "; fix: " in line


@pytest.mark.parametrize("bag", sorted(each.parent.name for each in BAGS.glob("*/metadata.yaml")))
def test_no_recording_of_ours_gives_a_warning(bag: str) -> None:
    assert warned(BAGS / bag) == ()


def test_an_offset_is_no_fault(tmp_path: Path) -> None:
    assert warned(recorded(tmp_path / "bag", signal(TIME_S) + 3.0)) == ()


def test_an_s1_that_is_a_rate_is_compared_as_one(tmp_path: Path) -> None:
    changes: dict[str, object] = {"s1.kind": "rate"}
    assert warned(recorded(tmp_path / "right", signal(TIME_S), rate(TIME_S)), changes) == ()
    (line,) = warned(recorded(tmp_path / "wrong", -signal(TIME_S), rate(TIME_S)), changes)
    assert line.startswith(f"{AGREE} the truth has the opposite sign of s2")


def test_an_angle_is_compared_across_its_wraps(tmp_path: Path) -> None:
    def wrapped(values: Reals) -> Reals:
        return np.remainder(values + math.pi, 2.0 * math.pi) - math.pi

    s1, s2 = (wrapped(3.0 * signal(TIME_S - late)) for late in (0.0, 0.2))
    changes: dict[str, object] = {"signal.period": 2.0 * math.pi}
    assert warned(recorded(tmp_path / "right", s1, s1, s2), changes) == ()
    late = wrapped(3.0 * signal(TIME_S - 0.6))
    (line,) = warned(recorded(tmp_path / "late", late, s1, s2), changes)
    assert line.startswith("WARN the truth lags s1 by 0.6")


def test_sensors_and_truth_at_rest_are_no_fault(tmp_path: Path) -> None:
    rests = (TIME_S >= 30.0) & (TIME_S < 38.0)
    still = np.array(30.0)
    s1 = np.where(rests, signal(still), signal(TIME_S)) + 0.5
    s2 = np.where(rests, signal(still - 0.2), signal(TIME_S - 0.2))
    assert warned(recorded(tmp_path / "bag", frozen(), s1, s2)) == ()


@pytest.mark.parametrize(
    ("signs", "said"),
    [
        ((-1.0, 1.0, 1.0), "the truth and s2 agree, but s1 has the opposite sign of s2"),
        ((1.0, -1.0, 1.0), "s1 and the truth agree, but s2 has the opposite sign of the truth"),
        ((1.0, 1.0, -1.0), "s1 and s2 agree, but the truth has the opposite sign of s2"),
    ],
)
def test_of_three_the_one_that_differs_is_wrong(
    tmp_path: Path, signs: tuple[float, float, float], said: str
) -> None:
    s1, s2, truth = (
        sign * signal(TIME_S - late) for sign, late in zip(signs, (0.0, 0.2, 0.0), strict=True)
    )
    (line,) = warned(recorded(tmp_path / "bag", truth, s1, s2))
    assert line.startswith(f"WARN {said} (correlation -")
    remedies = {"s1": "fix: s1.scale: -1", "s2": "fix: s2.scale: -1"}
    remedy = next((each for name, each in remedies.items() if f"but {name} " in line), None)
    assert line.endswith(
        remedy
        or "fix: give the truth the sign and unit of s1, or choose another topic or field for it"
    )


def test_a_fix_of_s2_multiplies_the_scale_that_is_set(tmp_path: Path) -> None:
    path = recorded(tmp_path / "bag", signal(TIME_S), s2=0.5 * signal(TIME_S - 0.2))
    (line,) = warned(path, {"s2.scale": -2.0})
    assert line.endswith("; fix: s2.scale: 2")


def test_an_s2_that_changes_is_the_subject(tmp_path: Path) -> None:
    s2 = np.where(TIME_S < 30.0, 1.0, -1.0) * signal(TIME_S - 0.2)
    (line,) = warned(recorded(tmp_path / "bag", signal(TIME_S), s2=s2))
    assert line.startswith("WARN s1 and the truth agree, but s2 has the sign of the truth until ")
    s2 = np.where(TIME_S < 30.0, 1.0, 4.0) * signal(TIME_S - 0.2)
    (line,) = warned(recorded(tmp_path / "scale", signal(TIME_S), s2=s2))
    assert re.search("agree, but the truth reads [.0-9]+ times what s2 reads until", line)


def test_every_fault_of_a_truth_is_named(tmp_path: Path) -> None:
    sign, lag = warned(recorded(tmp_path / "late", -signal(TIME_S - 0.6)))
    assert sign.startswith(f"{AGREE} the truth has the opposite sign of s2")
    assert lag.startswith("WARN the truth lags s1 by 0.6")
    unit, lag = warned(recorded(tmp_path / "degrees", np.degrees(signal(TIME_S - 0.6))))
    assert unit.startswith(f"{AGREE} the truth reads 57.3 times what s2 reads")
    assert lag.startswith("WARN the truth lags s1 by 0.6")


def test_two_may_be_wrong_in_different_respects(tmp_path: Path) -> None:
    truth, s2 = np.degrees(signal(TIME_S)), -signal(TIME_S - 0.2)
    of_s2, of_truth = warned(recorded(tmp_path / "bag", truth, s2=s2))
    assert of_s2.startswith("WARN s1 and the truth agree, but s2 has the opposite sign of s1 (")
    assert of_s2.endswith("; fix: s2.scale: -1")
    assert of_truth.startswith(f"{AGREE} the truth reads 57.3 times what s1 reads: ")


@pytest.mark.parametrize(
    ("truth", "is_wrong"),
    [(signal(TIME_S), False), (frozen(), False), (-signal(TIME_S), True)],
    ids=["right", "frozen", "negated"],
)
def test_only_a_truth_that_suits_no_sensor_is_wrong(
    tmp_path: Path, truth: Reals, is_wrong: bool
) -> None:
    assert suited(recorded(tmp_path / "bag", truth)).truth_is_wrong is is_wrong


def test_without_a_truth_there_is_what_the_check_says(tmp_path: Path) -> None:
    path = recorded(tmp_path / "bag", signal(TIME_S), -signal(TIME_S))
    with open_bag(path) as bag:
        found = check_start(bag, Topics(), Parameters())
        recording = read_recording(bag, Topics(), Parameters())
    none = Track._make(each[:0] for each in recording.truth)
    (line,) = suitability(recording._replace(truth=none), Parameters(), found).lines
    assert line.startswith("WARN s1 has the opposite sign of s2 (correlation -")


def test_only_what_is_scored_counts(tmp_path: Path) -> None:
    path = recorded(tmp_path / "bag", frozen())
    assert len(warned(path, start_s=20.0)) == 1
    assert warned(path, start_s=40.0) == ()


def test_few_samples_say_nothing(tmp_path: Path) -> None:
    path = write_scalars(
        tmp_path / "bag", [Scalar(topic, 0.0, 1.0) for topic in ("/s1", "/s2", "/truth")]
    )
    assert warned(path) == ()
