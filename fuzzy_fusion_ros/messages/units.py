# SPDX-License-Identifier: Apache-2.0
"""The units of numbers in standard messages, as their definitions state them."""

from __future__ import annotations

import math
import re

from fuzzy_fusion_ros.messages.codec import ScalarCodec
from fuzzy_fusion_ros.messages.field_path import FieldPath, call_in
from fuzzy_fusion_ros.messages.functions import FUNCTIONS, PLAIN
from fuzzy_fusion_ros.messages.type_names import normalise_type_name
from fuzzy_fusion_ros.parameters.errors import MessageError
from fuzzy_fusion_ros.parameters.fusion import Parameters

# What a path ends in, in any message: sub-messages have the same names in all standard types.
_BY_PATH = {
    r"linear_acceleration\.[xyz]": "m/s^2",
    r"angular_velocity\.[xyz]": "rad/s",
    r"twist\.linear\.[xyz]": "m/s",
    r"twist\.angular\.[xyz]": "rad/s",
    r"accel\.linear\.[xyz]": "m/s^2",
    r"accel\.angular\.[xyz]": "rad/s^2",
    r"pose\.position\.[xyz]": "m",
    r"wrench\.force\.[xyz]": "N",
    r"wrench\.torque\.[xyz]": "N m",
    r"magnetic_field\.[xyz]": "T",
    r"fluid_pressure": "Pa",
    r"illuminance": "lx",
}

_BY_TYPE = {
    "geometry_msgs/msg/Accel": {r"linear\.[xyz]": "m/s^2", r"angular\.[xyz]": "rad/s^2"},
    "geometry_msgs/msg/Pose": {r"position\.[xyz]": "m"},
    "geometry_msgs/msg/Twist": {r"linear\.[xyz]": "m/s", r"angular\.[xyz]": "rad/s"},
    "geometry_msgs/msg/Wrench": {r"force\.[xyz]": "N", r"torque\.[xyz]": "N m"},
    "sensor_msgs/msg/BatteryState": {r"voltage": "V", r"current": "A", r"temperature": "degC"},
    "sensor_msgs/msg/NavSatFix": {r"latitude|longitude": "deg", r"altitude": "m"},
    "sensor_msgs/msg/Range": {r"range|min_range|max_range": "m", r"field_of_view": "rad"},
    "sensor_msgs/msg/Temperature": {r"temperature": "degC"},
}

RATES = {"m": "m/s", "m/s": "m/s^2", "rad": "rad/s", "rad/s": "rad/s^2"}
"""The unit of the rate of a quantity, by the unit of the quantity."""

INTEGRALS = {rate: unit for unit, rate in RATES.items()}
"""The unit of the integral of a quantity, by the unit of the quantity."""


def unit_of_s1(unit: str, is_rate: bool) -> str:
    """Return the unit that S1 must have, by that of S2; ``""`` where that is not known."""
    return RATES.get(unit, f"{unit}/s") if is_rate and unit else unit


def unit_of(type_name: str, field: str) -> str:
    """Return the unit that a standard message gives its number.

    Args:
        type_name: ``package/msg/Type``.
        field: The path of the number.

    Returns:
        ``""`` where the definition states none, as for plain scalars and for points, which are
        used for anything.
    """
    call = call_in(field)
    if call is not None:
        forms = FUNCTIONS.get(call.name, (PLAIN,))
        return forms[0].unit or unit_of(type_name, f"{call.arguments[0]}.x")
    rules = _BY_TYPE.get(normalise_type_name(type_name), _BY_PATH)
    path = re.sub(r"\[\d+\]", "", FieldPath(field).text)
    for pattern, unit in rules.items():
        if re.search(rf"(?:^|\.)(?:{pattern})$", path):
            return unit
    return ""


TURNS = {"rad": 2.0 * math.pi, "rad/s": 2.0 * math.pi, "deg": 360.0}
"""A full turn, by the unit of an angle or of its rate."""

LARGEST_CORRECTION = 2.0
"""A scale within this factor of 1 or -1 corrects a sensor; another one changes its unit."""


def unit_read(codec: ScalarCodec) -> str:
    """Return the unit of what a codec reads: the type's, or ``""`` where a scale changes it."""
    if not 1.0 / LARGEST_CORRECTION < abs(codec.scale) < LARGEST_CORRECTION:
        return ""
    return unit_of(codec.type_name, codec.field.text)


def signal_unit(s1: ScalarCodec, s2: ScalarCodec, parameters: Parameters) -> str:
    """Return the unit of the signal, which is that of S2, and of S1 or of its integral.

    Args:
        s1: Reads S1.
        s2: Reads S2.
        parameters: ``signal.unit``, if it is not empty, is the unit; ``s1.kind`` says whether S1
            is a rate.

    Returns:
        ``""`` where neither type states one.

    Raises:
        MessageError: The types state units that do not go together, and none is given.
    """
    given, is_rate = parameters.signal.unit, parameters.s1.kind == "rate"
    if given:
        return given
    unit1, unit2 = unit_read(s1), unit_read(s2)
    expected = unit_of_s1(unit2, is_rate)
    if unit1 and expected and unit1 != expected:
        described = [
            f"{name} is in {unit} ({each.field.text} of {each.type_name})"
            for name, unit, each in zip(("s1", "s2"), (unit1, unit2), (s1, s2), strict=True)
        ]
        if unit1 == unit_of_s1(unit2, not is_rate):
            advice = f"set s1.kind: {'value' if is_rate else 'rate'}"
        elif is_rate:
            advice = f"s1.kind: rate needs S1 in {expected}, or signal.unit set"
        else:
            advice = "choose fields in the same unit, or set signal.unit if they measure the same"
        raise MessageError(f"{', '.join(described)}: {advice}")
    return unit2 or (INTEGRALS.get(unit1, "") if is_rate else unit1)
