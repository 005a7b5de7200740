# SPDX-License-Identifier: Apache-2.0
"""Every preset in config/presets does its job, from a bag and as a node."""

from __future__ import annotations

import functools
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from presets.sensors import CHANNELS, RIGS, topics_of, write_rig

from fuzzy_fusion_ros.bag import open_bag
from fuzzy_fusion_ros.baselines import BaselineParameters
from fuzzy_fusion_ros.batch.series import Method
from fuzzy_fusion_ros.checking.relation import Kind
from fuzzy_fusion_ros.nodes.fusion_node import FusionNode
from fuzzy_fusion_ros.offline.check import check_bag, survey_bag
from fuzzy_fusion_ros.offline.replay import replay
from fuzzy_fusion_ros.offline.topics import Topics
from fuzzy_fusion_ros.parameters.file import parameters_from
from fuzzy_fusion_ros.scoring import score as scoring
from fuzzy_fusion_ros.scoring.score import score_bag
from fuzzy_fusion_ros.testing import Harness

PRESETS = Path(__file__).resolve().parents[2] / "config" / "presets"
BETTER = {
    "heading": 0.7,
    "tilt": 0.3,
    "speed": 0.7,
    "altitude": 0.7,
    "temperature": 0.3,
    "three_axes": 0.7,
}
"""Share of the better sensor's error that the estimate may have."""
PROMISED = 1.2
"""Share of the error in the table of the documentation that the estimate may have."""
WITHIN_1SD = (0.43, 0.9)
"""Of independent normal errors 0.68 are; S2's lag leaves the temperature's at 0.45."""
OTHERS = pytest.mark.slow("as the preset for speed")
PAGE = PRESETS.parents[1] / "docs" / "fusion_node.md"


def documented(name: str) -> float:
    """The RMSE of the estimate in the table of the documentation."""
    (row,) = re.findall(rf"^\| `{name}\.yaml` .* \| (\S+) \S+ \|$", PAGE.read_text(), re.MULTILINE)
    return float(row)


def test_every_preset_has_a_rig() -> None:
    assert {path.stem for path in PRESETS.glob("*.yaml")} == set(RIGS) == set(BETTER)


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Path]:
    """What writes the bag of a rig, once."""
    folder = tmp_path_factory.mktemp("recorded")
    return functools.cache(lambda name: write_rig(folder / name, RIGS[name]))


@pytest.fixture(scope="module")
def replayed(
    recorded: Callable[[str], Path], tmp_path_factory: pytest.TempPathFactory
) -> Callable[[str], Path]:
    """What replays it with its preset, all channels at once."""
    folder = tmp_path_factory.mktemp("replayed")

    @functools.cache
    def replayed(name: str) -> Path:
        topics = Topics(RIGS[name].s1.topic, RIGS[name].s2.topic)
        with open_bag(recorded(name)) as bag:
            replay(bag, folder / name, topics, parameters_from(PRESETS / f"{name}.yaml"))
        return folder / name

    return replayed


@pytest.fixture
def sensors_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let score run no filters besides the estimate."""
    whole = scoring.methods

    def methods(parameters: BaselineParameters) -> dict[str, Method]:
        return {name: each for name, each in whole(parameters).items() if name in ("s1", "s2")}

    monkeypatch.setattr(scoring, "methods", methods)


@pytest.mark.usefixtures("sensors_alone")
@pytest.mark.parametrize(("name", "channel"), CHANNELS)
def test_it_is_better_than_either_sensor(
    recorded: Callable[[str], Path], name: str, channel: str
) -> None:
    rig, parameters = RIGS[name], parameters_from(PRESETS / f"{name}.yaml")
    topics, own = topics_of(rig, channel), parameters.channel(channel)
    found = score_bag(recorded(name), topics, own)
    assert found.notes == ()
    errors = {each: found.scores(each)["rmse"] for each in ("estimate", "s1", "s2")}
    assert errors["estimate"] < BETTER[name] * min(errors["s1"], errors["s2"]), errors
    assert np.ptp(found.time_s) > 110.0
    assert errors["estimate"] < PROMISED * documented(name)
    low, high = WITHIN_1SD
    assert low < found.scores("estimate")["within_1sd"] < high


@pytest.mark.usefixtures("sensors_alone")
@pytest.mark.parametrize(
    ("name", "channel"),
    [each if each[0] == "speed" else pytest.param(*each, marks=OTHERS) for each in CHANNELS],
)
def test_its_replay_scores_the_same(
    recorded: Callable[[str], Path], replayed: Callable[[str], Path], name: str, channel: str
) -> None:
    """But for what the type of the estimate rounds."""
    own = parameters_from(PRESETS / f"{name}.yaml").channel(channel)
    topics = topics_of(RIGS[name], channel)
    errors = [
        score_bag(bag(name), topics, own).scores("estimate")["rmse"] for bag in (recorded, replayed)
    ]
    assert errors[1] == pytest.approx(errors[0], rel=1e-5)


@pytest.mark.parametrize(("name", "channel"), CHANNELS)
def test_check_finds_nothing_wrong(
    recorded: Callable[[str], Path], name: str, channel: str
) -> None:
    own = parameters_from(PRESETS / f"{name}.yaml").channel(channel)
    with open_bag(recorded(name)) as bag:
        assert check_bag(bag, topics_of(RIGS[name], channel), own).is_fine


@pytest.mark.parametrize(("name", "channel"), CHANNELS)
def test_check_without_topics_finds_its_fields(
    recorded: Callable[[str], Path], name: str, channel: str
) -> None:
    rig = RIGS[name]
    parameters = parameters_from(PRESETS / f"{name}.yaml").channel(channel)
    with open_bag(recorded(name)) as bag:
        together, advice = survey_bag(bag, Topics())
    found = {(each.s1.topic, each.s1.path, each.s2.path): each for each in together}
    pair = found[rig.s1.topic, parameters.s1.field, parameters.s2.field]
    assert (pair.relation.kind is Kind.S1_RATE) == (parameters.s1.kind == "rate")
    if not channel:
        assert name in {each.job.preset for each in advice}


@pytest.mark.parametrize("name", RIGS)
def test_a_node_takes_it(harness: Harness, name: str) -> None:
    path = PRESETS / f"{name}.yaml"
    node = harness.add(FusionNode, parameter_file=path)
    assert node.parameters == parameters_from(path)
