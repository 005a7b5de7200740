"""Checks a field path against a message type, before the first message comes."""

from __future__ import annotations

from collections.abc import Iterator

from fuzzy_fusion_ros.messages.field_path import FieldPath, PathPart
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
_MAX_DEPTH = 6
_MOST_FIELDS = 10_000
_TIMES = frozenset({"builtin_interfaces/msg/Time", "std_msgs/msg/Header"})


def resolve_field(types: TypeDescriptions, type_name: str, text: str = "") -> FieldPath:
    """Return the path ``text`` after checking that it leads to a number in that type.

    Args:
        types: Who describes message types.
        type_name: ``package/msg/Type``.
        text: The path, or empty for the default field of the type: that of
            ``DEFAULT_FIELDS``, else the only float outside header, arrays and variances, or
            the only integer where there are no floats.

    Raises:
        MessageError: The type is unknown, has no such field, the field is no number, or there
            is no default; except for the first, the error lists the candidates.
    """
    name = normalise_type_name(type_name)
    types.fields(name)  # an unknown type is said first
    path = FieldPath(text or _default_field(types, name))
    field = FieldType(name)
    for part in path.parts:
        field = _follow(types, field, part, path.text, name)
    if field.is_array or not field.is_number:
        kind = f"{field} is no number" if not field.is_array else f"{field} is a whole array"
        raise MessageError(f"field {path.text!r} of {name}: {kind}{_advice(types, name)}")
    return FieldPath(path.text, field.name)


def numeric_fields(types: TypeDescriptions, type_name: str) -> list[str]:
    """Return the paths of all numbers in a type, floats first, stamps left out.

    An element of an array stands for all: ``position[0]``, and ``name=...:position`` where
    there is an array of names beside it.

    Raises:
        MessageError: The type is unknown.
    """
    found = list(_numbers(types, normalise_type_name(type_name)))
    return [path for path, _ in sorted(found, key=lambda item: _rank(*item))]


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
        raise refuse(f"{part.name!r} is a {field}, no array")
    if part.element is not None and field.capacity is not None and part.element >= field.capacity:
        raise refuse(f"{part.name!r} has {field.capacity} elements at most")
    if part.names is not None and fields[part.names][:2] != ("string", True):
        raise refuse(f"{part.names!r} is a {fields[part.names]}, no array of names")
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
        return "; the type holds no number at all: use another one"
    more = f" and {len(paths) - _MAX_CANDIDATES} more" if len(paths) > _MAX_CANDIDATES else ""
    return f"; choose one of: {', '.join(paths[:_MAX_CANDIDATES])}{more}"


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
