# SPDX-License-Identifier: Apache-2.0
"""Scalars that are computed from numbers of a message: angles, sizes, altitudes; and back."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from operator import itemgetter
from typing import NamedTuple

from fuzzy_fusion_ros.core.periodic import nearest

TURN = 2.0 * math.pi

Numbers = Sequence[float]


class Function(NamedTuple):
    """From numbers of a message to a scalar and, where it can be inverted, back.

    Attributes:
        members: Of each argument that is a message, its numbers; empty where arguments are numbers.
        arguments: How many there are.
        unit: Unit of the scalar; empty for that of the numbers.
        read: The scalar of the numbers, NaN where there is none.
        write: The numbers that have a scalar and else are as before, in place of the numbers
            before; None if there are none or many.
    """

    members: tuple[str, ...]
    arguments: int
    unit: str
    read: Callable[[Numbers], float]
    write: Callable[[Numbers, float], Numbers] | None


def _rewrite(_: Numbers, value: float) -> Numbers:
    return (value,)


PLAIN = Function((), 1, "", itemgetter(0), _rewrite)
"""A number as it is."""


def scaled(function: Function, scale: float, offset: float) -> Function:
    """Return a function whose scalar is ``scale`` times that of another, plus ``offset``.

    Args:
        function: The other.
        scale: Not 0.
        offset: Unit of the result.
    """
    if scale == 1.0 and offset == 0.0:
        return function
    read, write = function.read, function.write

    def read_scaled(numbers: Numbers) -> float:
        return scale * read(numbers) + offset

    def write_scaled(numbers: Numbers, value: float) -> Numbers:
        return write(numbers, (value - offset) / scale) if write else numbers

    return function._replace(read=read_scaled, write=write_scaled if write else None)


class Angles(NamedTuple):
    """An orientation as turns about z, then the new y, then the new x (ZYX), rad.

    Attributes:
        roll: About x, from -π to π.
        pitch: About y, from -π/2 to π/2.
        yaw: About z, from -π to π.
    """

    roll: float
    pitch: float
    yaw: float


LOCKED = 1e-7
"""Pitch this near to a right angle, rad, is one: roll and yaw turn about the same axis there."""


def angles_of(quaternion: Numbers) -> Angles:
    """Return the angles of a quaternion (x, y, z, w) of any length but 0, else NaN.

    Where pitch is a right angle, roll counts as 0, and yaw holds the whole turn.
    """
    size = math.hypot(*quaternion)
    if not 0.0 < size < math.inf:
        return Angles(math.nan, math.nan, math.nan)
    x, y, z, w = (each / size for each in quaternion)
    up, down = math.hypot(z - x, w + y), math.hypot(z + x, w - y)
    difference, total = math.atan2(z - x, w + y), math.atan2(z + x, w - y)  # half yaw -/+ roll
    if down < LOCKED:
        total = difference
    elif up < LOCKED:
        difference = total
    roll, yaw = (nearest(each, 0.0, TURN) for each in (total - difference, total + difference))
    return Angles(roll, 2.0 * math.atan2(up, down) - 0.5 * math.pi, yaw)


def quaternion_of(angles: Angles) -> tuple[float, float, float, float]:
    """Return the quaternion (x, y, z, w) of length 1 of an orientation."""
    (cr, sr), (cp, sp), (cy, sy) = ((math.cos(0.5 * each), math.sin(0.5 * each)) for each in angles)
    return (
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
        cr * cp * cy + sr * sp * sy,
    )


def _angle(name: str) -> Function:
    place = Angles._fields.index(name)

    def write(quaternion: Numbers, value: float) -> Numbers:
        before = angles_of(quaternion)
        known = before if math.isfinite(before.yaw) else Angles(0.0, 0.0, 0.0)
        return quaternion_of(known._replace(**{name: value}))

    return Function(
        ("x", "y", "z", "w"), 1, "rad", lambda quaternion: angles_of(quaternion)[place], write
    )


def _tilt_of(vector: Numbers) -> tuple[float, float]:
    """Return roll and pitch at which a sensor at rest measures an acceleration, rad."""
    x, y, z = vector
    if not 0.0 < math.hypot(*vector) < math.inf:
        return math.nan, math.nan
    return math.atan2(y, z), math.atan2(-x, math.hypot(y, z))


def _tilted(vector: Numbers, roll: float, pitch: float) -> Numbers:
    size = math.hypot(*vector) or 1.0
    across = size * math.cos(pitch)
    return -size * math.sin(pitch), across * math.sin(roll), across * math.cos(roll)


def _roll_of_vector(vector: Numbers, value: float) -> Numbers:
    return _tilted(vector, value, _known(_tilt_of(vector)[1]))


def _pitch_of_vector(vector: Numbers, value: float) -> Numbers:
    return _tilted(vector, _known(_tilt_of(vector)[0]), value)


def _known(angle: float) -> float:
    """Return an angle, 0 where a message is blank and has none."""
    return angle if math.isfinite(angle) else 0.0


def _direction_of(legs: Numbers) -> float:
    """Return the direction of a vector in the plane, rad; NaN where it has none."""
    return math.atan2(*legs) if 0.0 < math.hypot(*legs) < math.inf else math.nan


def _turned(legs: Numbers, value: float) -> Numbers:
    size = math.hypot(*legs) or 1.0
    return size * math.sin(value), size * math.cos(value)


SEA_LEVEL = 101325.0
"""Pressure at sea level in the ICAO standard atmosphere, Pa."""

SCALE_HEIGHT = 288.15 / 0.0065
"""Temperature at sea level over the lapse rate, m."""

EXPONENT = 8.31432 * 0.0065 / (9.80665 * 0.0289644)
"""Power of the pressure ratio that gives the temperature ratio."""

TROPOPAUSE = 11000.0
"""Altitude at which the temperature stops falling, m."""

TROPOPAUSE_PRESSURE = SEA_LEVEL * math.pow(1.0 - TROPOPAUSE / SCALE_HEIGHT, 1.0 / EXPONENT)
"""Pressure at the tropopause, Pa."""

UPPER_SCALE_HEIGHT = 8.31432 * 216.65 / (9.80665 * 0.0289644)
"""Above the tropopause, up to 20 km, pressure falls by a factor of e per this height, m."""


def altitude_of(pressure: float) -> float:
    """Return the altitude at which the ICAO standard atmosphere has a pressure, m.

    Args:
        pressure: Pa; NaN is returned where it is not above 0.
    """
    if not pressure > 0.0:
        return math.nan
    if pressure < TROPOPAUSE_PRESSURE:
        return TROPOPAUSE + UPPER_SCALE_HEIGHT * math.log(TROPOPAUSE_PRESSURE / pressure)
    return SCALE_HEIGHT * (1.0 - math.pow(pressure / SEA_LEVEL, EXPONENT))


def pressure_of(altitude: float) -> float:
    """Return the pressure of the ICAO standard atmosphere, Pa.

    Args:
        altitude: m.
    """
    if altitude > TROPOPAUSE:
        return TROPOPAUSE_PRESSURE * math.exp((TROPOPAUSE - altitude) / UPPER_SCALE_HEIGHT)
    return SEA_LEVEL * math.pow(max(0.0, 1.0 - altitude / SCALE_HEIGHT), 1.0 / EXPONENT)


_VECTOR = ("x", "y", "z")

FUNCTIONS: Mapping[str, tuple[Function, ...]] = {
    "roll": (
        _angle("roll"),
        Function(_VECTOR, 1, "rad", lambda vector: _tilt_of(vector)[0], _roll_of_vector),
    ),
    "pitch": (
        _angle("pitch"),
        Function(_VECTOR, 1, "rad", lambda vector: _tilt_of(vector)[1], _pitch_of_vector),
    ),
    "yaw": (_angle("yaw"),),
    "norm": (Function(_VECTOR, 1, "", lambda vector: math.hypot(*vector), None),),
    "atan2": (Function((), 2, "rad", _direction_of, _turned),),
    "altitude": (
        Function(
            (),
            1,
            "m",
            lambda pressure: altitude_of(pressure[0]),
            lambda _, value: (pressure_of(value),),
        ),
    ),
}
"""By the names in fields; each with its forms, a quaternion's before a vector's."""
