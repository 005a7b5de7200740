# SPDX-License-Identifier: Apache-2.0
"""The check of sensors whose samples keep coming: of the most recent ones, in bounded memory."""

from __future__ import annotations

from array import array

import numpy as np

from fuzzy_fusion_ros.checking.check import Check, check
from fuzzy_fusion_ros.checking.finding import Finding, Level
from fuzzy_fusion_ros.checking.samples import SensorSamples, two_sensors
from fuzzy_fusion_ros.messages import ScalarCodec
from fuzzy_fusion_ros.messages.units import unit_read
from fuzzy_fusion_ros.parameters.fusion import Parameters

SAMPLES = 8192
"""Samples of each sensor that are kept."""

POINTS = 2048
"""Points to compare motion on: a check takes 7 ms for 10 s at 100 Hz, 0.2 s for 8 s at 1 kHz."""

WORTH_REPEATING = frozenset(
    {
        "bursts",
        "changed",
        "copy",
        "element",
        "exchanged",
        "outliers",
        "overflow",
        "period",
        "publishers",
        "rate",
        "same topic",
        "saturated",
        "scale",
        "sign",
        "spikes",
        "stuck",
        "two clocks",
        "unrelated",
        "wrap",
    }
)
"""What node, replay, score and tune say; clocks, drops and silences they watch by themselves."""


class Stream:
    """The most recent samples of one sensor, as they came."""

    def __init__(self, name: str, topic: str, codec: ScalarCodec) -> None:
        """Start without samples.

        Args:
            name: ``s1`` or ``s2``.
            topic: Its topic.
            codec: Reads its messages.
        """
        self._name = name
        self._topic = topic
        self._codec = codec
        self._stamps_ns = array("q", bytes(8 * SAMPLES))  # all memory at once: a flood adds none
        self._arrivals_ns = array("q", bytes(8 * SAMPLES))
        self._values = array("d", bytes(8 * SAMPLES))
        self._taken = 0

    def add(self, stamp_ns: int, arrival_ns: int, value: float) -> None:
        """Take a sample, whatever it is."""
        at = self._taken % SAMPLES
        self._stamps_ns[at] = stamp_ns
        self._arrivals_ns[at] = arrival_ns
        self._values[at] = value
        self._taken += 1

    def restart(self) -> None:
        """Forget all samples: the clock of the arrivals has jumped."""
        self._taken = 0

    def samples(self) -> SensorSamples:
        """Return a copy of the samples."""
        kept = min(self._taken, SAMPLES)
        oldest_first = (np.arange(kept) + self._taken - kept) % SAMPLES
        return SensorSamples(
            name=self._name,
            topic=self._topic,
            field=self._codec.field.text,
            unit=unit_read(self._codec),
            is_stamped=self._codec.is_stamped,
            stamps_ns=np.array(self._stamps_ns)[oldest_first],
            overflows=np.zeros(kept, np.bool_),
            arrivals_ns=np.array(self._arrivals_ns)[oldest_first],
            values=np.array(self._values)[oldest_first],
            scale=self._codec.scale,
        )


def check_recent(s1: SensorSamples, s2: SensorSamples, parameters: Parameters) -> Check:
    """Check two sensors over the time of which there are samples of both.

    Args:
        s1: The samples of S1.
        s2: Those of S2.
        parameters: Say whether the signal wraps, and whether S1 is a rate.
    """
    both = [s1, s2]
    firsts = [int(each.arrivals_ns[0]) for each in both if each.arrivals_ns.size]
    start_ns = max(firsts, default=0)
    kept = [each.kept(each.arrivals_ns >= start_ns) for each in both]
    return check(two_sensors(kept[0], kept[1], start_ns, parameters), POINTS)


def warnings(found: Check) -> list[Finding]:
    """Return what a check has found that no other part of a program says."""
    return [
        each for each in found.findings if each.level > Level.INFO and each.about in WORTH_REPEATING
    ]
