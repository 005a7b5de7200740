# SPDX-License-Identifier: Apache-2.0
"""Checks a field path against a message type, before the first message comes."""

from __future__ import annotations

from collections.abc import Iterator

from fuzzy_fusion_ros.messages.field_path import Field, FieldPath, PathPart, call_in
from fuzzy_fusion_ros.messages.functions import FUNCTIONS, PLAIN, Function
from fuzzy_fusion_ros.messages.type_fields import FLOATS, FieldType, TypeDescriptions
from fuzzy_fusion_ros.messages.type_names import normalise_type_name
from fuzzy_fusion_ros.parameters.errors import MessageError

DEFAULT_FIELDS = {
    "geometry_msgs/msg/Point": "x",
    "geometry_msgs/msg/PointStamped": "point.x",
    "geometry_msgs/msg/Vector3": "x",
    "geometry_msgs/msg/Vector3Stamped": "vector.x",
    "sensor_msgs/msg/Range": "range",
}
_MAX_CANDIDATES = 20
_MAX_FUNCTIONS = 8
_MAX_DEPTH = 6
_MOST_FIELDS = 10_000
_TIMES = frozenset({"builtin_interfaces/msg/Time", "std_msgs/msg/Header"})


def resolve_field(types: TypeDescriptions, type_name: str, text: str = "") -> Field:
    """Return the field ``text`` after checking that it leads to numbers in that type.

    Args:
        types: Who describes message types.
        type_name: ``package/msg/Type``.
        text: A path, a function of paths such as ``yaw(orientation)``, or empty for the default
            field of the type: that of ``DEFAULT_FIELDS``, else the only float outside header,
            arrays and variances, or the only integer where there are no floats.

    Raises:
        MessageError: The type is unknown, has no such field, the field is not a number, there is no
            such function or it takes something else, or there is no default; except for the
            first, the error lists the candidates.
    """
    name = normalise_type_name(type_name)
    types.fields(name)  # an unknown type is said first
    text = text or _default_field(types, name)
    call = call_in(text)
    if call is None:
        return Field(text, (_number(types, name, text),), PLAIN)
    forms = FUNCTIONS.get(call.name, ())
    if not forms:
        known = ", ".join(FUNCTIONS)
        raise MessageError(
            f"field {text!r} of {name}: no function {call.name!r}, expected one of {known}"
            f"{_advice(types, name)}"
        )
    expected = forms[0].arguments
    if len(call.arguments) != expected or not all(call.arguments):
        takes = "one path" if expected == 1 else f"{expected} paths"
        raise MessageError(f"field {text!r} of {name}: {call.name} takes {takes}")
    for form in forms:
        paths = _arguments(types, name, form, call.arguments)
        if paths is not None:
            numbers = tuple(_number(types, name, path) for path in paths)
            return Field(text, numbers, form)
    wanted = " or ".join("a quaternion" if len(each.members) == 4 else "a vector" for each in forms)
    raise MessageError(
        f"field {text!r} of {name}: {call.arguments[0]} is not a message with "
        f"{', '.join(forms[-1].members)}, expected {wanted}{_advice(types, name)}"
    )


def _arguments(
    types: TypeDescriptions, name: str, form: Function, arguments: tuple[str, ...]
) -> list[str] | None:
    """Return the paths to the numbers of a function; None if it takes another message."""
    if not form.members:
        return list(arguments)
    (argument,) = arguments
    owner = _walked(types, name, argument)
    if owner.is_array or not owner.is_message:
        return None
    if not _has_numbers(types, owner.name, form.members):
        return None
    return [f"{argument}.{member}" for member in form.members]


def _has_numbers(types: TypeDescriptions, name: str, members: tuple[str, ...]) -> bool:
    fields = types.fields(name)
    found = [fields.get(member, FieldType("")) for member in members]
    return all(each.is_number and not each.is_array for each in found)


def _number(types: TypeDescriptions, name: str, text: str) -> FieldPath:
    field = _walked(types, name, text)
    if field.is_array or not field.is_number:
        kind = f"{field} is not a number" if not field.is_array else f"{field} is a whole array"
        raise MessageError(f"field {text!r} of {name}: {kind}{_advice(types, name)}")
    return FieldPath(text, field.name)


def _walked(types: TypeDescriptions, name: str, text: str) -> FieldType:
    """Return the type that a path leads to."""
    field = FieldType(name)
    for part in FieldPath(text).parts:
        field = _follow(types, field, part, text, name)
    return field


def numeric_fields(types: TypeDescriptions, type_name: str) -> list[str]:
    """Return the paths of all numbers in a type, floats first, stamps left out.

    An element of an array stands for all: ``position[0]``, and ``name=...:position`` where
    there is a sibling array of names.

    Raises:
        MessageError: The type is unknown.
    """
    found = list(_numbers(types, normalise_type_name(type_name)))
    return [path for path, _ in sorted(found, key=lambda item: _rank(*item))]


def computed_fields(types: TypeDescriptions, type_name: str) -> list[str]:
    """Return the usual functions of a type's numbers, angles first.

    Those are the angles of quaternions, tilt by accelerations, directions of velocities, sizes of
    vectors, and altitude by pressure; an element of an array stands for all.

    Raises:
        MessageError: The type is unknown.
    """
    found: list[str] = []
    sizes: list[str] = []
    paths = [path for path, _ in _numbers(types, normalise_type_name(type_name))]
    known = set(paths)
    for path in paths:
        owner, _, member = path.rpartition(".")
        if path.endswith("fluid_pressure"):
            found.append(f"altitude({path})")
        if member != "x" or not owner or not {f"{owner}.y", f"{owner}.z"} <= known:
            continue
        if f"{owner}.w" in known:
            found += [f"{name}({owner})" for name in ("roll", "pitch", "yaw")]
            continue
        if "acceleration" in owner:
            found += [f"{name}({owner})" for name in ("roll", "pitch")]
        if owner.endswith("linear"):
            found.append(f"atan2({owner}.y, {owner}.x)")
        sizes.append(f"norm({owner})")
    return [*found, *sizes]


def _follow(
    types: TypeDescriptions, owner: FieldType, part: PathPart, text: str, type_name: str
) -> FieldType:
    """Return the type that one part leads to."""

    def refuse(problem: str) -> MessageError:
        return MessageError(f"field {text!r} of {type_name}: {problem}{_advice(types, type_name)}")

    if owner.is_array or not owner.is_message:
        raise refuse(f"{owner} has no field {part.name!r}")
    fields = types.fields(owner.name)
    for wanted in filter(None, (part.names, part.name)):
        if wanted not in fields:
            raise refuse(f"{owner.name} has no field {wanted!r}")
    field = fields[part.name]
    if not part.picks:
        return field
    if not field.is_array:
        raise refuse(f"{part.name!r} is a {field}, not an array")
    if part.element is not None and field.capacity is not None and part.element >= field.capacity:
        raise refuse(f"{part.name!r} has at most {field.capacity} elements")
    if part.names is not None and fields[part.names][:2] != ("string", True):
        raise refuse(f"{part.names!r} is a {fields[part.names]}, not an array of names")
    return FieldType(field.name)


def _default_field(types: TypeDescriptions, name: str) -> str:
    if name in DEFAULT_FIELDS:
        return DEFAULT_FIELDS[name]
    found = [each for each in _numbers(types, name) if not _is_spread(each[0])]
    floats = [each for each in found if each[1].name in FLOATS]
    choice = [path for path, field in floats or found if not field.is_array]
    if len(choice) != 1:
        raise MessageError(f"{name} has no default field{_advice(types, name)}")
    return choice[0]


def _advice(types: TypeDescriptions, name: str) -> str:
    paths = numeric_fields(types, name)
    if not paths:
        return "; the type has no numeric field: use another type"
    more = f" and {len(paths) - _MAX_CANDIDATES} more" if len(paths) > _MAX_CANDIDATES else ""
    functions = computed_fields(types, name)[:_MAX_FUNCTIONS]
    computed = f"; or a function: {', '.join(functions)}" if functions else ""
    return f"; choose one of: {', '.join(paths[:_MAX_CANDIDATES])}{more}{computed}"


def _numbers(types: TypeDescriptions, name: str) -> Iterator[tuple[str, FieldType]]:
    """Yield the path and type of each number; an array of them yields one path for all.

    Of a type with very many fields the first ones alone are looked at.
    """
    return _walk(types, name, "", 0, iter(range(_MOST_FIELDS)))


def _walk(
    types: TypeDescriptions, name: str, prefix: str, depth: int, left: Iterator[int]
) -> Iterator[tuple[str, FieldType]]:
    fields = types.fields(name)
    names = [each for each, field in fields.items() if field[:2] == ("string", True)]
    for (each, field), _ in zip(fields.items(), left, strict=False):
        path = f"{prefix}{each}" + ("[0]" if field.is_array else "")
        if field.is_number:
            yield path, field
            if field.is_array and field.capacity is None and names:
                yield f"{prefix}{names[0]}=...:{each}", field
        elif field.is_message and field.name not in _TIMES and depth < _MAX_DEPTH:
            for inner, inner_field in _walk(types, field.name, f"{path}.", depth + 1, left):
                yield inner, inner_field._replace(is_array=field.is_array or inner_field.is_array)


def _rank(path: str, field: FieldType) -> tuple[bool, bool, bool]:
    return field.name not in FLOATS, _is_spread(path), field.is_array


def _is_spread(path: str) -> bool:
    return "variance" in path.lower()
