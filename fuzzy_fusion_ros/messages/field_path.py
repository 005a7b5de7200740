"""A path to one number in a message, such as ``point.x`` or ``name=pole:position``."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import NamedTuple

from fuzzy_fusion_ros.parameters.errors import MessageError

_NAME = r"[A-Za-z]\w*"
_PLAIN = re.compile(rf"({_NAME})(?:\[(\d+)\])?")
_LOOK_UP = re.compile(rf"((?:{_NAME}(?:\[\d+\])?\.)*)({_NAME})=(.+):({_NAME})((?:\..+)?)")


class PathPart(NamedTuple):
    """One part of a path: into a field, and into an element of it where it is an array.

    Attributes:
        name: The field to enter.
        element: The index of the element of it to take, or None.
        names: The sibling array to look ``key`` up in; its index is that of the element.
        key: The name of the element, or None.
    """

    name: str
    element: int | None = None
    names: str | None = None
    key: str | None = None

    @property
    def picks(self) -> bool:
        """Whether the part takes one element of an array."""
        return self.element is not None or self.key is not None


@dataclass(frozen=True)
class FieldPath:
    """A path to one number in a message, parsed once.

    ``point.x`` goes through fields, ``position[0]`` takes an element, and
    ``name=pole:position`` takes the element of ``position`` at the index at which the array
    ``name`` beside it holds ``pole``.

    Attributes:
        text: The path as the user wrote it.
        number: The type of the number, such as ``float64``; an integer type rounds and limits
            what is written.
        parts: The path, parsed.

    Raises:
        MessageError: The text is no path.
    """

    text: str
    number: str = "float64"
    parts: tuple[PathPart, ...] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        """Parse ``text``."""
        object.__setattr__(self, "parts", _parse(self.text))


def _parse(text: str) -> tuple[PathPart, ...]:
    look_up = _LOOK_UP.fullmatch(text)
    if look_up is None:
        return tuple(_parse_plain(part, text) for part in text.split("."))
    before, names, key, values, after = look_up.groups()
    return (
        *(_parse_plain(part, text) for part in before.split(".") if part),
        PathPart(values, names=names, key=key),
        *(_parse_plain(part, text) for part in after.split(".")[1:]),
    )


def _parse_plain(part: str, text: str) -> PathPart:
    match = _PLAIN.fullmatch(part)
    if match is None:
        raise MessageError(
            f"field {text!r} is no path: {part!r} is not understood; write for example "
            "'data', 'point.x', 'position[0]' or 'name=pole:position'"
        )
    return PathPart(match[1], element=None if match[2] is None else int(match[2]))
