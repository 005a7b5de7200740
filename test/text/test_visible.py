# SPDX-License-Identifier: Apache-2.0
"""Text from outside is shown, not obeyed."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fuzzy_fusion_ros.text.table import text_table
from fuzzy_fusion_ros.text.visible import visible


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("", ""),
        ("plain text, été, 漢字, µ", "plain text, été, 漢字, µ"),
        ("\x1b[31mred", r"\x1b[31mred"),
        ("\x9b31m", r"\x9b31m"),
        ("a\nb\r\tc\0", r"a\nb\r\tc\x00"),
        ("\u202eright to left\u2066", r"\u202eright to left\u2066"),
        ("\u2028\x85", r"\u2028\x85"),
        ("not utf-8: \udcff", r"not utf-8: \udcff"),
        ("\U000e0001tag", r"\U000e0001tag"),
    ],
)
def test_what_a_terminal_would_obey_is_spelt_out(text: str, shown: str) -> None:
    assert visible(text) == shown


@given(st.text())
def test_any_text_can_be_printed(text: str) -> None:
    assert visible(text).isprintable()
    visible(text).encode()


def test_tables_are_safe_too() -> None:
    table = text_table([["name", "value"], ["\x1b[2J", "1"]])
    assert table.splitlines() == ["name     value", r"\x1b[2J      1"]
