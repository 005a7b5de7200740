# SPDX-License-Identifier: Apache-2.0
"""Tables in plain text."""

from __future__ import annotations

import math

from hypothesis import given
from hypothesis import strategies as st

from fuzzy_fusion_ros.text.table import number_column, text_table


def test_text_is_left_numbers_are_right() -> None:
    rows = [["", "rmse", "lag"], ["", "m", "s"], ["estimate", "0.125", "0"], ["s2", "12", "0.8"]]
    assert text_table(rows, headers=2).splitlines() == [
        "           rmse  lag",
        "              m    s",
        "estimate  0.125    0",
        "s2           12  0.8",
    ]


def test_columns_that_do_not_fit_come_below_beside_the_first() -> None:
    rows = [["", "one", "two", "three"], ["name", "1", "2", "3"]]
    assert text_table(rows, width=14).splitlines() == [
        "      one  two",
        "name    1    2",
        "",
        "      three",
        "name      3",
    ]


def test_a_last_column_of_text_is_wrapped() -> None:
    rows = [["fig.", "claim"], ["18", "fusion has the least IAE"], ["19", ""]]
    assert text_table(rows, align="ll", width=20).splitlines() == [
        "fig.  claim",
        "18    fusion has the",
        "      least IAE",
        "19",
    ]


tables = st.integers(1, 6).flatmap(
    lambda n: st.lists(st.lists(st.text("abc", max_size=9), min_size=n, max_size=n), min_size=1)
)


@given(tables)
def test_no_cell_is_lost_and_no_line_too_wide(rows: list[list[str]]) -> None:
    lines = text_table(rows, width=30).splitlines()
    assert all(len(line) <= 30 for line in lines)
    found = sorted(" ".join(lines).split())
    repeated = found.copy()
    for cell in (cell for row in rows for cell in row if cell):
        repeated.remove(cell)
    assert set(repeated) <= {row[0] for row in rows}


def test_the_smallest_magnitude_is_marked() -> None:
    column = number_column("bias", "rad", [2.0, -1.0, 1.0, math.nan, 0.0012345e3], digits=3)
    assert column == ["bias ", "rad ", "2 ", "-1*", "1*", "nan ", "1.23 "]
    assert number_column("", "", [math.nan])[2:] == ["nan "]
