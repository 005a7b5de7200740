# SPDX-License-Identifier: Apache-2.0
"""replay, score and tune as a program calls them."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from bag.recorded import Scalar, messages, swing, write_scalars
from tuning.quick import be_quick

from fuzzy_fusion_ros import (
    FusionError,
    Parameters,
    Topics,
    parameters_from,
    replace,
    replay,
    score,
    tune,
)
from fuzzy_fusion_ros.jobs.parameter_file import baseline_parameters
from fuzzy_fusion_ros.scoring.score import DERIVED, GIVEN


@pytest.fixture
def bag(tmp_path: Path) -> Path:
    """A bag with both sensors and a truth."""
    return write_scalars(tmp_path / "bag", swing(10.0, estimate=False))


def test_a_bag_is_replayed_with_parameters_of_any_kind(bag: Path, tmp_path: Path) -> None:
    file = tmp_path / "params.yaml"
    file.write_text("fusion_node:\n  ros__parameters:\n    aggregator.weight.very_large: 0.9\n")
    changed = replace(Parameters(), {"aggregator.weight.very_large": 0.9})
    estimates = {}
    for name, parameters in {"file": file, "object": changed, "none": None}.items():
        done = replay(bag, tmp_path / name, parameters=parameters, start=1.0, end=2.0)
        assert (done.estimates, done.restarts, done.notes) == (100, 0, ())
        estimates[name] = messages(tmp_path / name, ["/estimate"])
    assert estimates["file"] == estimates["object"] != estimates["none"]


def test_topics_are_those_given(bag: Path, tmp_path: Path) -> None:
    topics = Topics(s2="/truth", estimate="/fused")
    replay(bag, tmp_path / "new", topics=topics)
    found = score(tmp_path / "new", topics=topics, unit="rad", fit_baselines=False)
    assert not found.recomputed
    assert found.unit == "rad"
    assert found.scores("s2")["rmse"] == pytest.approx(0.0, abs=1e-12)


def test_a_fit_is_returned_and_written(
    bag: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    be_quick(monkeypatch)
    result = tune(bag, tmp_path / "new" / "tuned.yaml", end=8.0, unit="rad")
    assert parameters_from(tmp_path / "new" / "tuned.yaml") == result.parameters
    assert baseline_parameters(tmp_path / "new" / "tuned.yaml") == result.baselines
    result.write(tmp_path / "again.yaml")
    assert (tmp_path / "again.yaml").read_bytes() == (tmp_path / "new" / "tuned.yaml").read_bytes()
    assert result.origin == "bag, --start 0 --end 8, --seed 0, fitted to its truth"
    by_file = score(bag, parameters=tmp_path / "again.yaml", end=8.0)
    by_object = score(bag, parameters=result.parameters, end=8.0, fit_baselines=False)
    assert (by_file.baselines, by_object.baselines) == (GIVEN, DERIVED)
    assert by_file.scores("estimate") == by_object.scores("estimate")
    assert by_file.scores("estimate")["rmse"] == pytest.approx(result.tuned.error)


def late(delivery: float, behind: float) -> list[Scalar]:
    """Make 60 s of motion: S2 lags 0.2 s, arrives late, and its clock is behind S1's."""

    def motion(time_s: float) -> float:
        return math.sin(time_s) + math.sin(2.3 * time_s + 1.0)

    s1 = [Scalar("/s1", 0.04 * k, motion(0.04 * k)) for k in range(1500)]
    s2 = [
        Scalar("/s2", each - behind, motion(each - 0.2), each + delivery)
        for each in (0.2 * k for k in range(300))
    ]
    return sorted([*s1, *s2], key=lambda x: x.time_s if x.log_s is None else x.log_s)


@pytest.mark.parametrize(
    ("delivery", "behind", "timeout", "clocks_agree"),
    [(1.0, 0.0, 0.8, True), (2.5, 0.0, 0.0, True), (0.0, 5.0, 0.0, False)],
)
def test_late_delivery_is_not_taken_for_a_clock(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    delivery: float,
    behind: float,
    timeout: float,
    clocks_agree: bool,
) -> None:
    be_quick(monkeypatch)
    path = write_scalars(tmp_path / "bag", late(delivery, behind))
    sensors = tune(path, parameters=replace(Parameters(), {"s2.timeout": timeout})).tuned.sensors
    assert sensors.clocks_agree is clocks_agree
    if clocks_agree:
        assert sensors.lag_is_identifiable
        assert sensors.lag.total == pytest.approx(0.2, abs=0.05)


def test_errors_are_one_family(bag: Path, tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(FusionError, match="does not exist"):
        score(tmp_path / "none")
    with pytest.raises(FusionError, match="cannot be written"):
        tune(bag, tmp_path / "file" / "tuned.yaml")
    with pytest.raises(FusionError, match="exists: choose another directory"):
        replay(bag, bag)
