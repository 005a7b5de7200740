# SPDX-License-Identifier: Apache-2.0
"""Claims and targets as a table and as JSON."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any

from fuzzy_fusion_ros.paper.checks import CheckedClaim
from fuzzy_fusion_ros.paper.sweep import Outcome
from fuzzy_fusion_ros.text.table import text_table

WORDS = {True: "holds", False: "FAILS", None: "–"}


def claims_table(checked: Sequence[CheckedClaim], of: str, holds: str) -> str:
    """Return a table of claims: each with its verdict, then how its value is defined.

    Args:
        checked: The claims; without any, the table is empty.
        of: What they are, for the header.
        holds: The word for a claim that holds.
    """
    if not checked:
        return ""
    words = {**WORDS, True: holds}
    rows = [("fig.", "", "value", "95 % interval", of)]
    for each in checked:
        low, high = each.interval
        interval = f"{low:.3g} … {high:.3g}"
        rows.append(
            (str(each.figure), words[each.holds], f"{each.value:.3g}", interval, each.claim)
        )
        measured = "; ".join(text for text in (each.measure, each.where) if text)
        rows.append(("", "", "", "", f"({measured})"))
    return text_table(rows, align="lllll")


def as_document(
    outcomes: Iterable[Outcome], claims: Iterable[CheckedClaim], targets: Iterable[CheckedClaim]
) -> dict[str, Any]:
    """Return everything as a document for JSON; NaN and infinities are ``None``."""
    return {
        "runs": [_run(outcome) for outcome in outcomes],
        "claims": [_claim(claim) for claim in claims],
        "targets": [_claim(target) for target in targets],
    }


def _run(outcome: Outcome) -> dict[str, Any]:
    return {
        "method": outcome.method,
        **outcome.point._asdict(),
        "seed": outcome.seed,
        "iae": outcome.iae,
        "itae": outcome.itae,
        "rmse": outcome.rmse,
        "fell": outcome.fell,
    }


def _claim(check: CheckedClaim) -> dict[str, Any]:
    return {
        **check._asdict(),
        "value": _number(check.value),
        "interval": [_number(end) for end in check.interval],
    }


def _number(value: float) -> float | None:
    return value if math.isfinite(value) else None
