"""Offered QoS profiles, as bags of all versions hold them."""

from __future__ import annotations

from typing import Any

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st
from rosbags.rosbag2.metadata import dump_qos_v8, parse_qos

from fuzzy_fusion_ros.bag import QosProfile
from fuzzy_fusion_ros.bag.qos import INFINITE_NS, qos_from_rosbag2, qos_to_text
from fuzzy_fusion_ros.parameters.errors import BagError

DURATIONS = st.integers(0, INFINITE_NS)
PROFILES = st.builds(
    QosProfile,
    history=st.sampled_from(["system_default", "keep_last", "keep_all", "unknown"]),
    depth=st.integers(0, 1000),
    reliability=st.sampled_from(["system_default", "reliable", "best_effort", "unknown"]),
    durability=st.sampled_from(["system_default", "transient_local", "volatile", "unknown"]),
    deadline_ns=DURATIONS,
    lifespan_ns=DURATIONS,
    liveliness=st.sampled_from(["system_default", "automatic", "manual_by_topic", "unknown"]),
    liveliness_lease_ns=DURATIONS,
    avoid_ros_namespace_conventions=st.booleans(),
)


@given(st.lists(PROFILES, max_size=3))
def test_profiles_survive_every_form(profiles: list[QosProfile]) -> None:
    described = [each.to_rosbag2() for each in profiles]
    assert qos_from_rosbag2(described) == tuple(profiles)
    assert qos_from_rosbag2(qos_to_text(profiles)) == tuple(profiles)


@given(st.lists(PROFILES, min_size=1, max_size=3))
def test_rosbags_reads_ours_and_we_read_the_numbers_of_old_bags(
    profiles: list[QosProfile],
) -> None:
    theirs = parse_qos(yaml.safe_load(qos_to_text(profiles)))
    assert qos_from_rosbag2(dump_qos_v8(theirs)) == tuple(profiles)


@pytest.mark.parametrize("nothing", ["", [], None])
def test_no_profiles_are_none(nothing: object) -> None:
    assert qos_from_rosbag2(nothing) == ()


def test_no_profiles_are_no_text() -> None:
    assert qos_to_text([]) == ""


GOOD = QosProfile().to_rosbag2()


@pytest.mark.parametrize(
    "described",
    [
        "- nonsense",
        "nonsense",
        "{",
        3,
        [3],
        [GOOD | {"depth": "deep"}],
        [GOOD | {"history": 99}],
        [GOOD | {"deadline": None}],
        [{key: each for key, each in GOOD.items() if key != "lifespan"}],
    ],
)
def test_what_is_no_profile_is_refused(described: Any) -> None:
    with pytest.raises(BagError, match="are not rosbag2's"):
        qos_from_rosbag2(described)


def test_a_duration_beyond_all_is_infinite() -> None:
    """As bags of Foxy hold infinity."""
    (profile,) = qos_from_rosbag2([GOOD | {"deadline": {"sec": 2**63 - 1, "nsec": 2**32 - 1}}])
    assert profile.deadline_ns == INFINITE_NS
