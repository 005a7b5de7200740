# SPDX-License-Identifier: Apache-2.0
"""Which of S1, S2 and the truth is wrong: the one that differs from the other two."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from typing import NamedTuple

from fuzzy_fusion_ros.checking import pair
from fuzzy_fusion_ros.checking.check import Check
from fuzzy_fusion_ros.checking.finding import Finding, Level
from fuzzy_fusion_ros.checking.relation import Kind

RESPECTS = ("rate", "sign", "scale", "unrelated", "changed")
"""Findings of a check that two differ, but not which of them is wrong."""

CERTAIN = 0.9
"""From this correlation on, sensors show a motion that a truth cannot lack."""

TRUTH = "the truth"

ANOTHER = "choose another topic or field for"

CONVERT = f"give the truth the sign and unit of s1, or {ANOTHER} it"

REMEDIES = {
    "rate": f"{ANOTHER} the truth",
    "sign": CONVERT,
    "scale": CONVERT,
    "unrelated": f"{ANOTHER} the truth",
}
"""What to do about a truth that differs."""


class Compared(NamedTuple):
    """Two of S1, S2 and the truth, compared.

    Attributes:
        first: Name of the one that the check took for S1.
        second: Name of the one that it took for S2.
        found: The check.
        expected: What the parameters say that they are to each other.
        only_units: As in :func:`.pair.judge_relation`.
    """

    first: str
    second: str
    found: Check
    expected: Kind
    only_units: bool

    @property
    def differences(self) -> list[Finding]:
        """What the check has found in these respects, under their names."""
        return self._named(
            each
            for each in self.found.findings
            if each.level > Level.INFO and each.about in RESPECTS
        )

    def differences_of(self, name: str, scale: float) -> list[Finding]:
        """Return them as those of one from the other, as far as they can be put so.

        Args:
            name: The one.
            scale: What its scale is set to; a fix multiplies it.
        """
        if name == self.first:
            return self.differences
        turned = self._replace(first=self.second, second=self.first)
        relation = self.found.relation
        if relation is None:  # true either way, but for how many times one reads the other
            both = zip(self.differences, turned.differences, strict=True)
            return [one if " reads " in one.text else other for one, other in both]
        if self.expected is not Kind.VALUE:
            return self.differences
        found, _ = pair.judge_relation(
            [relation.turned], Kind.VALUE, scale, only_units=self.only_units
        )
        return turned._named(found)

    @property
    def weak(self) -> float | None:
        """The correlation if it is too weak to say what they are to each other."""
        return next(
            (
                each.evidence["correlation"]
                for each in self.found.findings
                if each.about == "motion" and each.evidence
            ),
            None,
        )

    def agree_in(self, respect: str) -> bool | None:
        """Return whether both agree; None if the check cannot tell."""
        abouts = {each.about for each in self.found.findings}
        relation = self.found.relation
        if any(each.about == respect for each in self.differences):
            return False
        if respect == "unrelated" and abouts & {"ambiguous", "changed"}:
            return True
        if respect in {"unrelated", "changed"}:
            return True if relation is not None else None
        if relation is None or "ambiguous" in abouts or not pair.is_credible(relation):
            return None
        if respect == "rate":
            return True
        if relation.kind is not self.expected:
            return None
        if respect == "sign":
            return relation.sign > 0
        factor, _ = pair.factor_of(relation, only_units=self.only_units)
        if factor == 1.0:
            return True
        return False if relation.sign < 0 else None  # where the sign is wrong, that says it all

    def _named(self, findings: Iterable[Finding]) -> list[Finding]:
        names = {"s1": self.first, "s2": self.second}
        return [
            each._replace(
                text=re.sub(r"\bs[12]\b", lambda found: names[found[0]], each.text),
                remedy=each.remedy.replace("s1.", f"{self.first}."),
            )
            for each in findings
        ]


class Three(NamedTuple):
    """S1, S2 and the truth, compared.

    Attributes:
        sensors: S1 with S2.
        s1_truth: S1 with the truth.
        truth_s2: The truth with S2.
    """

    sensors: Compared
    s1_truth: Compared
    truth_s2: Compared

    def wrong_in(self, respect: str) -> str:
        """Return the one that differs from the other two; ``""`` if that is not known."""
        for name in ("s1", "s2", TRUTH):
            own = [each.agree_in(respect) for each in self if name in each[:2]]
            (others,) = (each.agree_in(respect) for each in self if name not in each[:2])
            differs = own.count(False) == 2 or (False in own and others)
            if differs and True not in own and others is not False:
                return name
        return ""

    def findings(self, s2_scale: float = 1.0) -> tuple[list[Finding], list[Finding]]:
        """Return what is wrong with the sensors, and what with the truth.

        Args:
            s2_scale: What ``s2.scale`` is; a fix multiplies it.
        """
        wrong = {respect: self.wrong_in(respect) for respect in RESPECTS}
        explained = {"unrelated"} if any(wrong.values()) else set[str]()
        sensors = [
            each
            for each in self.sensors.differences
            if not wrong[each.about] and each.about not in explained
        ]
        for name in ("s1", "s2"):
            sensors += self._differences_of(name, wrong, s2_scale)
        truth = self._differences_of(TRUTH, wrong)
        truth += [
            each
            for each in self.s1_truth.differences
            if not wrong[each.about] and self.sensors.agree_in(each.about) is None
        ]
        truth += [] if truth else self._no_motion()
        return sensors, [
            each._replace(remedy=REMEDIES.get(each.about, each.remedy)) for each in truth
        ]

    def _no_motion(self) -> list[Finding]:
        """Return whether the truth shows nothing of a motion that both sensors show clearly."""
        relation, weak = self.sensors.found.relation, [self.s1_truth.weak, self.truth_s2.weak]
        if relation is None or relation.correlation < CERTAIN or None in weak:
            return []
        text = "s1 and s2 agree, but the truth shows nothing of their motion"
        evidence = {"correlation": max(each for each in weak if each is not None)}
        return [Finding(Level.WARNING, "unrelated", text, evidence)]

    def _differences_of(
        self, name: str, wrong: Mapping[str, str], scale: float = 1.0
    ) -> list[Finding]:
        """Return in which respects one is wrong, by its difference from one that is right."""
        pairs = self.truth_s2, self.sensors, self.s1_truth
        (others,) = (each for each in pairs if name not in each[:2])
        for compared in pairs:
            if name in compared[:2] and not set(wrong.values()) >= set(compared[:2]):
                found = compared.differences_of(name, scale)
                found = [each for each in found if wrong[each.about] == name]
                if found:
                    break
        else:
            return []
        if not all(others.agree_in(each.about) for each in found):
            return found
        agree = f"{others.first} and {others.second} agree, but "
        return [each._replace(text=agree + each.text) for each in found]
