# SPDX-License-Identifier: Apache-2.0
"""The pages say what the code does."""

from __future__ import annotations

import re
import runpy
from pathlib import Path

import pytest

from fuzzy_fusion_ros.messages import InstalledTypes, ScalarCodec
from fuzzy_fusion_ros.messages.outputs import EXPLANATION, EstimateMessages, EstimateSource
from fuzzy_fusion_ros.messages.units import signal_unit
from fuzzy_fusion_ros.nodes.modes import Mode
from fuzzy_fusion_ros.online.guard import Drop
from fuzzy_fusion_ros.parameters.file import dumps, parameters_from
from fuzzy_fusion_ros.parameters.fusion import Parameters

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").glob("*.md"))]
NODE_PAGE = (ROOT / "docs" / "fusion_node.md").read_text()


def test_the_parameter_table_is_that_of_the_code() -> None:
    made = runpy.run_path(str(ROOT / "docs" / "make_parameters.py"))
    assert made["filled"](NODE_PAGE) == NODE_PAGE


def test_the_parameter_file_of_defaults_is_that_of_the_code() -> None:
    made = runpy.run_path(str(ROOT / "test" / "nodes" / "write_config.py"))
    assert made["PATH"].read_text() == dumps(Parameters(), made["COMMENTS"])


@pytest.mark.parametrize("drop", [each.value for each in Drop])
def test_every_reason_to_drop_is_documented(drop: str) -> None:
    assert f"`dropped: {drop}`" in NODE_PAGE


@pytest.mark.parametrize("mode", list(Mode))
def test_every_mode_is_documented(mode: Mode) -> None:
    assert f"| `{mode.name}` | `{mode.name}: {mode.value}` |" in NODE_PAGE


def said_when_something_comes_in() -> list[str]:
    """What the page says that the node says, in parts between what differs each time."""
    table = NODE_PAGE.partition("## What comes in")[2].partition("\n\nOne old stamp")[0]
    last_columns = [line.split(" | ")[-1] for line in table.splitlines() if line.startswith("| ")]
    texts = re.findall(r"`([^`]+)`", " ".join(last_columns))
    return [part for text in texts for part in text.split("…") if part.strip(" s:")]


@pytest.mark.parametrize("text", said_when_something_comes_in())
def test_what_the_page_says_is_said_is_in_the_code(text: str) -> None:
    sources = [each.read_text() for each in sorted((ROOT / "fuzzy_fusion_ros").rglob("*.py"))]
    code = re.sub(r'"\s*\n\s*f?"', "", "\n".join(sources))  # of texts in several lines
    assert text.removeprefix("dropped: ") in code


@pytest.mark.parametrize("topic", list(EXPLANATION))
def test_every_explanation_topic_is_documented(topic: str) -> None:
    assert f"`~/{topic}`" in NODE_PAGE


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_within_the_repository_lead_somewhere(page: Path) -> None:
    for target in re.findall(r"\]\(([^)#:]+)\)", page.read_text()):
        assert (page.parent / target).exists(), target


SENSORS = ROOT / "docs" / "sensors.md"
SNIPPETS = re.findall(r"```yaml\n(.*?)```", SENSORS.read_text(), re.DOTALL)


@pytest.mark.parametrize("snippet", SNIPPETS, ids=range(len(SNIPPETS)))
def test_a_node_could_start_with_each_parameter_file_on_the_page(
    snippet: str, tmp_path: Path
) -> None:
    path = tmp_path / "params.yaml"
    path.write_text(snippet)
    types, sources = InstalledTypes(), {}
    for name, parameters in parameters_from(path).by_channel().items():
        s1, s2 = (
            ScalarCodec(types, each.type, each.field, each.scale, each.offset)
            for each in (parameters.s1, parameters.s2)
        )
        assert signal_unit(s1, s2, parameters) in {"rad", "m/s", "m", "degC", ""}
        sources[name] = EstimateSource(parameters.estimate, s2)
    assert EstimateMessages(types, sources).codecs.keys() == sources.keys()


def test_the_page_on_sensors_names_every_preset() -> None:
    presets = {path.name for path in (ROOT / "config" / "presets").glob("*.yaml")}
    assert presets == set(re.findall(r"`(\w+\.yaml)`", SENSORS.read_text()))
