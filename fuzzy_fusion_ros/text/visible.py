# SPDX-License-Identifier: Apache-2.0
"""Untrusted text, such as names of topics and files, made safe to show."""

from __future__ import annotations


def visible(text: str) -> str:
    """Return a text on one line in which nothing is left that a terminal would obey.

    Control characters, line breaks, marks that reverse the direction of writing, and bytes that
    are no UTF-8 become escapes such as ``\\x1b``.
    """
    if text.isprintable():
        return text
    return "".join(each if each.isprintable() else _escaped(each) for each in text)


def _escaped(character: str) -> str:
    return character.encode("unicode_escape").decode("ascii")
