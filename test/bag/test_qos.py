# SPDX-License-Identifier: Apache-2.0
"""Offered QoS profiles, as bags of all versions hold them."""

from __future__ import annotations

from typing import Any

import pytest
import yaml
from rosbags.interfaces import QosTime
from rosbags.rosbag2.metadata import dump_qos_v8, dump_qos_v9, parse_qos

from fuzzy_fusion_ros.bag import offered_qos
from fuzzy_fusion_ros.bag.metadata import qos_from_text, qos_to_text
from fuzzy_fusion_ros.parameters.errors import BagError

PROFILES = (
    offered_qos(),
    offered_qos(3, "best_effort", "transient_local"),
    offered_qos()._replace(deadline=QosTime(1, 5), avoid_ros_namespace_conventions=True),
)


def test_profiles_survive_as_text() -> None:
    text = qos_to_text(PROFILES)
    assert qos_from_text(text) == PROFILES
    assert tuple(parse_qos(text)) == PROFILES


def test_the_numbers_of_old_bags_are_read() -> None:
    """Up to version 8 rosbag2 wrote rmw's numbers, in a text within the YAML."""
    assert qos_from_text(dump_qos_v8(list(PROFILES))) == PROFILES


@pytest.mark.parametrize("nothing", ["", "[]", "~"])
def test_no_profiles_are_none(nothing: str) -> None:
    assert qos_from_text(nothing) == ()
    assert qos_to_text(()) == ""


GOOD: dict[str, Any] = dict(dump_qos_v9([offered_qos()])[0])


@pytest.mark.parametrize(
    "text",
    [
        "- nonsense",
        "nonsense",
        "'- nonsense'",
        "{",
        "3",
        "[3]",
        yaml.safe_dump([GOOD | {"depth": "deep"}]),
        yaml.safe_dump([GOOD | {"history": []}]),
        yaml.safe_dump([GOOD | {"deadline": None}]),
        yaml.safe_dump([GOOD | {"deadline": {"sec": "long", "nsec": 0}}]),
        yaml.safe_dump([{key: each for key, each in GOOD.items() if key != "lifespan"}]),
    ],
)
def test_what_is_no_profile_is_refused(text: str) -> None:
    with pytest.raises(BagError, match="are not valid"):
        qos_from_text(text)


@pytest.mark.parametrize("policy", ["history", "reliability", "durability", "liveliness"])
def test_a_policy_that_nobody_knows_is_unknown(policy: str) -> None:
    for value in (99, "firm"):
        (profile,) = qos_from_text(yaml.safe_dump([GOOD | {policy: value}]))
        assert getattr(profile, policy).name == "UNKNOWN"
