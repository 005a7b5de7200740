"""Files that a job writes."""

from __future__ import annotations

from pathlib import Path

import pytest

from fuzzy_fusion_ros.jobs.outputs import OutputError, one_for_each, require_no_input


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


@pytest.mark.parametrize("target", ["bag", "bag/page.html", "sub/../bag/page.html", "p.yaml"])
def test_what_is_read_is_not_written_over(
    target: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(OutputError, match="is an input: name another file to write to"):
        require_no_input([None, "-", target], [tmp_path / "bag", None, "p.yaml"])


def test_a_file_beside_an_input_can_be_written() -> None:
    require_no_input([None, "-", "bag.html", "bags/page.html"], ["bag", "bag.mcap"])
