# SPDX-License-Identifier: Apache-2.0
"""Where files that come with the package are, in its sources and installed."""

from __future__ import annotations

import sys
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


@pytest.mark.parametrize("place", ["ros", "python"])
def test_installed_presets_are_where_ros_or_pip_puts_them(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, place: str
) -> None:
    monkeypatch.setattr(shared, "__file__", str(tmp_path / "a" / "b" / "shared.py"))
    monkeypatch.setenv("AMENT_PREFIX_PATH", f"{tmp_path / 'other'}:{tmp_path / 'ros'}")
    monkeypatch.setattr(sys, "prefix", str(tmp_path / "python"))
    installed = tmp_path / place / "share" / "fuzzy_fusion_ros" / "config" / "presets"
    installed.mkdir(parents=True)
    assert presets() == installed
