# SPDX-License-Identifier: Apache-2.0
"""Fuses two arrays, sample by sample as a node would."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fuzzy_fusion_ros.batch.arrays import Reals, Stamps
from fuzzy_fusion_ros.core.estimator import MODE_NAMES
from fuzzy_fusion_ros.core.numerics import SECOND_NS
from fuzzy_fusion_ros.core.sample import Sample
from fuzzy_fusion_ros.jobs.parameter_file import Source, fusion_parameters
from fuzzy_fusion_ros.online.fusion import Fusion
from fuzzy_fusion_ros.online.ticks import Ticks
from fuzzy_fusion_ros.online.verdict import Fused
from fuzzy_fusion_ros.parameters.errors import FusionError


class FusedArrays(NamedTuple):
    """Estimates, shape (n,) each.

    Attributes:
        time_s: The times of the samples that they are for, seconds.
        value: The estimates, unit of the signal.
        weight: The weight of S1, 0 to 1.
        drift: The drift added to compensate for S2's lag, its magnitude, unit of the signal.
        mode: ``FUSED``, ``S1_ONLY`` or ``S2_ONLY``.
    """

    time_s: Reals
    value: Reals
    weight: Reals
    drift: Reals
    mode: NDArray[np.str_]


def fuse(
    s1_time_s: ArrayLike,
    s1: ArrayLike,
    s2_time_s: ArrayLike,
    s2: ArrayLike,
    *,
    parameters: Source = None,
) -> FusedArrays:
    """Fuse two arrays into the estimates that a node would publish.

    Samples are processed in the order of their times, S2 first where two are equal. As in a node,
    values that are not finite are dropped.

    >>> from fuzzy_fusion_ros import fuse
    >>> found = fuse([0.0, 0.1, 0.2], [1.1, 0.9, 1.1], [0.0], [1.0])
    >>> found.time_s
    array([0. , 0.1, 0.2])
    >>> bool(abs(found.value - 1.0).max() < 0.01)
    True

    Args:
        s1_time_s: Times of S1, increasing, shape (n,), seconds from any origin.
        s1: Samples of S1, shape (n,).
        s2_time_s: Times of S2, increasing, shape (m,), seconds from the same origin.
        s2: Samples of S2, shape (m,).
        parameters: Of the fusion, or the YAML file with them; the defaults unless given.

    Raises:
        FusionError: Shapes do not match, times do not increase, or the parameters cannot be used.
    """
    given = fusion_parameters(parameters).channel("")
    fast, slow = _sensor("S1", s1_time_s, s1), _sensor("S2", s2_time_s, s2)
    time_s = np.concatenate([slow.time_s, fast.time_s])
    order = np.argsort(time_s, kind="stable")
    time_s = time_s[order]
    stamps_ns = _stamps(time_s)
    values = np.concatenate([slow.values, fast.values])[order]
    is_s1 = (order >= slow.values.size).tolist()
    fusion, timer = Fusion(given), Ticks(given)

    def fused() -> Iterator[Fused]:
        for stamp_ns, value, fast in zip(stamps_ns.tolist(), values.tolist(), is_s1, strict=True):
            if timer.due(stamp_ns) is not None:
                yield from fusion.on_tick().estimates
            on_sample = fusion.on_s1 if fast else fusion.on_s2
            yield from on_sample(Sample(stamp_ns, value)).estimates

    found = list(fused())
    estimates = [each.estimate for each in found]
    return FusedArrays(
        time_s[np.searchsorted(stamps_ns, [each.stamp_ns for each in found])],
        np.array([each.value for each in estimates]),
        np.array([each.aggregate.weight for each in estimates]),
        np.array([each.aggregate.drift for each in estimates]),
        np.array([MODE_NAMES[each.mode] for each in estimates], np.str_),
    )


class _Sensor(NamedTuple):
    """Samples of one sensor."""

    time_s: Reals
    values: Reals


def _sensor(name: str, time_s: ArrayLike, values: ArrayLike) -> _Sensor:
    sensor = _Sensor(np.asarray(time_s, np.float64), np.asarray(values, np.float64))
    if sensor.time_s.ndim != 1 or sensor.time_s.shape != sensor.values.shape:
        raise FusionError(
            f"{name}: got times of shape {sensor.time_s.shape} and samples of shape "
            f"{sensor.values.shape}, expected one shape (n,)"
        )
    if not (np.isfinite(sensor.time_s).all() and (np.diff(sensor.time_s) > 0.0).all()):
        raise FusionError(f"{name}: got times that are not finite or not increasing: sort them")
    return sensor


def _stamps(time_s: Reals) -> Stamps:
    """Return times as stamps; the first is 1 s, because a stamp of 0 means *no stamp*."""
    elapsed = time_s - time_s[:1]
    return SECOND_NS + np.round(elapsed * SECOND_NS).astype(np.int64)
