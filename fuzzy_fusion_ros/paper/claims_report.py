"""Claims and targets for readers, and for programs."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any

from fuzzy_fusion_ros.paper.checks import CheckedClaim
from fuzzy_fusion_ros.paper.sweep import Outcome

WORDS = {True: "holds", False: "FAILS", None: "–"}


def findings_table(checked: Sequence[CheckedClaim], of: str, holds: str) -> str:
    """Return checked as lines of text, two each: the claim, and what its value is.

    Without checked there is no text at all.

    Args:
        checked: What to show.
        of: What they are, for the header.
        holds: The word for one that does.
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
        rows.append(("", "", "", "", "; ".join(t for t in (each.measure, each.where) if t)))
    widths = [max(len(row[i]) for row in rows) for i in range(4)]
    return "\n".join(
        "  ".join([*(cell.ljust(w) for cell, w in zip(row, widths, strict=False)), row[-1]])
        for row in rows
    )


def as_document(
    outcomes: Iterable[Outcome], claims: Iterable[CheckedClaim], targets: Iterable[CheckedClaim]
) -> dict[str, Any]:
    """Return everything as a document for JSON; what is no number there is ``None``."""
    return {
        "runs": [_run(outcome) for outcome in outcomes],
        "claims": [_finding(claim) for claim in claims],
        "targets": [_finding(target) for target in targets],
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


def _finding(check: CheckedClaim) -> dict[str, Any]:
    return {
        **check._asdict(),
        "value": _number(check.value),
        "interval": [_number(end) for end in check.interval],
    }


def _number(value: float) -> float | None:
    return value if math.isfinite(value) else None
