# SPDX-License-Identifier: Apache-2.0
"""The findings of a check, each with its evidence and remedy."""

from __future__ import annotations

import enum
import math
from typing import Any, NamedTuple


class Level(enum.IntEnum):
    """How bad a finding is; the values are those of ``DiagnosticStatus``."""

    INFO = 0
    WARNING = 1
    ERROR = 2


class Finding(NamedTuple):
    """A finding of a check.

    Attributes:
        level: ERROR if the fusion cannot work with it, WARNING if it degrades the fusion, INFO if
            both sensors may be in order.
        about: A short name of the problem, the same in every recording: ``clock offset``.
        text: The observation, a clause without a full stop.
        evidence: The numbers that support it, by name: ``{"correlation": -0.98}``.
        remedy: The fix: a line of a parameter file, an option, or words; empty if there is none.
    """

    level: Level
    about: str
    text: str
    evidence: dict[str, float]
    remedy: str = ""

    def __str__(self) -> str:
        """Return observation, evidence and remedy on one line."""
        evidence = ", ".join(f"{name} {value:.3g}" for name, value in self.evidence.items())
        text = f"{self.text} ({evidence})" if evidence else self.text
        return f"{text}; fix: {self.remedy}" if self.remedy else text

    def as_json(self) -> dict[str, Any]:
        """Return the finding as ``check --json`` writes it."""
        return {
            "level": self.level.name.lower(),
            "about": self.about,
            "text": self.text,
            "evidence": {
                name: value if math.isfinite(value) else None
                for name, value in self.evidence.items()
            },
            "remedy": self.remedy or None,
        }
