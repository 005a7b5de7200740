# SPDX-License-Identifier: Apache-2.0
"""Files that are written: checked before the work, and never those that are read."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from fuzzy_fusion_ros.jobs.outputs import one_for_each, require_writable
from fuzzy_fusion_ros.parameters.writing import OutputError


@pytest.fixture
def bag(tmp_path: Path) -> Path:
    """A directory with two files, as good as a bag here."""
    path = tmp_path / "bag"
    path.mkdir()
    (path / "metadata.yaml").write_text("metadata")
    (path / "bag_0.mcap").write_text("messages")
    return path


def test_nothing_is_left_behind(tmp_path: Path, bag: Path) -> None:
    dangling = tmp_path / "dangling"
    dangling.symlink_to("nowhere")
    require_writable(tmp_path / "new.json", bag / "new.json", dangling, None, "-", inputs=[bag])
    assert sorted(os.listdir(tmp_path)) == ["bag", "dangling"]
    assert sorted(os.listdir(bag)) == ["bag_0.mcap", "metadata.yaml"]


def test_what_is_there_stays_as_it_is(tmp_path: Path) -> None:
    there = tmp_path / "there.json"
    there.write_text("before")
    require_writable(there)
    assert there.read_text() == "before"


def test_devices_and_pipes_are_not_opened(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")  # to open it would wait for a reader
    require_writable(tmp_path / "pipe", "/dev/null", "/dev/null", inputs=["/dev/null"])


@pytest.mark.parametrize("name", ["itself", "hard", "soft", "through"])
@pytest.mark.parametrize("given", ["bag", "bag/bag_0.mcap"])
def test_inputs_are_not_written_over(tmp_path: Path, bag: Path, name: str, given: str) -> None:
    source = bag / "bag_0.mcap"
    os.link(source, tmp_path / "hard")
    (tmp_path / "soft").symlink_to(source)
    (tmp_path / "link").symlink_to(bag)
    target = {"itself": source, "through": tmp_path / "link/../bag/bag_0.mcap"}
    with pytest.raises(OutputError, match=f"is read from .*{given}': choose another file"):
        require_writable(target.get(name, tmp_path / name), inputs=[tmp_path / given])
    assert source.read_text() == "messages"


def test_inputs_may_be_missing_or_no_files(tmp_path: Path) -> None:
    require_writable(tmp_path / "a", inputs=[None, 3.0, tmp_path / "none", "a\0b", "x" * 5000])


def test_one_file_is_not_written_twice(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match="is already written as"):
        require_writable(tmp_path / "a", tmp_path / "b" / ".." / "a")


@pytest.mark.parametrize("target", ["", "/proc/none", "/proc/none/a"])
def test_what_cannot_be_written_is_refused(tmp_path: Path, target: str) -> None:
    with pytest.raises(OutputError, match="cannot be written"):
        require_writable(target or tmp_path)


def test_one_recording_has_the_file_as_given_and_several_have_one_each() -> None:
    assert one_for_each("out/p.png", ["a/one"]) == [Path("out/p.png")]
    assert one_for_each("out/p.png", ["a/one", "b/two.mcap"]) == [
        Path("out/p_one.png"),
        Path("out/p_two.png"),
    ]
    assert one_for_each("out/p.png", ["a/bag", "b/bag"]) == [
        Path("out/p_1_bag.png"),
        Path("out/p_2_bag.png"),
    ]
