"""Progress bars."""

from __future__ import annotations

import io
import sys

import pytest

from fuzzy_fusion_ros.cli.progress import bar, progress


class Terminal(io.StringIO):
    """A stderr that somebody looks at."""

    def isatty(self) -> bool:
        return True


def test_nothing_is_said_where_nobody_looks(capsys: pytest.CaptureFixture[str]) -> None:
    assert list(progress(range(3), "counting")) == [0, 1, 2]
    with bar("counting", 3) as shown:
        shown.update(3)
    assert capsys.readouterr() == ("", "")


def test_a_terminal_sees_how_far_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    assert list(progress(iter("abc"), "counting", 3, " letters")) == ["a", "b", "c"]
    assert "counting" in terminal.getvalue()
    assert "0.00/3.00" in terminal.getvalue()


def test_a_bar_is_moved_by_hand(monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    with bar("working", 2) as shown:
        shown.update()
    assert "working" in terminal.getvalue()
