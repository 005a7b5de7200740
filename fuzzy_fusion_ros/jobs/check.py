# SPDX-License-Identifier: Apache-2.0
"""Checks the sensors of a bag, and finds which of its numbers move together."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

from fuzzy_fusion_ros.bag import open_bag
from fuzzy_fusion_ros.checking import report
from fuzzy_fusion_ros.checking.check import Check
from fuzzy_fusion_ros.checking.presets import Advice
from fuzzy_fusion_ros.checking.survey import Together
from fuzzy_fusion_ros.jobs.parameter_file import Source, fusion_parameters
from fuzzy_fusion_ros.jobs.progress import SILENT, Progress
from fuzzy_fusion_ros.jobs.shared import presets
from fuzzy_fusion_ros.offline.check import check_bag, survey_bag
from fuzzy_fusion_ros.offline.topics import Topics


class CheckResult(NamedTuple):
    """What was found in a bag.

    Attributes:
        check: Its two sensors and the problems found; None if no topics were named and it has no
            default topics.
        together: Its numbers that move together, most certain first; None if not searched.
        advice: Presets that suit them.
        notes: Parts of the bag that could not be read, one line each.
        bag: The path of the bag.
    """

    check: Check | None
    together: tuple[Together, ...] | None
    advice: tuple[Advice, ...]
    notes: tuple[str, ...]
    bag: str

    @property
    def is_fine(self) -> bool:
        """Whether no problem was found with the two sensors."""
        return self.check is None or self.check.is_fine

    def report(self) -> str:
        """Return it as text for a terminal."""
        parts = [] if self.check is None else [report.check_text(self.check)]
        parts += [] if self.together is None else [report.survey_text(self.together)]
        parts += [report.advice_text(self.advice, self.bag, presets())] if self.advice else []
        return "\n\n".join(parts)

    def as_json(self) -> dict[str, Any]:
        """Return what ``check --json`` writes; what was not searched is null."""
        return {
            "check": None if self.check is None else report.check_json(self.check),
            "together": None if self.together is None else report.survey_json(self.together),
            "presets": [report.advice_json(each) for each in self.advice],
        }


def check(
    bag: str | Path,
    *,
    parameters: Source = None,
    topics: Topics | None = None,
    start: float | None = None,
    end: float | None = None,
    search: bool = True,
    progress: Progress = SILENT,
) -> CheckResult:
    """Check the two sensors of a bag: clocks, rates, values, and how they are related.

    Args:
        bag: A rosbag2 directory or an ``.mcap`` file.
        parameters: Of the fusion, or a YAML file with them, for the fields of the sensors; the
            defaults unless given.
        topics: Where the sensors are. Unless given, the bag is searched for numbers that move
            together, and ``/s1`` and ``/s2`` are checked if it has them.
        start: Where to start, seconds from the first message of the bag.
        end: Where to end, seconds from the first message of the bag.
        search: Whether to search a bag that has ``/s1`` and ``/s2``, too.
        progress: Shows progress.

    Raises:
        FusionError: The bag or the parameters cannot be used.
    """
    given = topics or Topics()
    base = fusion_parameters(parameters).channel(given.channel)
    with open_bag(bag) as reader:
        checked = None
        wanted = given.found_in(reader)
        if topics is not None or {wanted.s1, wanted.s2} <= reader.topics.keys():
            reading = progress.reading(f"reading {bag}")
            checked = check_bag(reader, wanted, base, start, end, reading)
        if topics is not None or (checked is not None and not search):
            return CheckResult(checked, None, (), tuple(reader.problems), str(bag))
        searching = progress.reading(f"searching {bag}", reader.message_count)
        found = survey_bag(reader, wanted, start, end, searching)
        return CheckResult(
            checked,
            tuple(found.together),
            tuple(found.advice),
            tuple(reader.problems),
            str(bag),
        )
