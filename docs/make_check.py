# SPDX-License-Identifier: Apache-2.0
"""Makes the table of docs/check.md: how often a check names what is wrong, over made-up sensors.

PYTHONPATH=test python docs/make_check.py
"""

from __future__ import annotations

from pathlib import Path

from checking.rates import EXPECTED, rates

PAGE = Path(__file__).resolve().parent / "check.md"
BEGIN, END = "<!-- made by make_check.py: -->\n", "<!-- end -->\n"
SEEDS = range(20)


def main() -> None:
    """Write the table into the page."""
    before, _, rest = PAGE.read_text(encoding="utf-8").partition(BEGIN)
    table = "\n".join(_table()) + "\n"
    PAGE.write_text(before + BEGIN + table + END + rest.partition(END)[2], encoding="utf-8")


def _table() -> list[str]:
    lines = ["| fault | pairs | named | missed | misled |", "|---|---|---|---|---|"]
    for fault in EXPECTED:
        found = rates(fault, SEEDS)
        shares = [_percent(each, found.pairs) for each in (found.named, found.misled)]
        silent = _percent(found.silent, found.pairs) if EXPECTED[fault] else "—"
        lines.append(f"| {fault} | {found.pairs} | {shares[0]} | {silent} | {shares[1]} |")
    return lines


def _percent(count: int, of: int) -> str:
    return f"{100.0 * count / of:.0f} %" if count else "0"


if __name__ == "__main__":
    main()
