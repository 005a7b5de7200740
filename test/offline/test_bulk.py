# SPDX-License-Identifier: Apache-2.0
"""Blocks at once give the messages, and all that is said of them, that one by one give."""

from __future__ import annotations

import random
from collections import Counter
from pathlib import Path
from typing import Any

import pytest
from bag.making import FLOAT, POINT, float_data, write_by_rosbags
from bag.recorded import Scalar, at, message, messages, swing, write_scalars
from faults.mutations import MUTATIONS, mutated, original
from offline.test_clean import ODD
from rosbags.rosbag2 import StoragePlugin

from fuzzy_fusion_ros.bag import BagWriter, jazzy_types, open_bag
from fuzzy_fusion_ros.bag.mcap import file
from fuzzy_fusion_ros.messages import ScalarCodec, default_message
from fuzzy_fusion_ros.messages.variances import Elements
from fuzzy_fusion_ros.offline import bulk
from fuzzy_fusion_ros.offline.replay import Replayed, replay
from fuzzy_fusion_ros.offline.topics import Topics
from fuzzy_fusion_ros.parameters.errors import FusionError
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import replace

BAGS = Path(__file__).resolve().parents[2] / "bags"
MORE = pytest.mark.slow("more of them")
SMALL = 1 << 11
"""Bytes of a block, so that the state is carried from one to the next."""


@pytest.fixture
def both(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Both:
    return Both(tmp_path, monkeypatch)


class Both:
    """Replays bags both ways."""

    def __init__(self, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        self._folder = folder
        self._patch = monkeypatch
        self._replays = 0

    def ways(
        self, path: Path, changes: dict[str, Any] | None = None, block: int = 1 << 20, **how: Any
    ) -> Counter[str]:
        """Replay a bag both ways; return how many blocks went which way.

        Raises:
            AssertionError: They differ.
        """
        parameters = replace(Parameters(), changes or {})
        went: Counter[str] = Counter()
        follow = bulk.Bulk.follow

        def watched(*arguments: Any) -> Any:
            brought = follow(*arguments)
            went["one by one" if brought is None else "at once"] += 1
            return brought

        self._patch.setattr(file, "BLOCK_BYTES", block)
        found = []
        for way in (watched, lambda *_: None):
            self._replays += 1
            output = self._folder / f"replayed{self._replays}"
            with self._patch.context() as patch:
                patch.setattr(bulk.Bulk, "follow", way)
                found.append(_replayed(path, output, parameters, how))
            found.append(messages(output) if (output / "metadata.yaml").exists() else [])
        assert found[0] == found[2]
        assert found[1] == found[3]
        return went


def _replayed(
    path: Path, output: Path, parameters: Parameters, how: dict[str, Any]
) -> Replayed | str:
    try:
        with open_bag(path) as bag:
            options = {"topics": Topics(), **how}
            return replay(bag, output, parameters=parameters, **options)
    except FusionError as error:
        return str(error).replace(str(output), "")


@pytest.mark.parametrize("name", sorted(each.parent.name for each in BAGS.glob("*/metadata.yaml")))
def test_the_committed_bags(both: Both, name: str) -> None:
    assert set(both.ways(BAGS / name, start_s=0.0, end_s=15.0)) == {"at once"}


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"predictor.enabled": True},
        {"s1.bias_time_constant": 5.0, "s2.lag_time_constant": 0.1, "s2.delay": 0.05},
        {"s1.scale": -3.7, "s2.scale": 0.3, "s2.offset": 0.1},
        {"s1.lowpass_time_constant": 0.1, "s2.timeout": 0.15},
        {"estimate.field": "point.y"},
        {"self_tuning": True},
    ],
    ids=str,
)
def test_what_arrays_can_do(both: Both, tmp_path: Path, changes: dict[str, Any]) -> None:
    path = write_scalars(tmp_path / "bag", swing())
    assert both.ways(path, changes, SMALL).keys() == {"at once"}
    assert both.ways(path, changes, explained=False) == {"at once": 2}


@pytest.mark.parametrize(
    "changes",
    [
        {"trigger": "pair"},
        {"trigger": "timer", "rate": 30.0},
        {"signal.period": 1.0},
        {"s1.kind": "rate"},
        {"estimate.type": "sensor_msgs/msg/Temperature"},
        {"estimate.type": "sensor_msgs/msg/NavSatStatus", "estimate.field": "service"},
    ],
    ids=str,
)
def test_what_arrays_cannot_do(both: Both, tmp_path: Path, changes: dict[str, Any]) -> None:
    path = write_scalars(tmp_path / "bag", swing())
    assert "one by one" in both.ways(path, changes, SMALL)


@pytest.mark.parametrize(
    "changes",
    [
        {"estimate.type": "sensor_msgs/msg/Temperature"},
        {"estimate.type": "sensor_msgs/msg/NavSatStatus", "estimate.field": "service"},
    ],
    ids=str,
)
def test_what_rows_can_never_hold_is_not_read_at_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, changes: dict[str, Any]
) -> None:
    path = write_scalars(tmp_path / "bag", swing(1.0))
    monkeypatch.delattr(bulk.Bulk, "_columns")
    assert _replayed(path, tmp_path / "out", replace(Parameters(), changes), {}).estimates > 0


def test_messages_of_s2_of_two_layouts_are_not_fused_at_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = write_scalars(tmp_path / "scalars", swing(1.0))
    with open_bag(path) as bag:
        frames = [default_message(bag.types, POINT, "x" * k) for k in (1, 9)]
    with BagWriter(tmp_path / "bag") as writer:
        for k, each in enumerate(map(message, swing(1.0))):
            data = each.data
            if each.topic == "/s2":
                data = _stamped(POINT, "point.x", frames[k > 50], each.log_ns, 1.0)
            writer.write(each.topic, each.msgtype, each.log_ns, data)
    monkeypatch.delattr(bulk, "advanced")
    assert _replayed(tmp_path / "bag", tmp_path / "out", Parameters(), {}).estimates > 0


def test_compiling_has_to_pay_for_the_span(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[int] = []
    monkeypatch.setattr(bulk, "pays_to_compile", lambda _, samples: asked.append(samples))
    messages_of_s1 = sum(each.topic == "/s1" for each in swing())
    path = write_scalars(tmp_path / "bag", swing())
    for k, span in enumerate([{}, {"start_s": 1.0, "end_s": 2.0}]):
        _replayed(path, tmp_path / f"out{k}", Parameters(), span)
    with open_bag(path) as bag:
        share = bag.share(1.0, 2.0)
    assert 0.0 < share < 0.5
    assert asked == [messages_of_s1, round(share * messages_of_s1)]


def test_compiled_or_not(both: Both, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scalars = [*swing(), Scalar("/s2", 2.5, 1.0, 2.505)]  # a stamp twice: one block is not clean
    scalars.sort(key=lambda each: each.time_s if each.log_s is None else each.log_s)
    path = write_scalars(tmp_path / "bag", scalars)
    monkeypatch.setattr(bulk, "pays_to_compile", lambda *_: True)
    for changes in ({}, {"predictor.enabled": True, "s1.bias_time_constant": 5.0}):
        went = both.ways(path, changes, SMALL)
        assert went["one by one"] == 1
        assert went["at once"] > 3


NEEDS_NO_GUARD = {"a truth that is late", "S2 is silent"}


@pytest.mark.parametrize("odd", ODD)
@pytest.mark.parametrize("block", [1 << 20, SMALL])
def test_what_needs_a_guard_has_one(both: Both, tmp_path: Path, odd: str, block: int) -> None:
    scalars = [*swing(), *ODD[odd]]
    scalars.sort(key=lambda each: each.time_s if each.log_s is None else each.log_s)
    went = both.ways(write_scalars(tmp_path / "bag", scalars), block=block)
    assert went["at once"] > 0  # the blocks without the odd samples
    assert (went["one by one"] == 0) == (odd in NEEDS_NO_GUARD)


def test_loops(both: Both, tmp_path: Path) -> None:
    loops = [
        each._replace(log_s=each.time_s + 10.0 * loop) for loop in range(3) for each in swing()
    ]
    went = both.ways(write_scalars(tmp_path / "bag", loops), {"predictor.enabled": True}, SMALL)
    assert went["at once"] > went["one by one"] > 0


def scalars_at_random(seed: int) -> list[Scalar]:
    """Return samples with random pauses and delays; those of a third of the seeds have gaps."""
    rng = random.Random(seed)
    jitter = rng.choice([0.0, 0.0, 0.02, 2.0])
    scalars, time_s = [], 0.0
    for _ in range(400):
        time_s += rng.choice([0.0, 0.01, 0.01, 0.3 if seed % 3 == 0 else 0.01])
        topic = rng.choice(["/s1", "/s1", "/s2", "/truth", "/estimate"])
        log_s = time_s + rng.choice([0.0, jitter])
        scalars.append(Scalar(topic, time_s, rng.gauss(0.0, 1.0), log_s))
    return scalars


@pytest.mark.parametrize("seeds", [range(5), pytest.param(range(5, 20), marks=MORE)], ids=str)
def test_streams_at_random(both: Both, tmp_path: Path, seeds: range) -> None:
    went: Counter[str] = Counter()
    for seed in seeds:
        path = write_scalars(tmp_path / f"bag{seed}", scalars_at_random(seed))
        went += both.ways(path, block=SMALL)
    assert min(went["at once"], went["one by one"]) > 0


@pytest.mark.parametrize("times", [1, pytest.param(3, marks=MORE)])
def test_spoilt_bags(both: Both, tmp_path: Path, times: int) -> None:
    whole = original(tmp_path / "whole")
    assert both.ways(whole.path).keys() == {"at once"}
    went: Counter[str] = Counter()
    for seed in range(times * len(MUTATIONS)):
        mutated(whole, tmp_path / "bag", seed)
        went += both.ways(tmp_path / "bag", block=SMALL)
    assert min(went["at once"], went["one by one"]) > 0


def test_types_of_all_kinds(both: Both, tmp_path: Path) -> None:
    kinds = {
        "sensor_msgs/msg/Range": "range",  # of 32 bits
        "sensor_msgs/msg/Temperature": "temperature",  # with a variance beside it
        "sensor_msgs/msg/Imu": "linear_acceleration.x",  # within a matrix of them
        FLOAT: "data",  # without a stamp
        "std_msgs/msg/Int32": "data",  # rounded
    }
    for number, (kind, field) in enumerate(kinds.items()):
        with open_bag(write_scalars(tmp_path / f"scalars{number}", swing(0.1))) as bag:
            data = default_message(bag.types, kind, "some frame")
            if kind.endswith("Imu"):
                paths = [f"linear_acceleration_covariance[{k}]" for k in range(9)]
                data = Elements(bag.types, kind, paths).written(data, map(float, range(1, 10)))
        path = tmp_path / f"bag{number}"
        with BagWriter(path) as writer:
            for k, each in enumerate(map(message, swing(2.0))):
                is_s2 = each.topic == "/s2"
                writer.write(
                    each.topic,
                    kind if is_s2 else each.msgtype,
                    each.log_ns,
                    _stamped(kind, field, data, each.log_ns, k) if is_s2 else each.data,
                )
        went = both.ways(path, {"s2.field": field}, SMALL)
        assert ("one by one" in went) == (kind == "std_msgs/msg/Int32")
    for bag, field, named in (
        ("bag1", "temperature", "variance"),
        ("bag2", "linear_acceleration.x", "linear_acceleration_covariance[0]"),
    ):
        variance = {"s2.field": field, "estimate.variance_field": named}
        assert both.ways(tmp_path / bag, variance, SMALL).keys() == {"at once"}


def _stamped(kind: str, field: str, data: bytes, stamp_ns: int, value: float) -> bytes:
    return ScalarCodec(jazzy_types(), kind, field).template(data).filled(value, stamp_ns)


def test_layouts_that_change(both: Both, tmp_path: Path) -> None:
    with open_bag(write_scalars(tmp_path / "scalars", swing(0.1))) as bag:
        frames = [
            default_message(bag.types, "geometry_msgs/msg/PointStamped", "x" * k) for k in (1, 9)
        ]
    with BagWriter(tmp_path / "bag") as writer:
        for each in map(message, swing()):
            data = each.data
            if each.topic == "/s2":
                frame = frames[each.log_ns > at(2.55)]
                data = _stamped(each.msgtype, "point.x", frame, each.log_ns, 1.0)
            writer.write(each.topic, each.msgtype, each.log_ns, data)
    went = both.ways(tmp_path / "bag", block=SMALL)
    assert went["at once"] > 0


def test_messages_of_other_topics_are_copied(both: Both, tmp_path: Path) -> None:
    rng = random.Random(1)
    with BagWriter(tmp_path / "bag") as writer:
        for each in map(message, swing()):
            writer.write(*each)
            text = b"\0\1\0\0" + rng.randbytes(rng.randrange(30))
            writer.write("/text", "std_msgs/msg/String", each.log_ns, text)
            writer.write("/empty", "std_msgs/msg/Empty", each.log_ns, b"")
    assert both.ways(tmp_path / "bag").keys() == {"at once"}


@pytest.mark.parametrize("storage", StoragePlugin)
def test_bags_of_others(both: Both, tmp_path: Path, storage: StoragePlugin) -> None:
    write_by_rosbags(tmp_path / "bag", map(message, swing()), storage)
    assert both.ways(tmp_path / "bag").keys() == {"at once"}


def test_one_topic_for_both(both: Both, tmp_path: Path) -> None:
    path = write_scalars(tmp_path / "bag", swing(1.0))
    assert both.ways(path, topics=Topics(s2="/s1")).keys() == {"one by one"}


def test_messages_without_stamps(both: Both, tmp_path: Path) -> None:
    with BagWriter(tmp_path / "bag") as writer:
        for k in range(300):
            writer.write("/s1" if k % 3 else "/s2", FLOAT, at(k * 0.01), float_data(k))
    assert both.ways(tmp_path / "bag", block=SMALL).keys() == {"at once"}
