# SPDX-License-Identifier: Apache-2.0
"""Covariance of the observer's states, and the Kalman filter's two steps on it.

The states are S1's bias ``c``, its slope ``b``, and ``m1``, ``m2``: the bias after the
lag of S2's model, and after a second lag that approximates its delay. Over a time ``D``, with
``a = 1 - exp(-D / lag)`` and ``h = 1 - exp(-D / delay)``::

    c' = c + D b        m1' = (1 - a) m1 + a c        m2' = (1 - h) m2 + h m1'

S2 measures ``m2``. Written out over ten numbers, because it runs in nodes without a compiler and
has to give the same bits with one.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from fuzzy_fusion_ros.core.numerics import clamped

INCONSISTENT = 1.01
"""Rounding never makes the square of a covariance this many times the product of its variances,
unless most digits of these are lost: after a gap of days they are large, then a sample of S2 makes
them small."""


class Covariance(NamedTuple):
    """Upper triangle of the symmetric covariance of (c, b, m1, m2)."""

    cc: float
    cb: float
    c1: float
    c2: float
    bb: float
    b1: float
    b2: float
    m11: float
    m12: float
    m22: float


class Gain(NamedTuple):
    """How much of an innovation each state takes."""

    bias: float
    slope: float
    first: float
    second: float


def of_bias(cc: float, cb: float, bb: float) -> Covariance:
    """Return the covariance where the lags show the bias as it is: ``m1 = m2 = c``."""
    return Covariance(cc=cc, cb=cb, c1=cc, c2=cc, bb=bb, b1=cb, b2=cb, m11=cc, m12=cc, m22=cc)


def propagated(p: Covariance, dt: float, first: float, second: float) -> Covariance:
    """Return ``F P F'`` over a time ``dt``.

    Args:
        p: The covariance.
        dt: Seconds, 0 or more.
        first, second: Gains of the two lags over that time, 0 to 1.
    """
    keep, hold = 1.0 - first, 1.0 - second
    cc, cb = p.cc + dt * p.cb, p.cb + dt * p.bb  # rows of F P
    c1, c2 = p.c1 + dt * p.b1, p.c2 + dt * p.b2
    b1 = first * p.cb + keep * p.b1
    first_c = first * p.cc + keep * p.c1
    first_1 = first * p.c1 + keep * p.m11
    first_2 = first * p.c2 + keep * p.m12
    new_c1 = first * cc + keep * c1
    m11 = first * first_c + keep * first_1
    m12 = second * m11 + hold * first_2
    return Covariance(
        cc=max(cc + dt * cb, 0.0),
        cb=cb,
        c1=new_c1,
        c2=second * new_c1 + hold * c2,
        bb=p.bb,
        b1=b1,
        b2=second * b1 + hold * p.b2,
        m11=max(m11, 0.0),
        m12=m12,
        m22=max(second * m12 + hold * (second * first_2 + hold * p.m22), 0.0),
    )


def raised(p: Covariance, variance: float) -> Covariance:
    """Return the covariance after the bias has jumped by something of this variance."""
    return Covariance(
        cc=p.cc + variance,
        cb=p.cb,
        c1=p.c1 + variance,
        c2=p.c2 + variance,
        bb=p.bb,
        b1=p.b1,
        b2=p.b2,
        m11=p.m11 + variance,
        m12=p.m12 + variance,
        m22=p.m22 + variance,
    )


def gain(p: Covariance, noise: float) -> Gain:
    """Return the Kalman gain of a measurement of ``m2``.

    Args:
        p: The covariance before it.
        noise: Variance of the measurement, more than 0.
    """
    total = p.m22 + noise
    return Gain(p.c2 / total, p.b2 / total, p.m12 / total, p.m22 / total)


def corrected(p: Covariance, k: Gain, noise: float) -> Covariance:
    """Return the covariance after a measurement of ``m2``; diagonals stay 0 or more.

    Args:
        p: The covariance before it.
        k: Its gain.
        noise: Variance of the measurement.
    """
    rest = noise / (p.m22 + noise)  # 1 - K, which loses no digits where K is nearly 1
    cc = max(p.cc - k.bias * p.c2, 0.0)
    bb = max(p.bb - k.slope * p.b2, 0.0)
    m11 = max(p.m11 - k.first * p.m12, 0.0)
    m22 = p.m22 * rest
    return Covariance(
        cc=cc,
        cb=_consistent(p.cb - k.bias * p.b2, cc, bb),
        c1=_consistent(p.c1 - k.bias * p.m12, cc, m11),
        c2=_consistent(p.c2 * rest, cc, m22),
        bb=bb,
        b1=_consistent(p.b1 - k.slope * p.m12, bb, m11),
        b2=_consistent(p.b2 * rest, bb, m22),
        m11=m11,
        m12=_consistent(p.m12 * rest, m11, m22),
        m22=m22,
    )


def _consistent(covariance: float, one: float, other: float) -> float:
    """Return a covariance that is possible between numbers of these variances."""
    if covariance * covariance <= INCONSISTENT * one * other:
        return covariance
    largest = math.sqrt(one * other)
    return clamped(covariance, -largest, largest)
