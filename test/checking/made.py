# SPDX-License-Identifier: Apache-2.0
"""Sensors for tests, sample by sample."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fuzzy_fusion_ros.checking.check import Check, check
from fuzzy_fusion_ros.checking.finding import Finding
from fuzzy_fusion_ros.checking.samples import SensorSamples, TwoSensors

START_NS = 1_700_000_000_000_000_000


def sensor(
    name: str,
    stamps_s: Sequence[float] | np.ndarray[tuple[int], np.dtype[np.float64]],
    values: Sequence[float] | np.ndarray[tuple[int], np.dtype[np.float64]],
    *,
    arrivals_s: Sequence[float] | np.ndarray[tuple[int], np.dtype[np.float64]] | None = None,
    topic: str | None = None,
    field: str = "data",
    unit: str = "",
    is_stamped: bool = True,
) -> SensorSamples:
    """Return samples whose stamps are seconds from the start; they arrive at once, or when told."""
    arrivals = stamps_s if arrivals_s is None else arrivals_s
    return SensorSamples(
        name=name,
        topic=f"/{name}" if topic is None else topic,
        field=field,
        unit=unit,
        is_stamped=is_stamped,
        stamps_ns=at(stamps_s),
        overflows=np.zeros(len(stamps_s), np.bool_),
        arrivals_ns=at(arrivals),
        values=np.array(values, np.float64),
    )


def at(
    seconds: Sequence[float] | np.ndarray[tuple[int], np.dtype[np.float64]],
) -> np.ndarray[tuple[int], np.dtype[np.int64]]:
    """Return seconds from the start as stamps, nanoseconds."""
    return START_NS + np.rint(np.array(seconds) * 1e9).astype(np.int64)


def both(s1: SensorSamples, s2: SensorSamples) -> Check:
    """Check two sensors."""
    return check(TwoSensors(s1, s2, START_NS))


def only(findings: Sequence[Finding], about: str) -> Finding:
    """Return the one finding about something."""
    (found,) = (each for each in findings if each.about == about)
    return found
