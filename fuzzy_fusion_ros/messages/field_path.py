# SPDX-License-Identifier: Apache-2.0
"""A path to one number in a message, such as ``point.x``, or a function of paths: ``norm(v)``."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import NamedTuple

from fuzzy_fusion_ros.messages.functions import Function
from fuzzy_fusion_ros.parameters.errors import MessageError

_CALL = re.compile(r"\s*([A-Za-z]\w*)\((.*)\)\s*")
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
    ``name=pole:position`` takes the element of ``position`` at the index at which its sibling
    array ``name`` holds ``pole``.

    Attributes:
        text: The path as the user wrote it.
        number: The type of the number, such as ``float64``; an integer type rounds and limits
            what is written.
        parts: The path, parsed.

    Raises:
        MessageError: The text is not a path.
    """

    text: str
    number: str = "float64"
    parts: tuple[PathPart, ...] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        """Parse ``text``."""
        object.__setattr__(self, "parts", _parse(self.text))


class Call(NamedTuple):
    """A function of paths, as it is written.

    Attributes:
        name: Its name.
        arguments: The paths.
    """

    name: str
    arguments: tuple[str, ...]


def call_in(text: str) -> Call | None:
    """Return the function that a field is, or None if it is a path."""
    found = _CALL.fullmatch(text)
    if found is None:
        return None
    return Call(found[1], tuple(each.strip() for each in found[2].split(",")))


class Field(NamedTuple):
    """Where the scalar of a message is: one number, or a function of some.

    Attributes:
        text: What the user wrote.
        paths: To the numbers.
        function: From the numbers to the scalar, and back.
    """

    text: str
    paths: tuple[FieldPath, ...]
    function: Function

    @property
    def looks_up(self) -> bool:
        """Whether a path takes an element by its name."""
        return any(part.key for path in self.paths for part in path.parts)

    @property
    def types(self) -> str:
        """The types of its numbers, in words."""
        return ", ".join(sorted({path.number for path in self.paths}))


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
            f"field {text!r} is not a path: {part!r} cannot be parsed; for example "
            "'data', 'point.x', 'position[0]' or 'name=pole:position'"
        )
    return PathPart(match[1], element=None if match[2] is None else int(match[2]))
