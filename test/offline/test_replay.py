# SPDX-License-Identifier: Apache-2.0
"""A bag through the fusion into a new bag."""

from __future__ import annotations

import math
import tracemalloc
from itertools import pairwise
from pathlib import Path

import pytest
from bag.making import FLOAT, POINT, decoded, float_data, point_data
from bag.recorded import Scalar, at, messages, read, swing, write_scalars

from fuzzy_fusion_ros.bag import (
    BagMessage,
    BagWriter,
    Definition,
    Topic,
    offered_qos,
    open_bag,
)
from fuzzy_fusion_ros.bag.mcap import file
from fuzzy_fusion_ros.batch.series import fusion, run
from fuzzy_fusion_ros.offline.replay import Replayed, _declare, differences, replay
from fuzzy_fusion_ros.offline.topics import Topics
from fuzzy_fusion_ros.parameters.errors import BagError
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import replace

EXPLAINED = [
    f"/fusion_node/{name}"
    for name in (
        "aggregate",
        "drift",
        "firing_strengths",
        "innovation",
        "prediction",
        "standard_deviation",
        "weight",
    )
]


def replayed(
    source: Path,
    output: Path,
    changes: dict[str, object] | None = None,
    topics: Topics | None = None,
    start_s: float | None = None,
    end_s: float | None = None,
) -> Replayed:
    """Replay a bag with some parameters changed."""
    with open_bag(source) as bag:
        return replay(
            bag,
            output,
            topics or Topics(),
            replace(Parameters(), changes or {}),
            start_s,
            end_s,
        )


def scalars(path: Path, topic: str, field: str = "x") -> list[float]:
    """Return the numbers on a topic."""
    with open_bag(path) as bag:
        return [getattr(decoded(each).point, field) for each in bag.messages([topic])]


def test_the_new_bag_holds_the_old_messages_and_the_new_estimates(tmp_path: Path) -> None:
    source = write_scalars(tmp_path / "in", [*swing(), Scalar("/other", 0.0, 1.0)])
    done = replayed(source, tmp_path / "out")
    assert (done.messages, done.estimates, done.restarts, done.notes) == (1051, 500, 0, ())
    kept = ["/s1", "/s2", "/truth", "/other"]
    assert messages(tmp_path / "out", kept) == messages(source, kept)
    trace = run(fusion(Parameters()), read(source).series)
    assert scalars(tmp_path / "out", "/estimate") == trace.value.tolist()
    assert scalars(tmp_path / "out", "/fusion_node/weight") == trace.weight.tolist()
    assert scalars(tmp_path / "out", "/fusion_node/drift") == trace.drift.tolist()
    assert scalars(tmp_path / "out", "/fusion_node/aggregate") == trace.aggregate.tolist()
    with open_bag(tmp_path / "out") as bag:
        strengths = [
            decoded(each).position.tolist()
            for each in bag.messages(["/fusion_node/firing_strengths"])
        ]
        assert sorted(bag.topics) == sorted([*kept, "/estimate", *EXPLAINED])
        assert bag.problems == []
    assert strengths == trace.strengths.tolist()


def test_an_estimate_follows_its_cause_at_once(tmp_path: Path) -> None:
    source = write_scalars(tmp_path / "in", swing(1.0))
    replayed(source, tmp_path / "out")
    order = messages(tmp_path / "out")
    for before, after in pairwise(order):
        if after.topic == "/estimate":
            assert (before.topic, before.log_ns) == ("/s1", after.log_ns)


def test_the_predictor_explains_itself_too(tmp_path: Path) -> None:
    source = write_scalars(tmp_path / "in", swing())
    replayed(source, tmp_path / "out", {"predictor.enabled": True})
    trace = run(fusion(replace(Parameters(), {"predictor.enabled": True})), read(source).series)
    there = trace.predicted
    assert there.any()
    predictions = trace.prediction[there]
    assert scalars(tmp_path / "out", "/fusion_node/prediction") == predictions.tolist()
    assert (
        scalars(tmp_path / "out", "/fusion_node/innovation")
        == (trace.aggregate[there] - predictions).tolist()
    )


def test_a_replay_of_a_replay_is_the_same(tmp_path: Path) -> None:
    source = write_scalars(tmp_path / "in", swing())
    replayed(source, tmp_path / "one")
    replayed(tmp_path / "one", tmp_path / "two")
    assert messages(tmp_path / "one") == messages(tmp_path / "two")
    names = ["/s1", "/s2", "/truth", "/estimate", *EXPLAINED]
    assert differences(tmp_path / "one", tmp_path / "two", names) == []


def test_an_estimate_is_s2_with_another_number(tmp_path: Path) -> None:
    s2 = bytearray(point_data(at(0.0), 1.0))
    s2[-16:-8] = float_data(5.0)[4:]  # point.y, which is not fused
    with BagWriter(tmp_path / "in") as writer:
        writer.write("/s2", POINT, at(0.0), bytes(s2))
        writer.write("/s1", POINT, at(0.0), point_data(at(0.0), 3.0))
    replayed(tmp_path / "in", tmp_path / "out")
    (estimate,) = messages(tmp_path / "out", ["/estimate"])
    value = scalars(tmp_path / "out", "/estimate")[0]
    expected = bytearray(point_data(at(0.0), value))
    expected[-16:-8] = s2[-16:-8]
    assert estimate.data == bytes(expected)


def test_the_estimate_may_have_a_type_of_its_own(tmp_path: Path) -> None:
    source = write_scalars(tmp_path / "in", swing(1.0))
    changes: dict[str, object] = {"estimate.type": "sensor_msgs/msg/Temperature"}
    replayed(source, tmp_path / "out", changes)
    with open_bag(tmp_path / "out") as bag:
        found = [decoded(each) for each in bag.messages(["/estimate"])]
    trace = run(fusion(Parameters()), read(source).series)
    assert [each.temperature for each in found] == trace.value.tolist()
    assert found[7].header.stamp.nanosec == 70_000_000


def test_estimates_none_of_which_fits_are_refused(tmp_path: Path) -> None:
    far = [
        each._replace(value=1e6) if each.topic in {"/s1", "/s2"} else each for each in swing(1.0)
    ]
    source = write_scalars(tmp_path / "in", far)
    changes: dict[str, object] = {
        "estimate.type": "sensor_msgs/msg/NavSatStatus",
        "estimate.field": "service",
    }
    with pytest.raises(
        BagError,
        match=r"no estimate: 100 estimates do not fit into sensor_msgs/msg/NavSatStatus: field "
        "'service' is of type uint16, 1000000.0 does not fit",
    ):
        replayed(source, tmp_path / "out", changes)


def test_estimates_some_of_which_do_not_fit_are_counted(tmp_path: Path) -> None:
    far = [each._replace(value=-1.0) if each.time_s < 0.5 else each for each in swing(1.0)]
    source = write_scalars(tmp_path / "in", far)
    changes: dict[str, object] = {
        "estimate.type": "sensor_msgs/msg/NavSatStatus",
        "estimate.field": "service",
    }
    done = replayed(source, tmp_path / "out", changes)
    (note,) = done.notes
    assert 0 < done.estimates < 100
    assert note.startswith(f"{100 - done.estimates} estimates do not fit into sensor_msgs/msg/Nav")


def test_ticks_come_at_their_own_times(tmp_path: Path) -> None:
    source = write_scalars(tmp_path / "in", swing(1.0, estimate=False))
    done = replayed(source, tmp_path / "out", {"trigger": "timer", "rate": 10.0})
    assert done.estimates == 9
    found = messages(tmp_path / "out", ["/estimate"])
    assert [each.log_ns for each in found] == [at(k / 10) for k in range(1, 10)]
    order = messages(tmp_path / "out")
    assert [each.log_ns for each in order] == sorted(each.log_ns for each in order)


def test_ticks_without_anything_new_cost_nothing(tmp_path: Path) -> None:
    scalars = [*swing(1.0), *(each._replace(time_s=each.time_s + 1e8) for each in swing(1.0))]
    source = write_scalars(tmp_path / "in", scalars)
    done = replayed(source, tmp_path / "out", {"trigger": "timer", "rate": 1e4})
    assert done.estimates == 199  # the last sample's tick would come after the bag's end


def test_looping_gives_the_same_estimates_each_time(tmp_path: Path) -> None:
    loops = [
        each._replace(log_s=each.time_s + 10.0 * loop) for loop in range(4) for each in swing()
    ]
    source = write_scalars(tmp_path / "in", loops)
    done = replayed(source, tmp_path / "out", {"predictor.enabled": True})
    assert done.restarts == 3
    found = [each.data for each in messages(tmp_path / "out", ["/estimate"])]
    assert len(found) == 2000
    assert found[:500] * 4 == found


def test_what_was_dropped_is_told(tmp_path: Path) -> None:
    bad = [Scalar("/s1", 5.0, math.nan), Scalar("/s2", 4.5, 1.0, log_s=5.1)]
    with BagWriter(tmp_path / "in") as writer:
        for each in messages(write_scalars(tmp_path / "good", [*swing(), *bad])):
            writer.write(*each)
        writer.write("/s1", POINT, at(6.0), b"\0\1\0\0")
    done = replayed(tmp_path / "in", tmp_path / "out")
    assert sorted(done.notes) == [
        "/s1: 1 dropped: message lacks the field",
        "/s1: 1 dropped: value is not finite",
        "/s2: 1 dropped: stamp is not newer than the last",
    ]
    assert messages(tmp_path / "out", ["/s1"])[-1].data == b"\0\1\0\0"


def test_the_span_is_half_open(tmp_path: Path) -> None:
    source = write_scalars(tmp_path / "in", swing())
    done = replayed(source, tmp_path / "out", start_s=1.0, end_s=2.0)
    assert done.estimates == 100
    assert messages(tmp_path / "out", ["/s1"]) == messages(source, ["/s1"])[100:200]


def test_topics_keep_what_is_known_of_them(tmp_path: Path) -> None:
    profile = offered_qos(depth=3, reliability="best_effort")
    with BagWriter(tmp_path / "in") as writer:
        writer.add_topic("/s1", POINT, qos=[profile])
        for each in swing(0.1):
            writer.write(each.topic, POINT, at(each.time_s), point_data(at(each.time_s), 1.0))
    replayed(tmp_path / "in", tmp_path / "out")
    with open_bag(tmp_path / "in") as one, open_bag(tmp_path / "out") as other:
        for name in ("/s1", "/s2", "/truth"):
            assert one.topics[name] == other.topics[name]


def test_messages_of_types_that_nobody_knows_are_copied(tmp_path: Path) -> None:
    secret = BagMessage("/secret", "my_msgs/msg/Secret", at(0.5), b"\0\1\0\0whatever")
    with BagWriter(tmp_path / "in") as writer:
        writer.add_topic(secret.topic, secret.msgtype, definition=Definition("unknown", ""))
        for each in swing(1.0):
            writer.write(each.topic, POINT, at(each.time_s), point_data(at(each.time_s), 1.0))
        writer.write(*secret)
    replayed(tmp_path / "in", tmp_path / "out")
    assert messages(tmp_path / "out", ["/secret"]) == [secret]


def test_topics_whose_types_nobody_describes_are_declared(tmp_path: Path) -> None:
    with BagWriter(tmp_path / "out") as writer:
        _declare(writer, Topic("/secret", "my_msgs/msg/Secret"))
        writer.write("/secret", "my_msgs/msg/Secret", at(0.0), b"\0\1\0\0")
    assert len(messages(tmp_path / "out")) == 1


def test_a_namespace_holds_for_the_explanation_too(tmp_path: Path) -> None:
    source = write_scalars(tmp_path / "in", swing(0.1, estimate=False))
    replayed(source, tmp_path / "out", topics=Topics(estimate="/robot/estimate"))
    with open_bag(tmp_path / "out") as bag:
        assert {"/robot/estimate", "/robot/fusion_node/weight"} <= set(bag.topics)


def test_messages_without_a_header_can_be_fused(tmp_path: Path) -> None:
    with BagWriter(tmp_path / "in") as writer:
        for k in range(50):
            writer.write("/s2", FLOAT, at(k * 0.01), float_data(1.0))
            writer.write("/s1", FLOAT, at(k * 0.01), float_data(1.0))
    done = replayed(tmp_path / "in", tmp_path / "out")
    assert done.estimates == 50
    assert messages(tmp_path / "out", ["/estimate"])[9].data == float_data(1.0)


def test_memory_does_not_grow_with_the_bag(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(file, "BLOCK_BYTES", 1 << 14)
    peaks = []
    for name, seconds in {"warm": 2.0, "short": 5.0, "long": 40.0}.items():
        source = write_scalars(tmp_path / name, swing(seconds))
        tracemalloc.start()
        replayed(source, tmp_path / f"{name}_out")
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    grown = peaks[2] - peaks[1]
    assert grown < 0.35 * (tmp_path / "long" / "long_0.mcap").stat().st_size
    assert grown < 2**20


def test_the_output_must_be_new(tmp_path: Path) -> None:
    source = write_scalars(tmp_path / "in", swing(0.1))
    with pytest.raises(BagError, match="exists: choose another directory"):
        replayed(source, source)


def test_a_sensor_cannot_be_the_estimate(tmp_path: Path) -> None:
    source = write_scalars(tmp_path / "in", swing(0.1))
    with pytest.raises(BagError, match="/s1 cannot be both a sensor and the estimate"):
        replayed(source, tmp_path / "out", topics=Topics(estimate="/s1"))


def test_missing_sensors_are_refused(tmp_path: Path) -> None:
    source = write_scalars(tmp_path / "in", swing(0.1))
    with pytest.raises(BagError, match="has no topic '/gyro'"):
        replayed(source, tmp_path / "out", topics=Topics(s2="/gyro"))
    assert not (tmp_path / "out").exists()


def test_differences_are_found(tmp_path: Path) -> None:
    one = write_scalars(tmp_path / "one", swing(1.0))
    changed = [each._replace(value=0.5) if k == 100 else each for k, each in enumerate(swing(1.0))]
    other = write_scalars(tmp_path / "other", changed)
    shorter = write_scalars(tmp_path / "shorter", swing(1.0, truth=False)[:-1])
    assert differences(one, one, ["/s1", "/estimate"]) == []
    topic = changed[100].topic
    assert differences(one, other, [topic]) == [f"{topic} differs from message 32 on"]
    assert differences(one, shorter, ["/estimate", "/truth", "/nothing"]) == [
        "/estimate differs from message 99 on",
        "/truth differs from message 0 on",
        "/nothing is not in both bags",
    ]


def test_modes_without_s1_give_estimates_too(tmp_path: Path) -> None:
    lost = [each for each in swing() if each.topic != "/s1" or each.time_s < 1.0]
    source = write_scalars(tmp_path / "in", lost)
    done = replayed(source, tmp_path / "out")
    assert done.estimates == 100 + 30  # S1 is lost from 1.0 s after its last sample on
    weights = scalars(tmp_path / "out", "/fusion_node/weight")
    assert weights[100:] == [0.0] * 30
