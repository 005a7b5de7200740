# SPDX-License-Identifier: Apache-2.0
"""Checks and surveys of bags."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from bag.making import POINT, STORE
from bag.recorded import Scalar, at, message, write_scalars
from presets.sensors import IMU, TURN, VELOCITY, Rig, Sensor, write_rig

from fuzzy_fusion_ros.bag import BagWriter, open_bag
from fuzzy_fusion_ros.checking.check import Check
from fuzzy_fusion_ros.checking.finding import Level
from fuzzy_fusion_ros.checking.survey import Together
from fuzzy_fusion_ros.offline import check as module
from fuzzy_fusion_ros.offline.check import check_bag, survey_bag, warnings_of
from fuzzy_fusion_ros.offline.topics import Topics
from fuzzy_fusion_ros.parameters.errors import BagError, MessageError
from fuzzy_fusion_ros.parameters.file import parameters_from
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import replace

ROOT = Path(__file__).resolve().parents[2]
BAGS = ROOT / "bags"
HEADING = ROOT / "config" / "presets" / "heading.yaml"


def checked(path: Path, topics: Topics | None = None, **window: float) -> Check:
    with open_bag(path) as bag:
        return check_bag(bag, topics or Topics(), Parameters(), **window)


def surveyed(path: Path) -> list[Together]:
    with open_bag(path) as bag:
        return survey_bag(bag, Topics()).together


def motion(time_s: float) -> float:
    return math.sin(time_s) + math.sin(2.3 * time_s + 1.0)


def scalars(sign: float = 1.0, behind: float = 0.0) -> list[Scalar]:
    """Make S1 at 50 Hz and S2 at 10 Hz, 0.2 s late."""
    found = []
    for k in range(1500):
        time_s = 0.02 * k
        found.append(Scalar("/s1", time_s, sign * motion(time_s) + 0.01 * math.sin(k * k)))
        if k % 5 == 0:
            value = motion(time_s - 0.2) + 0.01 * math.cos(k * k)
            found.append(Scalar("/s2", time_s - behind, value, log_s=time_s))
    return found


@pytest.mark.parametrize("bag", sorted(each.parent.name for each in BAGS.glob("*/metadata.yaml")))
def test_no_recording_of_ours_gives_a_warning(bag: str) -> None:
    found = checked(BAGS / bag)
    assert found.findings == ()
    assert found.relation is not None
    assert found.relation.correlation > 0.9


def test_what_is_wrong_with_a_bag(tmp_path: Path) -> None:
    path = write_scalars(tmp_path / "bag", scalars(sign=-1.0, behind=5.0))
    found = checked(path)
    assert {each.about for each in found.findings} == {"sign", "clock offset"}
    assert found.characters["s1"].source == "/s1 point.x"
    assert found.characters["s1"].samples == 1500


def test_a_span_of_a_bag(tmp_path: Path) -> None:
    path = write_scalars(tmp_path / "bag", scalars())
    found = checked(path, start_s=10.0, end_s=20.0)
    assert found.characters["s1"].samples == 500


def test_topics_and_fields_that_are_not_there(tmp_path: Path) -> None:
    path = write_scalars(tmp_path / "bag", scalars())
    with pytest.raises(BagError, match="/other"):
        checked(path, Topics(s2="/other"))
    with pytest.raises(MessageError, match="no field 'data'"):
        checked(path, Topics(fields={"s1": "data"}))


def test_one_topic_for_both(tmp_path: Path) -> None:
    path = write_scalars(tmp_path / "bag", scalars())
    (finding,) = checked(path, Topics(s2="/s1")).findings
    assert finding.about == "same topic"
    other = checked(path, Topics(s2="/s1", fields={"s2": "point.y"}))
    assert "same topic" not in {each.about for each in other.findings}


def write_joints(path: Path, elements: int, empty: range = range(0)) -> None:
    """Write joints, one of which another topic follows, 0.3 s later and in degrees.

    The position is an empty array in some messages.
    """
    joint_state = STORE.types["sensor_msgs/msg/JointState"]
    header, time = STORE.types["std_msgs/msg/Header"], STORE.types["builtin_interfaces/msg/Time"]
    generator = np.random.default_rng(0)
    kernel = np.exp(-np.arange(60) / 12.0)
    walks = [np.convolve(generator.normal(size=1859), kernel, "valid") for _ in range(elements)]
    with BagWriter(path) as writer:
        for k in range(1800):
            stamp = header(time(*divmod(at(0.02 * k), 10**9)), "base")
            position = np.array([] if k in empty else [each[k] for each in walks])
            joints = joint_state(
                stamp, [f"joint{j}" for j in range(elements)], position, np.ones(2), np.empty(0)
            )
            data = bytes(STORE.serialize_cdr(joints, "sensor_msgs/msg/JointState"))
            writer.write("/joints", "sensor_msgs/msg/JointState", at(0.02 * k), data)
            if k % 5 == 0 and k >= 15:
                value = 57.3 * float(walks[min(3, elements - 1)][k - 15])
                writer.write(*message(Scalar("/angle", 0.02 * k, value)))


@pytest.mark.parametrize(
    ("field", "swapped", "is_named"),
    [
        ("position[0]", range(900, 1500), True),
        ("position[0]", range(1499, 1500), True),
        ("position[0]", range(0), False),
        ("name=pole:position", range(900, 1500), False),
        ("header.stamp.sec", range(900, 1500), False),
    ],
)
def test_joints_that_change_places_are_named(
    tmp_path: Path, field: str, swapped: range, is_named: bool
) -> None:
    joint_state = STORE.types["sensor_msgs/msg/JointState"]
    header, time = STORE.types["std_msgs/msg/Header"], STORE.types["builtin_interfaces/msg/Time"]
    with BagWriter(tmp_path / "bag") as writer:
        for k in range(1500):
            order = -1 if k in swapped else 1
            joints = joint_state(
                header(time(*divmod(at(0.02 * k), 10**9)), "base"),
                ["pole", "cart"][::order],
                np.array([np.sin(0.02 * k), 5.0])[::order].copy(),
                np.empty(0),
                np.empty(0),
            )
            data = bytes(STORE.serialize_cdr(joints, "sensor_msgs/msg/JointState"))
            writer.write("/joints", "sensor_msgs/msg/JointState", at(0.02 * k), data)
            if k % 5 == 0:
                writer.write(*message(Scalar("/angle", 0.02 * k, float(np.sin(0.02 * k)))))
    found = checked(tmp_path / "bag", Topics("/joints", "/angle", fields={"s1": field})).findings
    about = [each for each in found if each.about == "element"]
    assert [each.text for each in about] == [
        "position[0] of s1 is 'pole' in some messages and 'cart' in others"
    ] * is_named
    assert [each.remedy for each in about] == ["the field name=pole:position"] * is_named


@pytest.mark.parametrize(("every", "is_named"), [(2, True), (7, True), (1000, False)])
def test_frames_of_two_publishers_on_one_topic_are_named(
    tmp_path: Path, every: int, is_named: bool
) -> None:
    point, header = STORE.types[POINT], STORE.types["std_msgs/msg/Header"]
    time, vector = (
        STORE.types["builtin_interfaces/msg/Time"],
        STORE.types["geometry_msgs/msg/Point"],
    )
    with BagWriter(tmp_path / "bag") as writer:
        for k, each in enumerate(scalars()):
            frame = "left" if k // every % 2 and each.topic == "/s1" else "right_side"
            stamp = time(*divmod(at(each.time_s), 10**9))
            data = point(header(stamp, frame), vector(each.value, 0.0, 0.0))
            log_ns = at(each.time_s if each.log_s is None else each.log_s)
            writer.write(each.topic, POINT, log_ns, bytes(STORE.serialize_cdr(data, POINT)))
    findings = checked(tmp_path / "bag").findings
    assert [each.about for each in findings] == ["publishers"] * is_named
    with open_bag(tmp_path / "bag") as bag:
        assert len(warnings_of(bag, Topics(), Parameters())) == is_named


def test_replay_score_and_tune_repeat_a_period_in_another_unit(tmp_path: Path) -> None:
    path = write_scalars(tmp_path / "bag", scalars())
    for period, count in ((360.0, 1), (2.0 * math.pi, 0)):
        parameters = replace(Parameters(), {"signal.period": period, "signal.unit": "rad"})
        with open_bag(path) as bag:
            found = warnings_of(bag, Topics(), parameters)
        assert sum(each.startswith("WARN signal.period is 360") for each in found) == count


JOINT = Topics("/joints", "/angle", fields={"s1": "position[3]"})


def test_a_check_on_the_way_goes_on_where_the_first_messages_lack_the_number(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "WARNED_MESSAGES", 300)
    write_joints(tmp_path / "bag", 5, empty=range(1000))
    both = JOINT._replace(s2="/joints", fields={"s1": "position[3]", "s2": "position[2]"})
    with open_bag(tmp_path / "bag") as bag:
        assert warnings_of(bag, JOINT, Parameters()) == ()
        assert warnings_of(bag, both, Parameters()) == ()
    found = checked(tmp_path / "bag", JOINT)
    assert found.characters["s1"].samples == 800
    assert "1000 of 1800 messages of s1 have no readable position[3]" in map(str, found.findings)


def test_the_number_that_no_message_of_a_span_has_is_named(tmp_path: Path) -> None:
    write_joints(tmp_path / "bag", 5, empty=range(500, 1000))
    with pytest.raises(MessageError, match=r"/joints: .*position\[3\]"):
        checked(tmp_path / "bag", JOINT, start_s=10.0, end_s=20.0)


def test_elements_of_short_arrays_are_surveyed(tmp_path: Path) -> None:
    write_joints(tmp_path / "bag", 5)
    (found,) = surveyed(tmp_path / "bag")
    assert (found.s1.topic, found.s1.path) == ("/joints", "position[3]")
    assert (found.s2.topic, found.s2.path) == ("/angle", "point.x")
    assert found.relation.lag == pytest.approx(0.3, abs=0.05)
    assert found.relation.middle_scale == pytest.approx(57.3, rel=0.05)


def test_long_arrays_are_left_out_of_a_survey(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "MOST_ELEMENTS", 4)
    write_joints(tmp_path / "bag", 5)
    assert surveyed(tmp_path / "bag") == []


def test_of_a_long_bag_every_so_many_messages_are_surveyed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "MOST_NUMBERS", 2000)
    monkeypatch.setattr(module, "FEWEST_MESSAGES", 100)
    write_joints(tmp_path / "bag", 5)
    (found,) = surveyed(tmp_path / "bag")
    assert found.s1.motion.values.size == 258  # one message in seven
    assert found.relation.lag == pytest.approx(0.3, abs=0.1)


def test_a_survey_of_our_recordings() -> None:
    pairs = {(each.s1.topic, each.s2.topic) for each in surveyed(BAGS / "nominal")}
    assert ("/s1", "/s2") in pairs
    assert ("/truth", "/estimate") in pairs


def test_a_survey_goes_by_the_log_where_stamps_are_off(tmp_path: Path) -> None:
    path = write_scalars(tmp_path / "bag", scalars(behind=5.0))
    (found,) = surveyed(path)
    assert found.relation.lag == pytest.approx(0.2, abs=0.05)


def driven(t: float) -> float:
    """Time on the move: a vehicle that stands from 40 s to 65 s."""
    return min(t, 40.0) + max(t - 65.0, 0.0)


def course(t: float) -> float:
    return 0.05 * driven(t) + 1.2 * math.sin(0.3 * driven(t))


def turning(factor: float) -> Sensor:
    """A gyro that turns with the course, or the other way, or in another unit."""
    return IMU._replace(
        fields=lambda t, a, b: {
            "angular_velocity.z": factor
            * (50.0 * (course(t + 0.01) - course(t - 0.01)) + 0.003 + 0.01 * a)
        }
    )


def receiver(way: str, frame: str) -> tuple[Sensor, str]:
    """A GNSS receiver whose course is random at standstill, and where its course is."""

    def velocity(t: float, a: float, b: float) -> tuple[float, float]:
        speed = 0.0 if 40.3 < t < 65.3 else 8.0
        at = course(t - 0.3) + (2.0 if frame == "NED" else 0.0)
        x, y = speed * math.cos(at) + 0.02 * a, speed * math.sin(at) + 0.02 * b
        return (x, y) if frame == "NED" else (y, x)

    if way == "Odometry":

        def pose(t: float, a: float, b: float) -> dict[str, float]:
            x, y = velocity(t, a, b)
            half = 0.5 * math.atan2(y, x)
            names = "pose.pose.orientation.z", "pose.pose.orientation.w", "twist.twist.linear.x"
            return dict(zip(names, (math.sin(half), math.cos(half), math.hypot(x, y)), strict=True))

        sensor = VELOCITY._replace(type_name="nav_msgs/msg/Odometry", fields=pose)
        return sensor, "yaw(pose.pose.orientation)"
    owner = "twist.linear" if way == "TwistStamped" else "twist.twist.linear"
    sensor = VELOCITY._replace(
        type_name=f"geometry_msgs/msg/{way}",
        fields=lambda t, a, b: dict(
            zip((f"{owner}.x", f"{owner}.y"), velocity(t, a, b), strict=True)
        ),
    )
    return sensor, f"atan2({owner}.y, {owner}.x)"


@pytest.mark.parametrize("frame", ["NED", "ENU"])
@pytest.mark.parametrize(
    ("way", "factor"),
    [
        ("TwistStamped", 1.0),
        ("TwistWithCovarianceStamped", -1.0),
        ("Odometry", 180.0 / math.pi),
    ],
)
def test_a_course_that_is_random_at_standstill_is_compared_in_motion(
    tmp_path: Path, frame: str, way: str, factor: float
) -> None:
    sensor, path = receiver(way, frame)
    with open_bag(write_rig(tmp_path / "bag", Rig(turning(factor), sensor, {"": driven}))) as bag:
        advice = {each.job.preset: each for each in survey_bag(bag, Topics()).advice}["heading"]
        as_truth = survey_bag(bag, Topics(truth=sensor.topic)).advice
        topics = Topics(IMU.topic, sensor.topic, fields={"s2": path})
        found = check_bag(bag, topics, parameters_from(HEADING))
        unset = check_bag(
            bag, topics, replace(parameters_from(HEADING), {"signal.period": 0.0})
        ).findings
    scale = (1.0 if frame == "NED" else -1.0) / factor
    assert "heading" not in {each.job.preset for each in as_truth}
    assert advice.s2.path == path
    assert advice.additions == ([] if scale == 1.0 else [f"s1.scale: {scale:.7g}"])
    assert found.relation is not None
    assert found.relation.correlation > 0.98
    assert found.relation.sign * found.relation.middle_scale == pytest.approx(scale, rel=0.1)
    assert {each.remedy for each in found.findings if each.level is Level.ERROR} == (
        set() if scale == 1.0 else {f"s1.scale: {scale:.7g}"}
    )
    assert f"signal.period: {TURN:.10g}" in {each.remedy for each in unset}
