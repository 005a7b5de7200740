# SPDX-License-Identifier: Apache-2.0
"""Where files that come with the package are, in its sources and installed."""

from __future__ import annotations

import site
import sys
import sysconfig
from pathlib import Path

import pytest

from fuzzy_fusion_ros.jobs import shared
from fuzzy_fusion_ros.jobs.shared import presets

ROOT = Path(__file__).resolve().parents[2]


def test_presets_in_the_sources_are_named_from_the_working_directory(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert presets() == ROOT / "config" / "presets"
    monkeypatch.chdir(ROOT)
    assert presets() == Path("config", "presets")


def test_presets_are_named_in_a_working_directory_that_was_removed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    removed = tmp_path / "removed"
    removed.mkdir()
    monkeypatch.chdir(removed)
    removed.rmdir()
    assert presets() == ROOT / "config" / "presets"


@pytest.fixture
def prefixes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Install the package below ``tmp_path``, without its files."""
    monkeypatch.setattr(shared, "__file__", str(tmp_path / "a" / "b" / "shared.py"))
    monkeypatch.setenv("AMENT_PREFIX_PATH", f"{tmp_path / 'other'}:{tmp_path / 'ros'}")
    monkeypatch.setattr(sys, "prefix", str(tmp_path / "python"))
    monkeypatch.setattr(sysconfig, "get_path", {"data": str(tmp_path / "local")}.__getitem__)
    monkeypatch.setattr(site, "getuserbase", lambda: str(tmp_path / "user"))


@pytest.mark.usefixtures("prefixes")
@pytest.mark.parametrize("place", ["ros", "python", "local", "user"])
def test_installed_presets_are_where_ros_or_pip_puts_them(tmp_path: Path, place: str) -> None:
    installed = tmp_path / place / "share" / "fuzzy_fusion_ros" / "config" / "presets"
    installed.mkdir(parents=True)
    assert presets() == installed


@pytest.mark.usefixtures("prefixes")
def test_presets_that_are_nowhere_have_no_folder() -> None:
    assert presets() / "heading.yaml" == Path("heading.yaml")
