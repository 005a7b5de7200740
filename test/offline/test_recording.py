# SPDX-License-Identifier: Apache-2.0
"""What the fusion would take of a bag."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from bag.making import FLOAT, decoded, float_data
from bag.recorded import SECOND, Scalar, at, messages, read, swing, write_scalars
from rclpy.serialization import serialize_message
from sensor_msgs.msg import JointState

from fuzzy_fusion_ros.bag import BagWriter, open_bag
from fuzzy_fusion_ros.batch.series import fusion, run
from fuzzy_fusion_ros.core.sample import Sample
from fuzzy_fusion_ros.offline.recording import read_explanation, read_recording
from fuzzy_fusion_ros.offline.topics import Topics
from fuzzy_fusion_ros.online.fusion import Fusion
from fuzzy_fusion_ros.parameters.errors import BagError, MessageError
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import replace


def test_everything_is_read(tmp_path: Path) -> None:
    recording = read(write_scalars(tmp_path / "bag", swing()))
    assert recording.s1.values.size == recording.truth.values.size == 500
    assert recording.s2.values.size == 50
    assert recording.s1.stamps_ns[1] == recording.s1.log_ns[1] == at(0.01)
    assert recording.estimate.values[0] == 0.01
    assert recording.notes == ()
    assert (recording.unit, recording.start_ns) == ("", at(0.0))


def test_the_order_of_recording_says_what_was_known(tmp_path: Path) -> None:
    scalars = [
        Scalar("/s1", 1.0, 1.0),
        Scalar("/s2", 0.9, 2.0, log_s=1.5),
        Scalar("/s1", 2.0, 3.0),
        Scalar("/s2", 2.5, 4.0),
        Scalar("/s2", 2.6, 5.0),
        Scalar("/s1", 2.4, 6.0, log_s=2.7),
    ]
    series = read(write_scalars(tmp_path / "bag", scalars)).series
    assert series.s1.tolist() == [1.0, 3.0, 6.0]
    assert series.s2.tolist() == [2.0, 4.0, 5.0]
    assert series.s2_known.tolist() == [0, 1, 3]


def test_a_pair_is_known_at_once(tmp_path: Path) -> None:
    scalars = [
        Scalar("/s1", 1.0, 1.0),
        Scalar("/s1", 2.0, 2.0),
        Scalar("/s2", 1.0, 10.0, log_s=2.1),
        Scalar("/s2", 2.0, 20.0, log_s=2.2),
        Scalar("/s2", 3.0, 30.0),
        Scalar("/s1", 3.0, 3.0),
    ]
    parameters = replace(Parameters(), {"trigger": "pair"})
    series = read(write_scalars(tmp_path / "bag", scalars), parameters=parameters).series
    assert series.s1.tolist() == [1.0, 2.0, 3.0]
    assert series.s2.tolist() == [10.0, 20.0, 30.0]
    assert series.s2_known.tolist() == [1, 2, 3]


def test_ticks_follow_the_log_clock(tmp_path: Path) -> None:
    parameters = replace(Parameters(), {"trigger": "timer", "rate": 10.0})
    series = read(write_scalars(tmp_path / "bag", swing(1.0)), parameters=parameters).series
    assert series.s1_ns.tolist() == [at(k / 10 - 0.01) for k in range(1, 10)]


@pytest.mark.parametrize("trigger", ["s1", "pair", "timer"])
def test_the_series_gives_what_the_fusion_gives(tmp_path: Path, trigger: str) -> None:
    parameters = replace(Parameters(), {"trigger": trigger, "rate": 37.0})
    path = write_scalars(tmp_path / "bag", swing())
    node, given = Fusion(parameters), []
    next_ns = at(0.0) + round(SECOND / 37.0)
    for each in messages(path, ["/s1", "/s2", "/estimate", "/truth"]):
        while trigger == "timer" and each.log_ns >= next_ns:
            given += node.on_tick().estimates
            next_ns += round(SECOND / 37.0)
        sample = Sample(each.log_ns, decoded(each).point.x)
        if each.topic == "/s1":
            given += node.on_s1(sample, each.log_ns).estimates
        if each.topic == "/s2":
            given += node.on_s2(sample, each.log_ns).estimates
    expected = [each.estimate.value for each in given]
    trace = run(fusion(parameters), read(path, parameters=parameters).series)
    assert trace.value[trace.mode > 0].tolist() == expected
    assert len(expected) > 40


def test_what_cannot_be_used_is_left_out_and_counted(tmp_path: Path) -> None:
    scalars = [
        *swing(1.0),
        Scalar("/s1", 1.0, math.nan),
        Scalar("/s1", 1.1, math.inf),
        Scalar("/s1", 0.99, 5.0, log_s=1.2),
        Scalar("/s2", 100.0, 5.0, log_s=1.3),
        Scalar("/truth", 0.99, 5.0, log_s=1.4),
        Scalar("/s1", 1.5, 0.0),
    ]
    recording = read(write_scalars(tmp_path / "bag", scalars))
    assert sorted(recording.notes) == [
        "/s1: 1 dropped: stamp is not newer than the last",
        "/s1: 2 dropped: value is not finite",
        "/s2: 1 dropped: stamp is too far in the future",
        "/truth: 1 dropped: stamp is not newer than the last",
    ]
    assert recording.s1.values.size == 101


def test_a_message_that_lacks_the_number_is_left_out(tmp_path: Path) -> None:
    path = write_scalars(tmp_path / "good", swing(1.0))
    with BagWriter(tmp_path / "bag") as writer:
        for each in messages(path):
            writer.write(*each)
        writer.write("/s1", messages(path)[0].msgtype, at(1.0), b"\0\1\0\0xx")
    assert read(tmp_path / "bag").notes == ("/s1: 1 dropped: message lacks the field",)


def test_a_message_without_the_element_is_left_out(tmp_path: Path) -> None:
    joints = JointState()
    with BagWriter(tmp_path / "bag") as writer:
        for k in range(3):
            joints.header.stamp.sec = at(k) // SECOND
            joints.position = [float(each) for each in range(k)]
            data = serialize_message(joints)
            writer.write("/s1", "sensor_msgs/msg/JointState", at(k), data)
            writer.write("/s2", FLOAT, at(k), float_data(k))
    recording = read(tmp_path / "bag", Topics(fields={"s1": "position[0]"}))
    assert recording.s1.stamps_ns.tolist() == [at(1.0), at(2.0)]
    assert recording.notes[1:] == ("/s1: 1 dropped: message lacks the field",)


@pytest.mark.parametrize("topic", ["/s1", "/s2", "/estimate", "/truth"])
def test_time_that_jumps_back_ends_the_recording(tmp_path: Path, topic: str) -> None:
    again = [each._replace(log_s=each.time_s + 3.0) for each in swing(2.0)]
    behind = [each for each in again if each.topic == topic]
    path = write_scalars(tmp_path / "bag", [*swing(2.0), *behind])
    recording = read(path)
    assert recording.s1.values.size == 200
    (note,) = recording.notes
    assert note == (
        f"timestamps of {topic} jump back at 3. s: only what comes before is used; "
        "--start 3. uses what comes after"
    )


def test_what_comes_after_a_jump_can_be_read(tmp_path: Path) -> None:
    again = [each._replace(log_s=each.time_s + 3.0) for each in swing(2.0)]
    path = write_scalars(tmp_path / "bag", [*swing(2.0), *again])
    first, second = read(path), read(path, start_s=3.0)
    assert second.notes == ()
    assert np.array_equal(first.s1.values, second.s1.values)


def test_a_span_is_half_open(tmp_path: Path) -> None:
    recording = read(write_scalars(tmp_path / "bag", swing()), start_s=1.0, end_s=2.0)
    assert (recording.s1.stamps_ns[0], recording.s1.stamps_ns[-1]) == (at(1.0), at(1.99))


def test_missing_sensors_are_named_with_what_is_there(tmp_path: Path) -> None:
    path = write_scalars(tmp_path / "bag", swing())
    with pytest.raises(BagError, match=r"has no topic '/imu'; it has /estimate \(geometry"):
        read(path, Topics(s1="/imu"))
    with pytest.raises(BagError, match=r"has no topic '/imu', '/gps'; .*; give --s1 and --s2$"):
        read(path, Topics(s1="/imu", s2="/gps"))


def test_a_span_without_samples_is_refused(tmp_path: Path) -> None:
    path = write_scalars(tmp_path / "bag", swing())
    with pytest.raises(BagError, match="no usable message on /s1: no message in this"):
        read(path, start_s=100.0)


def test_sensors_that_never_say_a_number_are_refused(tmp_path: Path) -> None:
    path = write_scalars(tmp_path / "bag", [Scalar("/s1", 0.0, math.nan), Scalar("/s2", 0.0, 1.0)])
    with pytest.raises(BagError, match="no usable message on /s1: /s1: 1 dropped: value is"):
        read(path)


def test_one_topic_may_play_two_roles(tmp_path: Path) -> None:
    path = write_scalars(tmp_path / "bag", swing())
    recording = read(path, Topics(estimate="/s2"))
    assert np.array_equal(recording.estimate.values, recording.s2.values)


def test_fields_are_found(tmp_path: Path) -> None:
    path = write_scalars(tmp_path / "bag", swing(1.0))
    assert read(path, Topics(fields={"s1": "point.y"})).s1.values.max() == 0.0
    assert read(path, Topics(fields={"": "point.y"})).s2.values.max() == 0.0
    parameters = replace(Parameters(), {"s1.field": "point.z"})
    assert read(path, parameters=parameters).s1.values.max() == 0.0
    given = Topics(fields={"s1": "point.x"})
    assert read(path, given, parameters).s1.values.max() > 0.0


def test_a_common_field_is_for_those_that_have_it(tmp_path: Path) -> None:
    with BagWriter(tmp_path / "bag") as writer:
        for each in messages(write_scalars(tmp_path / "points", swing(1.0))):
            if each.topic == "/s2":
                writer.write("/s2", FLOAT, each.log_ns, float_data(7.0))
            else:
                writer.write(*each)
    recording = read(tmp_path / "bag", Topics(fields={"": "point.y"}))
    assert recording.s1.values.max() == 0.0
    assert recording.s2.values.min() == 7.0


def test_a_field_that_is_not_there_is_refused(tmp_path: Path) -> None:
    path = write_scalars(tmp_path / "bag", swing(1.0))
    with pytest.raises(MessageError, match=r"topic /s1: field 'data' .* choose one of: point.x"):
        read(path, Topics(fields={"s1": "data"}))


@pytest.mark.parametrize("behind_s", [0.0, 5.0])
def test_clocks_that_disagree_are_noted(tmp_path: Path, behind_s: float) -> None:
    shifted = [
        each._replace(time_s=each.time_s - behind_s, log_s=each.time_s)
        if each.topic == "/s2"
        else each
        for each in swing(10.0)
    ]
    recording = read(write_scalars(tmp_path / "bag", shifted))
    warned = any(x.startswith("WARN s2's stamps are 5.0 s behind") for x in recording.notes)
    assert warned is (behind_s > 0.0)


def test_messages_without_stamps_are_dated_by_the_log(tmp_path: Path) -> None:
    with BagWriter(tmp_path / "bag") as writer:
        for k in range(10):
            writer.write("/s1", FLOAT, at(k), float_data(k))
            writer.write("/s2", FLOAT, at(k), float_data(k))
    recording = read(tmp_path / "bag")
    assert recording.s1.stamps_ns.tolist() == [at(k) for k in range(10)]
    assert [note.partition(";")[0] for note in recording.notes] == [
        "/s1: std_msgs/msg/Float64 has no timestamp",
        "/s2: std_msgs/msg/Float64 has no timestamp",
    ]


@pytest.mark.parametrize("value", [1e101, -1e200])
def test_values_whose_squares_overflow_are_refused(tmp_path: Path, value: float) -> None:
    scalars = [each for each in swing(2.0) if each.time_s != 1.0]
    for topic in ("/s1", "/s2", "/truth"):
        path = write_scalars(tmp_path / topic[1:], [*scalars, Scalar(topic, 3.0, value)])
        with open_bag(path) as bag, pytest.raises(BagError, match=f"{topic} has values up to 1e"):
            read_recording(bag, Topics(), Parameters())


def test_weight_and_drift_are_read_where_they_are(tmp_path: Path) -> None:
    beside = [Scalar("/fusion_node/weight", 0.0, 0.25), Scalar("/fusion_node/weight", 1.0, 0.5)]
    path = write_scalars(tmp_path / "bag", [*swing(1.0), *beside])
    with open_bag(path) as bag:
        found = read_explanation(bag, Topics())
        assert found["weight"].values.tolist() == [0.25, 0.5]
        assert "drift" not in found
        assert read_explanation(bag, Topics(estimate="/robot/estimate")) == {}


def test_messages_can_be_watched(tmp_path: Path) -> None:
    path = write_scalars(tmp_path / "bag", swing(1.0))
    seen = []
    with open_bag(path) as bag:
        read_recording(
            bag,
            Topics(),
            Parameters(),
            progress=lambda found: (seen.append(each) or each for each in found),
        )
    assert sum(each.at.size for each in seen) == 310
