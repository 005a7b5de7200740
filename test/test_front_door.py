# SPDX-License-Identifier: Apache-2.0
"""What the package offers to Python programs."""

from __future__ import annotations

import ast
import runpy
import subprocess
import sys
from pathlib import Path

import pytest

import fuzzy_fusion_ros

ROOT = Path(__file__).parents[1]
DOOR = ROOT / "fuzzy_fusion_ros" / "__init__.py"


def python(program: str) -> str:
    """Run a program in a fresh interpreter; return what it prints."""
    done = subprocess.run(
        [sys.executable, "-c", program],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, ""), done.stderr
    return done.stdout


def test_importing_it_imports_nothing_else() -> None:
    loaded = python(
        """
import sys
before = set(sys.modules)
import fuzzy_fusion_ros
print(*(name.partition(".")[0] for name in set(sys.modules) - before))
"""
    ).split()
    assert set(loaded) & {"numpy", "yaml", "rclpy", "matplotlib", "numba", "scipy"} == set()
    assert loaded.count("fuzzy_fusion_ros") == 1


def test_every_name_is_there_without_ros() -> None:
    said = python(
        """
import sys
sys.modules["rclpy"] = None
import fuzzy_fusion_ros
print(*(name for name in dir(fuzzy_fusion_ros) if getattr(fuzzy_fusion_ros, name) is None))
print(*dir(fuzzy_fusion_ros))
"""
    ).splitlines()
    assert said[0] == ""
    assert said[1].split() == sorted(fuzzy_fusion_ros.__all__)


def test_type_checkers_see_the_same_names_at_the_same_places() -> None:
    checked = next(
        node for node in ast.parse(DOOR.read_text()).body if isinstance(node, ast.If)
    ).body
    seen = {
        alias.name: (node.module or "").removeprefix("fuzzy_fusion_ros.")
        for node in checked
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }
    assert seen == fuzzy_fusion_ros._HOMES
    assert sorted(seen) == sorted(fuzzy_fusion_ros.__all__)


def test_another_name_is_an_error_as_with_any_module() -> None:
    with pytest.raises(AttributeError, match="module 'fuzzy_fusion_ros' has no attribute 'fusion'"):
        fuzzy_fusion_ros.fusion  # noqa: B018


def test_the_page_is_that_of_the_docstrings() -> None:
    made = runpy.run_path(str(ROOT / "docs" / "make_api.py"))
    page = (ROOT / "docs" / "api.md").read_text(encoding="utf-8")
    assert made["page"]() == page, "run: make docs"
    for name in fuzzy_fusion_ros.__all__:
        assert f"\n### `{name}`\n" in page
