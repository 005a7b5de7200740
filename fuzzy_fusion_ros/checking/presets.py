# SPDX-License-Identifier: Apache-2.0
"""Which preset in config/ suits numbers that move together."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from fuzzy_fusion_ros.checking.pair import conversion_of
from fuzzy_fusion_ros.checking.relation import Kind, Relation
from fuzzy_fusion_ros.checking.survey import Field, Together


class Job(NamedTuple):
    """What a preset is for.

    Attributes:
        preset: Name of its file in ``config/presets``.
        kind: What S1 and S2 are to each other.
        unit: Unit of S2.
        s1: Pattern of the field of S1.
        s2: Pattern of the field of S2.
        sets_kind: Whether the preset sets ``s1.kind``, or need not; else the advice does.
        has_axis: Whether S1 is negated if its axis points the other way; a thermometer has none.
    """

    preset: str
    kind: Kind
    unit: str
    s1: str
    s2: str
    sets_kind: bool = True
    has_axis: bool = True


GYRO = r"angular(_velocity)?\.([xy])$"
"""What a rate of roll or pitch ends in."""

TILT = Job("tilt", Kind.S1_RATE, "rad", GYRO, r"^(roll|pitch)\(")
JOBS = (
    Job("heading", Kind.S1_RATE, "rad", r"angular(_velocity)?\.z$", r"^(atan2|yaw)\("),
    TILT,
    Job("speed", Kind.VALUE, "m/s", r"linear\.x$", r"linear(\.x|\))$"),
    Job("speed", Kind.S1_RATE, "m/s", r"linear_acceleration\.x$", r"linear(\.x|\))$", False),
    Job("altitude", Kind.VALUE, "m", r"^altitude\(", r"range$|altitude$|\.z$"),
    Job("temperature", Kind.VALUE, "degC", r"temperature$", r"temperature$", has_axis=False),
)
"""The presets of one channel; their fields and kinds are those in the files."""

FASTEST = 100.0, 0.99
"""No gyro measures as much in rad/s, 16 turns a second; most end at 35. If not
this share of its values is below, they are in degrees."""

ANGLES = {"x": "roll", "y": "pitch"}
"""The function of an acceleration that gives the angle about each axis of a gyro."""


class Advice(NamedTuple):
    """A preset and the sensors to use it with.

    Attributes:
        job: The preset.
        s1: The fast sensor.
        s2: The accurate one.
        relation: How they move together; None if only their types speak for it, as for the gyro
            and the accelerometer of one message: in violent motion they share no common angle.
        scale: What ``s1.scale`` must be.
    """

    job: Job
    s1: Field
    s2: Field
    relation: Relation | None
    scale: float

    @property
    def additions(self) -> list[str]:
        """Parameters to set besides the preset."""
        kind = [] if self.job.sets_kind else ["s1.kind: rate"]
        return [*kind, f"s1.scale: {self.scale:.7g}"] if self.scale != 1.0 else kind


def advise(fields: Iterable[Field], found: Sequence[Together]) -> list[Advice]:
    """Return the presets that suit a recording, the surest pair of sensors for each.

    Args:
        fields: All numbers of the recording that change.
        found: Those that move together, most certain first.
    """
    best: dict[Job, Advice] = {}
    for each in found:
        for job in JOBS:
            if job not in best and _suits(job, each):
                scale = conversion_of(each.relation)
                best[job] = Advice(job, each.s1, each.s2, each.relation, scale)
    tilted = {each.s1.topic for each in best.values() if each.job is TILT}
    others = [each for each in fields if each.topic not in tilted]
    scales = {each.s1.topic: abs(each.scale) for each in best.values() if _is_gyro(each.s1)}
    return [*best.values(), *_tilts(others, scales)]


def _is_gyro(field: Field) -> bool:
    return field.unit == "rad/s"


def _suits(job: Job, found: Together) -> bool:
    s1, s2, relation = found
    if relation.kind is not job.kind or s2.unit not in {job.unit, ""}:
        return False
    turned = relation.sign < 0 and not job.has_axis
    return not turned and bool(re.search(job.s1, s1.path) and re.search(job.s2, s2.path))


def _tilts(fields: Sequence[Field], scales: Mapping[str, float]) -> list[Advice]:
    """Return a gyro and an accelerometer of one message, one pair for each topic.

    Args:
        fields: All numbers that change.
        scales: The scales of gyros whose motion shows them, by topic.
    """
    largest: dict[str, float] = {}
    for each in filter(_is_gyro, fields):
        size = float(np.quantile(np.abs(each.motion.values), FASTEST[1]))
        largest[each.topic] = max(size, largest.get(each.topic, 0.0))
    by_name = {(each.topic, each.path): each for each in fields}
    found: dict[str, Advice] = {}
    for s1 in fields:
        gyro = re.search(GYRO, s1.path) if _is_gyro(s1) else None
        if gyro is None:
            continue
        angle = f"{ANGLES[gyro[2]]}({s1.path[: gyro.start()]}linear_acceleration)"
        if (s1.topic, angle) in by_name:
            by_size = math.radians(1.0) if largest[s1.topic] > FASTEST[0] else 1.0
            scale = scales.get(s1.topic, by_size)
            found.setdefault(s1.topic, Advice(TILT, s1, by_name[s1.topic, angle], None, scale))
    return list(found.values())
