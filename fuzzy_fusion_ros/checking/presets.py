# SPDX-License-Identifier: Apache-2.0
"""Which preset in config/ suits numbers that move together."""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple

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
        is_set: Whether the preset says of what kind S1 is; where not, ``s1.kind: rate`` is added.
    """

    preset: str
    kind: Kind
    unit: str
    s1: str
    s2: str
    is_set: bool = True


JOBS = (
    Job("heading", Kind.S1_RATE, "rad", r"angular(_velocity)?\.z$", r"^(atan2|yaw)\("),
    Job("tilt", Kind.S1_RATE, "rad", r"angular(_velocity)?\.[xy]$", r"^(roll|pitch)\("),
    Job("speed", Kind.VALUE, "m/s", r"linear\.x$", r"linear(\.x|\))$"),
    Job("speed", Kind.S1_RATE, "m/s", r"linear_acceleration\.x$", r"linear(\.x|\))$", False),
    Job("altitude", Kind.VALUE, "m", r"^altitude\(", r"range$|altitude$|\.z$"),
    Job("temperature", Kind.VALUE, "degC", r"temperature$", r"temperature$"),
)

AXES = {"x": "roll", "y": "pitch"}
"""The function of an acceleration that gives the angle about each axis of a gyro."""


class Advice(NamedTuple):
    """A preset and the sensors to use it with.

    Attributes:
        job: The preset.
        s1: The fast sensor.
        s2: The accurate one.
        relation: How they move together; None if only their types speak for it, as for the gyro
            and the accelerometer of one message: in violent motion they share no common angle.
    """

    job: Job
    s1: Field
    s2: Field
    relation: Relation | None

    @property
    def options(self) -> str:
        """The options of ``check``, ``tune``, ``score`` and ``replay`` that choose the sensors."""
        topics = ["--s1", self.s1.topic, "--s2", self.s2.topic]
        fields = ["--field", f"s1={self.s1.path}", "--field", f"s2={self.s2.path}"]
        return shlex.join([*topics, *fields])

    @property
    def additions(self) -> list[str]:
        """Parameters to set besides the preset."""
        kind = [] if self.job.is_set else ["s1.kind: rate"]
        is_negated = self.relation is not None and self.relation.sign < 0
        return [*kind, "s1.scale: -1.0"] if is_negated else kind


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
                best[job] = Advice(job, each.s1, each.s2, each.relation)
    used = {each.s1.topic for each in best.values()}
    return [*best.values(), *_tilts([each for each in fields if each.topic not in used])]


def _suits(job: Job, found: Together) -> bool:
    s1, s2, relation = found
    fits = re.search(job.s1, s1.path) and re.search(job.s2, s2.path)
    return bool(fits) and relation.kind is job.kind and s2.unit in {job.unit, ""}


def _tilts(fields: Sequence[Field]) -> Iterator[Advice]:
    """Yield a gyro and an accelerometer of one message, one pair for each topic."""
    (tilt,) = (each for each in JOBS if each.preset == "tilt")
    by_topic: dict[str, Advice] = {}
    for s1 in fields:
        for s2 in fields if s1.unit == "rad/s" and re.search(tilt.s1, s1.path) else ():
            if s2.topic == s1.topic and s2.path == f"{AXES[s1.path[-1]]}(linear_acceleration)":
                by_topic.setdefault(s1.topic, Advice(tilt, s1, s2, None))
    yield from by_topic.values()
