# SPDX-License-Identifier: Apache-2.0
"""A managed node: its transitions over DDS, and what comes of samples in each state."""

from __future__ import annotations

import gc
from collections.abc import Callable
from pathlib import Path

import pytest
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState, GetState
from nodes.watching import Diagnostics
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter
from std_srvs.srv import SetBool

from fuzzy_fusion_ros.bag import open_bag
from fuzzy_fusion_ros.testing import Feed, Harness

CONFIGURE, CLEAN_UP = Transition.TRANSITION_CONFIGURE, Transition.TRANSITION_CLEANUP
ACTIVATE, DEACTIVATE = Transition.TRANSITION_ACTIVATE, Transition.TRANSITION_DEACTIVATE

Change = Callable[[int], bool]


@pytest.fixture
def change(harness: Harness) -> Change:
    """Ask the node for a transition; return whether it took place."""

    def ask(transition: int) -> bool:
        request = ChangeState.Request(transition=Transition(id=transition))
        return bool(harness.call(ChangeState, "/fusion_node/change_state", request).success)

    return ask


def state(harness: Harness) -> str:
    answer = harness.call(GetState, "/fusion_node/get_state", GetState.Request())
    return str(answer.current_state.label)


def ramp(feed: Feed, start: float) -> list[float]:
    return [feed(start + 0.01 * k, s1=0.01 * k, s2=0.01 * k) for k in range(20)]


def test_a_node_goes_through_all_its_states(harness: Harness, change: Change) -> None:
    harness.fusion_node({"lifecycle": True})
    assert state(harness) == "unconfigured"
    assert harness.node.count_subscribers("/s1") == 0
    assert change(CONFIGURE)
    assert state(harness) == "inactive"
    feed = harness.feed()
    feed.send(0.0, s1=1.0, s2=1.0)
    assert change(ACTIVATE)
    assert state(harness) == "active"
    assert feed(0.1, s1=1.0, s2=1.0) == 1.0
    assert change(DEACTIVATE)
    feed.send(0.2, s1=1.0, s2=1.0)
    assert change(ACTIVATE)
    assert feed(0.3, s1=1.0, s2=1.0) == 1.0
    assert len(feed.estimates) == 2  # none of what came while it was inactive
    assert change(DEACTIVATE)
    assert change(CLEAN_UP)
    assert state(harness) == "unconfigured"
    harness.spin_until(lambda: harness.node.count_subscribers("/s1") == 0, "s1 to be left")
    assert change(Transition.TRANSITION_UNCONFIGURED_SHUTDOWN)
    assert state(harness) == "finalized"


def test_configured_again_it_starts_from_nothing(harness: Harness, change: Change) -> None:
    """Estimates are those of a node that is not managed."""
    plain = harness.fusion_node({"predictor.enabled": True})
    expected = ramp(harness.feed(), 0.0)
    harness.remove(plain)
    harness.fusion_node({"predictor.enabled": True, "lifecycle": True})
    for k in range(2):
        assert change(CONFIGURE)
        assert change(ACTIVATE)
        assert ramp(harness.feed(), 1.0 - k) == expected  # earlier the second time: it is forgotten
        assert change(DEACTIVATE)
        assert change(CLEAN_UP)


def test_a_transition_out_of_turn_is_refused(harness: Harness, change: Change) -> None:
    harness.fusion_node({"lifecycle": True})
    assert not change(ACTIVATE)
    assert state(harness) == "unconfigured"


def test_what_cannot_be_configured_says_why(
    harness: Harness, change: Change, capfd: pytest.CaptureFixture[str]
) -> None:
    harness.fusion_node({"lifecycle": True, "s2.type": "geometry_msgs/msg/Pointy"})
    assert not change(CONFIGURE)
    assert state(harness) == "unconfigured"
    assert "not configured: message type 'geometry_msgs/msg/Pointy'" in capfd.readouterr().err
    assert harness.node.count_subscribers("/s1") == 0


def test_parameters_set_before_are_used(harness: Harness, change: Change) -> None:
    harness.fusion_node({"lifecycle": True, "trigger": "pair"})
    offset = Parameter("aggregator.weight.very_large", value=0.9).to_parameter_msg()
    request = SetParameters.Request(parameters=[offset])
    answer = harness.call(SetParameters, "/fusion_node/set_parameters", request)
    assert answer.results[0].successful
    assert change(CONFIGURE)
    assert change(ACTIVATE)
    assert harness.feed()(0.0, s1=1.0, s2=1.0) == 1.0


def test_enable_does_not_activate(
    harness: Harness, change: Change, diagnostics: Diagnostics
) -> None:
    harness.fusion_node({"lifecycle": True})
    assert change(CONFIGURE)
    answer = harness.call(SetBool, "/fusion_node/enable", SetBool.Request(data=True))
    assert not answer.success
    assert "inactive" in answer.message
    status = diagnostics.saying("fusion_node: fusion", "INACTIVE")
    assert status.values["estimates"] == "0"


def test_cleaned_up_its_bag_is_whole(harness: Harness, change: Change, tmp_path: Path) -> None:
    harness.fusion_node({"lifecycle": True, "record": str(tmp_path / "live")})
    assert change(CONFIGURE)
    assert change(ACTIVATE)
    ramp(harness.feed(), 0.0)
    assert change(DEACTIVATE)
    assert change(CLEAN_UP)
    with open_bag(tmp_path / "live") as bag:
        assert bag.problems == []
        assert bag.topics["/estimate"].message_count == 20


@pytest.mark.parametrize("transitions", [(), (CONFIGURE,), (CONFIGURE, ACTIVATE)])
def test_it_leaves_the_graph_at_once(
    harness: Harness, change: Change, transitions: tuple[int, ...]
) -> None:
    """Not only when the garbage collector comes by: rclpy keeps the states, and they the node."""
    gc.collect()
    gc.disable()
    try:
        node = harness.fusion_node({"lifecycle": True})
        assert all(map(change, transitions))
        harness.remove(node)
    finally:
        gc.enable()
