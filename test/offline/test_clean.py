# SPDX-License-Identifier: Apache-2.0
"""What is read as arrays is what guards and trigger make of the messages one by one."""

from __future__ import annotations

import math
import random
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from bag.making import FLOAT, float_data
from bag.recorded import Scalar, at, message, swing, write_scalars
from faults.mutations import MUTATIONS, mutated, original

from fuzzy_fusion_ros.bag import BagWriter, open_bag
from fuzzy_fusion_ros.offline import recording
from fuzzy_fusion_ros.offline.clean import Samples, read_clean
from fuzzy_fusion_ros.offline.recording import Recording, read_recording
from fuzzy_fusion_ros.offline.topics import Topics
from fuzzy_fusion_ros.parameters.errors import FusionError
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import replace

BAGS = Path(__file__).resolve().parents[2] / "bags"


def read_both(
    path: Path,
    monkeypatch: pytest.MonkeyPatch,
    topics: Topics | None = None,
    changes: dict[str, Any] | None = None,
    **span: float,
) -> bool:
    """Read a bag as arrays and one by one; return whether the former can be done.

    Raises:
        AssertionError: They differ.
    """
    parameters = replace(Parameters(), changes or {})
    arrays: list[Samples | None] = []

    def watched(*arguments: Any) -> Samples | None:
        arrays.append(read_clean(*arguments))
        return arrays[-1]

    def read(reader: Any) -> Recording | str:
        monkeypatch.setattr(recording, "read_clean", reader)
        try:
            with open_bag(path) as bag:
                return read_recording(bag, topics or Topics(), parameters, **span)
        except FusionError as error:
            return str(error)

    one, other = read(watched), read(lambda *_: None)
    if isinstance(one, str) or isinstance(other, str):
        assert one == other
    else:
        assert _plain(one) == _plain(other)
    return bool(arrays) and arrays[0] is not None


def _plain(value: Any) -> Any:
    """Return what two recordings can be compared by: arrays with their types."""
    if isinstance(value, np.ndarray):
        return (value.dtype, value.tolist(), value.flags.c_contiguous)
    if isinstance(value, tuple):
        return [_plain(each) for each in value]
    return value


@pytest.mark.parametrize("name", sorted(each.parent.name for each in BAGS.glob("*/metadata.yaml")))
def test_the_committed_bags_are_read_alike(monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    assert read_both(BAGS / name, monkeypatch)
    assert read_both(BAGS / name, monkeypatch, start_s=1.0, end_s=5.5)


@pytest.mark.parametrize(
    "changes",
    [{"trigger": "timer"}, {"trigger": "pair"}, {"signal.period": 6.0}, {"s1.kind": "rate"}],
)
def test_other_triggers_and_signals_go_one_by_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, changes: dict[str, Any]
) -> None:
    path = write_scalars(tmp_path / "bag", swing())
    assert not read_both(path, monkeypatch, changes=changes)


def test_parameters_hold_here_too(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = write_scalars(tmp_path / "bag", swing())
    scale = {"s1.scale": -3.7, "s2.offset": 0.1}
    assert read_both(path, monkeypatch, changes=scale)
    assert read_both(path, monkeypatch, changes={"s1.timeout": 0.02})
    assert not read_both(path, monkeypatch, changes={"s1.timeout": 1e-4})  # S2 comes alone


def test_one_topic_can_be_all(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = write_scalars(tmp_path / "bag", swing())
    for topics in (Topics(s2="/s1"), Topics(truth="/s2"), Topics(s2="/s1", truth="/s1")):
        assert read_both(path, monkeypatch, topics)


def test_messages_without_stamps(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with BagWriter(tmp_path / "bag") as writer:
        for k in range(300):
            writer.write("/s1" if k % 3 else "/s2", FLOAT, at(k * 0.01), float_data(k))
    assert read_both(tmp_path / "bag", monkeypatch)


ODD: dict[str, list[Scalar]] = {
    "a stamp twice": [Scalar("/s1", 2.0, 1.0, 2.001)],
    "an old stamp": [Scalar("/s2", 0.5, 1.0, 3.0)],
    "a truth that is late": [Scalar("/truth", 0.5, 1.0, 3.0)],
    "a stamp before 1970": [Scalar("/s1", -1.7e9, 1.0, 3.0), Scalar("/s1", -1.8e9, 1.0, 3.1)],
    "a stamp of zero": [Scalar("/s2", -1.7e9, 1.0, 3.0)],
    "a stamp of the future": [Scalar("/s1", 30.0, 1.0, 3.0)],
    "no number": [Scalar("/s1", 2.0001, math.nan), Scalar("/s2", 2.5001, -math.inf)],
    "a restart": [Scalar("/s1", k * 0.01, 1.0, 5.0 + k * 0.01) for k in range(20)],
    "S1 is silent": [Scalar("/s2", 5.0 + k * 0.1, 1.0) for k in range(60)],
    "S2 is silent": [Scalar("/s1", 5.0 + k * 0.01, 1.0) for k in range(900)],
    "clocks apart": [Scalar("/s2", 4.9 + k * 0.1, 1.0, 8.0 + k * 0.1) for k in range(40)],
}
CLEAN = {"S2 is silent"}


@pytest.mark.parametrize("odd", ODD)
def test_what_needs_a_guard_has_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, odd: str
) -> None:
    scalars = [*swing(), *ODD[odd]]
    scalars.sort(key=lambda each: each.time_s if each.log_s is None else each.log_s)
    path = write_scalars(tmp_path / "bag", scalars)
    assert read_both(path, monkeypatch) == (odd in CLEAN)


@pytest.mark.parametrize("seed", range(30))
def test_streams_at_random(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, seed: int) -> None:
    rng = random.Random(seed)
    jitter = rng.choice([0.0, 0.0, 0.02, 2.0])
    scalars, time_s = [], 0.0
    for _ in range(400):
        time_s += rng.choice([0.0, 0.01, 0.01, 0.3 if seed % 3 == 0 else 0.01])
        topic = rng.choice(["/s1", "/s1", "/s2", "/truth", "/estimate"])
        log_s = time_s + rng.choice([0.0, jitter])
        scalars.append(Scalar(topic, time_s, rng.gauss(0.0, 1.0), log_s))
    read_both(write_scalars(tmp_path / "bag", scalars), monkeypatch)


def test_spoilt_bags(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = original(tmp_path / "whole")
    assert read_both(whole.path, monkeypatch)
    for seed in range(3 * len(MUTATIONS)):
        mutated(whole, tmp_path / "bag", seed)
        read_both(tmp_path / "bag", monkeypatch)


def test_messages_that_are_none_go_one_by_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with BagWriter(tmp_path / "bag") as writer:
        for each in map(message, swing(2.0)):
            writer.write(*each)
        writer.write(*message(Scalar("/s1", 2.0, 1.0))._replace(data=b"\0\1\0\0xx"))
    assert not read_both(tmp_path / "bag", monkeypatch)
