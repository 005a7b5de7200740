# SPDX-License-Identifier: Apache-2.0
"""Several channels in one node: each is what a node of its own would be, bit for bit."""

from __future__ import annotations

import math
import struct
from collections.abc import Iterable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from nodes.watching import WARN, Diagnostics, Log

from fuzzy_fusion_ros.bag import BagMessage, BagWriter, open_bag
from fuzzy_fusion_ros.messages.outputs import EXPLANATION
from fuzzy_fusion_ros.nodes.fusion_node import FusionNode
from fuzzy_fusion_ros.offline.replay import differences, replay
from fuzzy_fusion_ros.offline.topics import Topics
from fuzzy_fusion_ros.parameters.errors import FusionError
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import replace
from fuzzy_fusion_ros.ros.subscription import RawSubscription
from fuzzy_fusion_ros.testing import Harness

POINT = "geometry_msgs/msg/PointStamped"
START_NS = 1_700_000_000_000_000_000
STEP_NS = 10_000_000
AXES = ("x", "y", "z")
OWN: dict[str, dict[str, Any]] = {
    "x": {"s1.field": "point.x", "s2.field": "point.x"},
    "y": {"s1.field": "point.y", "s2.field": "point.y", "predictor.enabled": True},
    "z": {"s1.field": "point.z", "s2.field": "point.z", "s1.bias_time_constant": 2.0},
}
SHARED: dict[str, Any] = {"gate.tolerance": 0.1, "s2.noise": 0.05}
TOGETHER: dict[str, Any] = {
    **SHARED,
    "channels": list(AXES),
    **{f"{axis}.{name}": value for axis, own in OWN.items() for name, value in own.items()},
}


def point(stamp_ns: int, values: Iterable[float]) -> bytes:
    """Return a PointStamped."""
    head = struct.pack("<4siIIxxxx", b"\0\1\0\0", *divmod(stamp_ns, 1_000_000_000), 1)
    return head + struct.pack("<3d", *values)


def stream(samples: int = 300) -> Iterator[tuple[str, int, list[float]]]:
    """Yield topic, stamp and numbers of messages: S2 before every tenth of S1."""
    for k in range(samples):
        truth = [math.sin(0.02 * k + axis) for axis in range(3)]
        if k % 10 == 0:
            yield "/s2", START_NS + k * STEP_NS, truth
        noisy = [value + 0.1 * math.sin(1.7 * k * k + axis) for axis, value in enumerate(truth)]
        yield "/s1", START_NS + k * STEP_NS, noisy


def written(path: Path, messages: Iterable[tuple[str, int, list[float]]]) -> Path:
    """Write messages as a bag."""
    with BagWriter(path) as writer:
        for topic, stamp_ns, values in messages:
            writer.write(topic, POINT, stamp_ns, point(stamp_ns, values))
    return path


def replayed(source: Path, output: Path, changes: dict[str, Any]) -> Path:
    """Replay a bag offline."""
    with open_bag(source) as bag:
        replay(bag, output, Topics(), replace(Parameters(), changes))
    return output


def messages(path: Path, topic: str) -> list[BagMessage]:
    with open_bag(path) as bag:
        return list(bag.messages([topic]))


def estimates(path: Path, axis: str) -> list[tuple[bytes, float]]:
    """Return stamp and number of every estimate of an axis."""
    at = 20 + 8 * AXES.index(axis)
    return [
        (each.data[4:12], struct.unpack_from("<d", each.data, at)[0])
        for each in messages(path, "/estimate")
    ]


def assert_each_is_a_node_of_its_own(together: Path, alone: Path, axis: str) -> None:
    """Compare estimates and all that explains them."""
    found = estimates(together, axis)
    assert len(found) == 300
    assert found == estimates(alone, axis)
    for name in EXPLANATION:
        ours = [each.data for each in messages(together, f"/fusion_node/{axis}/{name}")]
        assert ours == [each.data for each in messages(alone, f"/fusion_node/{name}")], name


def test_each_channel_is_a_replay_of_its_own(tmp_path: Path) -> None:
    bag = written(tmp_path / "bag", stream())
    together = replayed(bag, tmp_path / "together", TOGETHER)
    for axis in AXES:
        alone = replayed(bag, tmp_path / axis, {**SHARED, **OWN[axis]})
        assert_each_is_a_node_of_its_own(together, alone, axis)


def has_received(subscription: RawSubscription, more_than: int) -> bool:
    return subscription.received > more_than


def run(folder: Path, changes: dict[str, Any]) -> Path:
    """Run a node on the stream over DDS; return what it has recorded."""
    with Harness() as harness:
        node = harness.fusion_node({**changes, "record": str(folder)})
        publishers = {topic: harness.publisher(topic) for topic in ("/s1", "/s2")}
        harness.spin_until_matched(*publishers.values())
        inputs = {"/s1": node.channels[0].s1, "/s2": node.channels[0].s2}
        for topic, stamp_ns, values in stream():
            subscription = inputs[topic].subscription
            more_than = subscription.received
            publishers[topic].publish(point(stamp_ns, values))
            harness.spin_until(partial(has_received, subscription, more_than))
    return folder


def test_each_channel_is_a_node_of_its_own_over_dds(tmp_path: Path) -> None:
    together = run(tmp_path / "together", TOGETHER)
    for axis in AXES:
        alone = run(tmp_path / axis, {**SHARED, **OWN[axis]})
        assert_each_is_a_node_of_its_own(together, alone, axis)
    topics = [
        "/s1",
        "/s2",
        "/estimate",
        *(f"/fusion_node/{a}/{n}" for a in AXES for n in EXPLANATION),
    ]
    again = replayed(together, tmp_path / "again", TOGETHER)
    assert differences(together, again, topics) == []


def test_inputs_on_one_topic_are_received_and_recorded_once(tmp_path: Path) -> None:
    bag = tmp_path / "bag"
    with Harness() as harness:
        fields = {"x.s1.field": "point.y", "x.s2.field": "point.x", "y.s1.field": "point.z"}
        changes = {"channels": ["x", "y"], **fields, "y.s2.field": "point.z", "record": str(bag)}
        arguments = ("-r", "s1:=/both", "-r", "s2:=/both")
        node = harness.add(FusionNode, {"qos": "reliable", **changes}, arguments=arguments)
        publisher = harness.publisher("/both")
        harness.spin_until_matched(publisher)
        assert harness.node.count_subscribers("/both") == 1
        for _, stamp_ns, values in stream(20):
            publisher.publish(point(stamp_ns, values))
        source = node.channels[0].s1.subscription
        harness.spin_until(lambda: source.received == 22)
    assert len(messages(bag, "/both")) == 22


def without_y(topic: str, after: int) -> Iterator[tuple[str, int, list[float]]]:
    """Yield the stream with no number in y from a sample on."""
    for name, stamp_ns, values in stream():
        gone = name == topic and stamp_ns >= START_NS + after * STEP_NS
        yield name, stamp_ns, [values[0], math.nan, values[2]] if gone else values


def test_a_single_sample_that_a_channel_lacks_withholds_the_message(tmp_path: Path) -> None:
    sent = list(stream())
    at = next(k for k, each in enumerate(sent) if each[:2] == ("/s1", START_NS + 55 * STEP_NS))
    sent[at] = (*sent[at][:2], [0.0, math.nan, 0.0])
    bag = written(tmp_path / "bag", sent)
    found = estimates(replayed(bag, tmp_path / "out", TOGETHER), "x")
    whole = estimates(replayed(written(tmp_path / "w", stream()), tmp_path / "o", TOGETHER), "x")
    assert [each for each, _ in found] == [each for each, _ in whole[:55] + whole[56:]]


def test_the_field_of_a_channel_that_is_gone_is_that_of_s2(tmp_path: Path) -> None:
    bag = written(tmp_path / "bag", without_y("/s1", after=0))
    with open_bag(bag) as opened:
        notes = replay(opened, tmp_path / "out", Topics(), replace(Parameters(), TOGETHER)).notes
    held = [value for name, _, (_, value, _) in stream() if name == "/s2" for _ in range(10)]
    found = estimates(tmp_path / "out", "y")
    assert [value for _, value in found] == held
    alone = replayed(bag, tmp_path / "x", {**SHARED, **OWN["x"]})
    assert estimates(tmp_path / "out", "x") == estimates(alone, "x")
    assert "y: 300 estimates written without it; its field is that of S2" in notes


def test_the_field_of_a_channel_that_is_gone_is_in_the_unit_of_the_estimate(tmp_path: Path) -> None:
    """S2's y, in thousandths, goes into z, and S2's x into x."""
    bag = written(tmp_path / "bag", without_y("/s1", after=0))
    y = {"field": "point.y", "scale": 0.001}
    changes = {
        "channels": ["milli", "x"],
        **{f"milli.{role}.{name}": value for role in ("s1", "s2") for name, value in y.items()},
        "milli.estimate.field": "point.z",
        "x.s1.field": "point.x",
        "x.s2.field": "point.x",
    }
    found = estimates(replayed(bag, tmp_path / "out", changes), "z")
    held = [0.001 * v[1] for name, _, v in stream() if name == "/s2" for _ in range(10)]
    assert [value for _, value in found] == held


def test_the_field_of_a_channel_that_is_gone_keeps_the_newest_number_of_s2(tmp_path: Path) -> None:
    sent = [
        (name, at, [v[0], math.nan, v[2]] if name == "/s1" or at > START_NS + 95 * STEP_NS else v)
        for name, at, v in stream()
    ]
    found = estimates(replayed(written(tmp_path / "b", sent), tmp_path / "out", TOGETHER), "y")
    held = [v[1] for name, at, v in sent if name == "/s2" for _ in range(10)]
    assert [value for _, value in found] == held[:100] + 200 * [held[99]]


def test_nothing_is_made_up_for_a_channel_of_which_s2_has_no_number(tmp_path: Path) -> None:
    bag = written(tmp_path / "bag", ((t, s, [v[0], math.nan, v[2]]) for t, s, v in stream()))
    with (
        open_bag(bag) as opened,
        pytest.raises(FusionError, match="y has neither an estimate nor a value of S2") as caught,
    ):
        replay(opened, tmp_path / "out", Topics(), replace(Parameters(), TOGETHER))
    assert "written without it" not in str(caught.value)


def test_a_channel_that_misses_five_estimates_in_a_row_holds_back_no_more(tmp_path: Path) -> None:
    """However long the intervals of its own samples are."""
    sent = [
        (name, at, [v[0], v[1] if k % 40 == 0 else math.nan, v[2]] if name == "/s1" else v)
        for k, (name, at, v) in enumerate(stream(), 1)
    ]
    assert len(sent) == 330
    has_y = [not math.isnan(v[1]) for name, _, v in sent if name == "/s1"]
    stamps = [START_NS + k * STEP_NS for k in range(300)]
    missed, expected = 5, []
    for at, has in zip(stamps, has_y, strict=True):
        if has or missed >= 5:
            expected.append(at)
        missed = 0 if has else missed + 1
    assert 0 < len(stamps) - len(expected) == 5 * sum(has_y)
    bag = written(tmp_path / "bag", sent)
    with open_bag(bag) as opened:
        notes = replay(opened, tmp_path / "out", Topics(), replace(Parameters(), TOGETHER)).notes
    found = [struct.unpack("<iI", at) for at, _ in estimates(tmp_path / "out", "x")]
    assert found == [divmod(at, 1_000_000_000) for at in expected]
    skipped = len(stamps) - len(expected)
    assert f"y: {skipped} estimates skipped: y had no estimate at their stamps" in notes


def test_a_channel_without_an_estimate_since_a_jump_holds_back_no_other(tmp_path: Path) -> None:
    again = [
        (name, at - 3600 * 100 * STEP_NS, [v[0], math.nan, v[2]] if name == "/s1" else v)
        for name, at, v in stream()
    ]
    sent = [*stream(), *again]
    bag = written(tmp_path / "bag", stream())
    with BagWriter(tmp_path / "jump") as writer:
        for k, (topic, at, values) in enumerate(sent):
            writer.write(topic, POINT, START_NS + k * STEP_NS, point(at, values))
    whole = len(estimates(replayed(bag, tmp_path / "w", TOGETHER), "x"))
    with open_bag(tmp_path / "jump") as opened:
        notes = replay(opened, tmp_path / "out", Topics(), replace(Parameters(), TOGETHER)).notes
    found = len(estimates(tmp_path / "out", "x"))
    alone = replayed(tmp_path / "jump", tmp_path / "x", {**SHARED, **OWN["x"]})
    assert whole < found == len(estimates(alone, "x"))
    assert not [each for each in notes if "skipped" in each]


def test_diagnostics_and_log_name_the_channel(
    harness: Harness, diagnostics: Diagnostics, log: Log
) -> None:
    harness.fusion_node(TOGETHER)
    publishers = {topic: harness.publisher(topic) for topic in ("/s1", "/s2")}
    harness.spin_until_matched(*publishers.values())
    for topic, stamp_ns, values in without_y("/s1", after=0):
        publishers[topic].publish(point(stamp_ns, values))
    diagnostics.having("fusion_node: x.fusion", "mode", "FUSED")
    said = diagnostics.having("fusion_node: y.s1", "received", "100")
    assert (said.level, said.values["admitted"]) == (WARN, "0")
    log.wait_for("y: s1: /s1, point.y of geometry_msgs/msg/PointStamped")


def test_a_shared_value_set_at_run_time_reaches_channels_without_their_own(
    harness: Harness,
) -> None:
    node = harness.fusion_node({**TOGETHER, "y.gate.tolerance": 0.5})
    (result,) = node.set_parameters(
        [node.get_parameter("gate.tolerance").__class__("gate.tolerance", value=0.25)]
    )
    assert result.successful
    found = [each.fusion.parameters.gate.tolerance for each in node.channels]
    assert found == [0.25, 0.5, 0.25]
    assert [node.get_parameter(f"{axis}.gate.tolerance").value for axis in AXES] == found


@pytest.mark.parametrize(
    ("changes", "problem"),
    [
        ({"y.s2.field": "point.x", "y.s1.field": "point.x"}, "x and y both write point.x of"),
        (
            {"y.s2.type": "geometry_msgs/msg/Vector3Stamped", "y.s2.field": "vector.y"},
            "/s2 is configured as geometry_msgs/msg/PointStamped and as geometry_msgs/msg/Vector3",
        ),
        ({"y.estimate.type": "std_msgs/Float64"}, "that of x is .*PointStamped and that of y std_"),
        ({"channels": ["x", "s1"]}, "'s1' is a parameter"),
        ({"rol.s1.field": "point.x"}, "there is no channel 'rol' in channels, which has: x, y, z"),
    ],
)
def test_channels_that_do_not_go_together_refuse_the_start(
    harness: Harness, changes: dict[str, Any], problem: str
) -> None:
    given = {
        name: value
        for name, value in TOGETHER.items()
        if "channels" not in changes or name.partition(".")[0] not in AXES
    }
    with pytest.raises(FusionError, match=problem):
        harness.add(FusionNode, {**given, **changes})
