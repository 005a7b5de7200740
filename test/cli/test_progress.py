# SPDX-License-Identifier: Apache-2.0
"""Progress bars."""

from __future__ import annotations

import contextlib
import io
import sys

import pytest

from fuzzy_fusion_ros.cli import progress as progress_bars
from fuzzy_fusion_ros.cli.progress import BARS
from fuzzy_fusion_ros.jobs.progress import SILENT, Progress


class Terminal(io.StringIO):
    """A stderr that somebody looks at."""

    def isatty(self) -> bool:
        return True


@pytest.mark.parametrize("progress", [BARS, SILENT])
def test_nothing_is_shown_where_stderr_is_no_terminal(
    progress: Progress, capsys: pytest.CaptureFixture[str]
) -> None:
    assert list(progress.over(range(3), "counting")) == [0, 1, 2]
    with progress.counted("counting") as advance:
        advance(1, 3)
    assert capsys.readouterr() == ("", "")


def test_a_terminal_shows_how_far_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    assert list(BARS.over(iter("abc"), "counting", 3, " letters")) == ["a", "b", "c"]
    assert "counting" in terminal.getvalue()
    assert "0.00/3.00" in terminal.getvalue()


def test_an_item_may_count_for_many(monkeypatch: pytest.MonkeyPatch) -> None:
    steps: list[int] = []

    class Bar:
        update = staticmethod(steps.append)

    monkeypatch.setattr(progress_bars, "_bar", lambda **_: contextlib.nullcontext(Bar))
    assert list(BARS.over(("ab", "c"), "spelling", 3, " letters", len)) == ["ab", "c"]
    assert steps == [2, 1]


def test_a_bar_is_moved_to_what_is_done(monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    with BARS.counted("working") as advance:
        advance(2, 4)
        advance(4, 4)
    assert "working" in terminal.getvalue()
