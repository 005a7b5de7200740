# SPDX-License-Identifier: Apache-2.0
"""Fills the parameter tables of docs/fusion_node.md from their one definition."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import Group, descriptors

PAGE = Path(__file__).with_name("fusion_node.md")
TABLE = re.compile(r"(<!-- parameters -->\n).*?(<!-- end -->)", re.DOTALL)


def rows(kind: type[Group]) -> Iterator[str]:
    """Yield a Markdown table of all parameters of a group."""
    yield "| parameter | default | unit | range | meaning |"
    yield "|---|---|---|---|---|"
    for name, descriptor, default in descriptors(kind):
        shown = f"`{default}`".lower() if isinstance(default, bool) else f"`{default}`"
        shown = "`[]`" if default == () else shown
        when = " (read at start-up)" if descriptor.fixed else ""
        yield (
            f"| `{name}` | {shown if default != '' else 'empty'} | {descriptor.unit} "
            f"| {descriptor.range} | {descriptor.text}{when} |"
        )


def filled(text: str) -> str:
    """Return the page with its table as the code has it."""
    table = "\n".join(rows(Parameters))
    return TABLE.sub(lambda found: f"{found[1]}{table}\n{found[2]}", text)


if __name__ == "__main__":
    PAGE.write_text(filled(PAGE.read_text()))
