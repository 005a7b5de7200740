# SPDX-License-Identifier: Apache-2.0
"""Scores against those of an earlier run, for a user's own continuous integration."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from fuzzy_fusion_ros.scoring.metrics import REPORTED, ScoreError

LARGEST = 16 << 20
"""Bytes that are read of a file with scores."""


def read_scores(path: str | Path) -> dict[str, Any]:
    """Return what ``score --json`` wrote earlier.

    Raises:
        ScoreError: The file cannot be read, or is no such JSON.
    """
    try:
        with Path(path).open("rb") as file:
            document = json.loads(file.read(LARGEST))
    except OSError as error:
        raise ScoreError(f"baseline {str(path)!r} cannot be read: {error.strerror}") from None
    except (ValueError, RecursionError) as error:
        raise ScoreError(f"baseline {str(path)!r} is not JSON: {error}") from None
    if not isinstance(document, dict):
        raise ScoreError(f"baseline {str(path)!r} is not what score --json writes")
    return document


def regressions(now: Mapping[str, Any], before: Mapping[str, Any], percent: float) -> list[str]:
    """Return what got worse by more than a tolerance, one line each.

    Only the estimate counts: sensors and baselines are what it is compared with. Its bias may
    move by the tolerance taken of the earlier RMSE.

    Args:
        now: A score as JSON holds it.
        before: An earlier one.
        percent: The tolerance, percent.

    Raises:
        ScoreError: The earlier one is no such score.
    """
    return list(_regressions(now, before, percent / 100.0))


def _regressions(
    now: Mapping[str, Any], before: Mapping[str, Any], tolerance: float
) -> Iterator[str]:
    share, earlier_share = _matched(now), _matched(before)
    if share < earlier_share * (1.0 - tolerance):
        yield f"matched: {share:.1%} of the estimates, before {earlier_share:.1%}"
    scale = abs(_metric(before, "rmse"))
    for name in REPORTED:
        new, old = abs(_metric(now, name)), abs(_metric(before, name))
        if new > old + tolerance * (scale if name == "bias" else old):
            change = f"{new / old - 1.0:+.1%}" if old > 0.0 else "from nothing"
            yield f"{name} of the estimate: {new:.6g}, before {old:.6g} ({change})"


def _matched(document: Mapping[str, Any]) -> float:
    try:
        return float(document["matched"]) / float(document["of"])
    except (LookupError, TypeError, ValueError, ZeroDivisionError):
        raise ScoreError("baseline is not a score: it lacks 'matched' and 'of'") from None


def _metric(document: Mapping[str, Any], name: str) -> float:
    try:
        value = float(document["estimators"]["estimate"][name])
    except (LookupError, TypeError, ValueError):
        raise ScoreError(f"baseline is not a score: it lacks the estimate's {name!r}") from None
    if not math.isfinite(value):
        raise ScoreError(f"baseline is not a score: the estimate's {name!r} is {value!r}")
    return value
