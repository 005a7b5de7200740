# SPDX-License-Identifier: Apache-2.0
"""Types of a package that only the user has: built from ``.msg`` files, fused, recorded, replayed.

The package is made by the rosidl generators in a scratch workspace. This process has never heard of
it; the nodes run in processes that have the workspace sourced.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import pytest
import yaml
from building import run
from nodes.interface_workspace import BARE, HEADED, Workspace, build

from fuzzy_fusion_ros.bag import open_bag
from fuzzy_fusion_ros.core.sample import Sample
from fuzzy_fusion_ros.messages import load_message_class
from fuzzy_fusion_ros.messages.outputs import EXPLANATION
from fuzzy_fusion_ros.offline.replay import differences
from fuzzy_fusion_ros.online.fusion import Fusion
from fuzzy_fusion_ros.parameters.errors import MessageError
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import replace

pytestmark = pytest.mark.xdist_group("interface package")

OTHER_WAY = pytest.mark.slow("the same types the other way round")
TOPICS = ["/s1", "/s2", "/estimate", *(f"/fusion_node/{name}" for name in EXPLANATION)]

STAMPS_NS = [5_000_000_001 + 10_000_000 * k for k in range(60)]
S2 = [Sample(at, math.sin(0.1 * k)) for k, at in enumerate(STAMPS_NS)]
S1 = [Sample(at, value + 0.2 * (-1) ** k) for k, (at, value, _) in enumerate(S2)]


@pytest.fixture(scope="module")
def workspace(tmp_path_factory: pytest.TempPathFactory) -> Workspace:
    """The built package."""
    return build(tmp_path_factory.mktemp("workspace"))


def expected(parameters: Parameters) -> list[Sample]:
    """Return the estimates of the core."""
    fusion, found = Fusion(parameters), []
    for one, other in zip(S1, S2, strict=True):
        estimates = fusion.on_s2(other).estimates + fusion.on_s1(one).estimates
        found += [Sample(each.stamp_ns, each.estimate.value) for each in estimates]
    return found


def pairs(samples: Sequence[Sample]) -> list[tuple[int, float]]:
    return [(sample.stamp_ns, sample.value) for sample in samples]


def samples(values: Sequence[tuple[int, float]]) -> list[Sample]:
    return [Sample(*each) for each in values]


def test_the_package_is_unknown_here() -> None:
    for each in (HEADED, BARE):
        with pytest.raises(MessageError, match="scratch_interfaces"):
            load_message_class(each)


@pytest.mark.parametrize(
    ("s1_type", "s2_type"), [(HEADED, BARE), pytest.param(BARE, HEADED, marks=OTHER_WAY)]
)
def test_its_types_are_fused_recorded_and_replayed(
    workspace: Workspace, tmp_path: Path, s1_type: str, s2_type: str
) -> None:
    values = {
        "s1.type": s1_type,
        "s2.type": s2_type,
        "trigger": "pair",
        "qos": "reliable",
        "predictor.enabled": True,
    }
    parameters, live = tmp_path / "parameters.yaml", tmp_path / "live"
    parameters.write_text(yaml.safe_dump({"fusion_node": {"ros__parameters": values}}))
    wanted = expected(replace(Parameters(), values))
    assert [each.stamp_ns for each in wanted] == STAMPS_NS

    fused = workspace.use(
        "fuse",
        s1_type=s1_type,
        s2_type=s2_type,
        s1=pairs(S1),
        s2=pairs(S2),
        parameters=str(parameters),
        bag=str(live),
    )
    assert fused["types"] == [s2_type]
    assert samples(fused["samples"]) == wanted

    with open_bag(live) as bag:
        assert bag.problems == []
        assert bag.topics["/s1"].msgtype == s1_type
        assert bag.topics["/estimate"].msgtype == s2_type
        assert bag.topics["/estimate"].message_count == len(wanted)
    replay = ("fuzzy-fusion", "replay", live, "--params", parameters, "--output")
    workspace.run(*replay, tmp_path / "with", cwd=tmp_path)
    run(*replay, tmp_path / "without", cwd=tmp_path)
    for again in ("with", "without"):
        assert differences(live, tmp_path / again, TOPICS) == []


@pytest.mark.parametrize("input_type", [HEADED, pytest.param(BARE, marks=OTHER_WAY)])
def test_its_types_are_taken_by_sensor_subscriber(workspace: Workspace, input_type: str) -> None:
    assert samples(workspace.use("subscribe", input_type=input_type, samples=pairs(S1))) == S1
