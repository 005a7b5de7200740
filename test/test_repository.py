# SPDX-License-Identifier: Apache-2.0
"""What a visitor of the repository meets: workflows, forms, the action; they name what is there."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
import yaml
from bag.recorded import swing, write_scalars

from fuzzy_fusion_ros.cli import COMMANDS, score

ROOT = Path(__file__).resolve().parents[1]
YAML = (
    ".github/workflows/ci.yml",
    ".github/ISSUE_TEMPLATE/bug.yml",
    ".github/ISSUE_TEMPLATE/config.yml",
    ".github/ISSUE_TEMPLATE/question.yml",
    ".pre-commit-config.yaml",
    "CITATION.cff",
    "action.yml",
)


def document(name: str) -> Any:
    return yaml.safe_load((ROOT / name).read_text(encoding="utf-8"))


@pytest.mark.parametrize("name", YAML)
def test_it_names_files_targets_and_verbs_that_are_there(name: str) -> None:
    assert document(name)
    text = (ROOT / name).read_text()
    targets = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(), re.MULTILINE))
    assert set(re.findall(r"make (?:-C \S+ )?([a-z-]+)\b(?! python3)", text)) <= targets
    assert set(re.findall(r"fuzzy-fusion ([a-z]\w+)", text)) <= set(COMMANDS)
    for path in re.findall(
        r"(?:run: |&& )(?:src/fuzzy_fusion_ros/)?((?:\.ci/\w+|install\.sh))", text
    ):
        assert os.access(ROOT / path, os.X_OK)


def test_ci_tests_the_distributions_that_there_are_wheels_of() -> None:
    jobs = document(".github/workflows/ci.yml")["jobs"]
    matrix = jobs["test"]["strategy"]["matrix"]
    assert {*matrix["distro"], *(each["distro"] for each in matrix["include"])} == {
        "jazzy",
        "kilted",
    }
    assert matrix["python"] == ["3.10", "3.11", "3.12", "3.13"]
    assert "3.14" in jobs["offline"]["strategy"]["matrix"]["python"]


def test_pre_commit_checks_at_the_version_of_make_test() -> None:
    (repository,) = document(".pre-commit-config.yaml")["repos"]
    assert f'"ruff=={repository["rev"].removeprefix("v")}"' in (ROOT / "setup.py").read_text()


def test_a_bug_comes_with_a_check_and_a_bag() -> None:
    fields = {each["id"]: each for each in document(".github/ISSUE_TEMPLATE/bug.yml")["body"]}
    assert "fuzzy-fusion check BAG" in fields["check"]["attributes"]["description"]
    assert fields["bag"]["validations"] == {"required": True}


def test_the_paper_is_cited() -> None:
    paper = document("CITATION.cff")["preferred-citation"]
    assert paper["title"] in (ROOT / "README.md").read_text()


def test_all_name_the_version_of_the_package() -> None:
    (version,) = re.findall("<version>(.*)</version>", (ROOT / "package.xml").read_text())
    citation = document("CITATION.cff")
    fields = {
        each["id"]: each
        for each in document(".github/ISSUE_TEMPLATE/bug.yml")["body"]
        if "id" in each
    }
    assert f'version="{version}"' in (ROOT / "setup.py").read_text()
    assert f'release = "{version}"' in (ROOT / "docs" / "conf.py").read_text()
    assert citation["version"] == version
    assert f"fuzzy_fusion_ros {version}," in fields["versions"]["attributes"]["placeholder"]
    assert f"\n{version} ({citation['date-released']})\n" in (ROOT / "CHANGELOG.rst").read_text()


def run_action(folder: Path, **inputs: str) -> subprocess.CompletedProcess[str]:
    """Run the last step of the action as GitHub does, with its defaults."""
    action = document("action.yml")
    values = {name: each.get("default", "") for name, each in action["inputs"].items()} | inputs
    step = action["runs"]["steps"][-1]
    variables = {
        name: values[text.removeprefix("${{ inputs.").removesuffix(" }}")]
        for name, text in step["env"].items()
    }
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    return subprocess.run(
        ["bash", "--noprofile", "--norc", "-eo", "pipefail", "-c", step["run"]],
        cwd=folder,
        env={**os.environ, **variables, "PATH": path},
        capture_output=True,
        text=True,
        check=False,
    )


def test_the_action_fails_where_a_filter_has_become_worse(tmp_path: Path) -> None:
    bag = write_scalars(tmp_path / "bag", swing(estimate=False))
    baseline = tmp_path / "before.json"
    params = ROOT / "bags" / "nominal.yaml"
    assert score.main([str(bag), "--params", str(params), "--json", str(baseline)]) == 0
    given = {"bag": str(bag), "params": str(params), "baseline": str(baseline)}
    done = run_action(tmp_path, **given)
    assert done.returncode == 0, done.stderr
    before = json.loads(baseline.read_text())
    before["estimators"]["estimate"]["rmse"] *= 0.9
    baseline.write_text(json.dumps(before))
    done = run_action(tmp_path, **given)
    assert done.returncode == 1, done.stderr
    assert run_action(tmp_path, **given, tolerance="20").returncode == 0


def test_the_containers_build_with_what_is_there() -> None:
    container = json.loads((ROOT / ".devcontainer" / "devcontainer.json").read_text())
    dockerfile = (ROOT / "Dockerfile").read_text()
    assert "\nFROM ros:jazzy\n" in dockerfile
    assert container["image"] == "ros:jazzy"
    assert "src/fuzzy_fusion_ros/install.sh" in dockerfile
    assert container["postCreateCommand"].endswith(" && make venv")


SOURCES = (".py", ".sh", ".yaml", ".yml", ".xml", ".html", ".urdf", ".rviz", ".cfg", ".cmake")
WITH_SOURCES = ("fuzzy_fusion_ros", "test", "docs", "examples", "launch", "config", ".github")


def test_every_source_file_names_its_licence() -> None:
    named = "SPDX-License-Identifier: Apache-2.0"
    below = [path for folder in WITH_SOURCES for path in (ROOT / folder).rglob("*")]
    sources = [path for path in [*ROOT.glob("*"), *below] if path.suffix in SOURCES]
    scripts = [path for path in (ROOT / ".ci").iterdir() if path.is_file()]
    sources += [*scripts, ROOT / "Makefile", ROOT / "Dockerfile"]
    heads = {path: path.read_text().splitlines()[:2] for path in sources}
    assert [path for path, head in heads.items() if named not in "".join(head)] == []
