# SPDX-License-Identifier: Apache-2.0
"""Where fields are in serialised messages.

Instead of deserialising with rclpy or rosbags: see :mod:`fuzzy_fusion_ros.messages.cdr`.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterable, Mapping, Sequence

from fuzzy_fusion_ros.messages.cdr import ORIGIN, SIZES
from fuzzy_fusion_ros.messages.field_path import FieldPath, PathPart
from fuzzy_fusion_ros.messages.type_fields import FieldType, TypeDescriptions
from fuzzy_fusion_ros.parameters.errors import MessageError

Walk = Callable[[bytes, int], int]
"""Takes bytes and where something begins in them; returns where it ends, or what it looks for
begins. Raises ``struct.error`` where the bytes end before."""

_Part = tuple[int, int] | Walk
"""A number of bytes for each of a number of elements, or a walk past anything else."""

_DEEPEST = 32
MOST_PARTS = 100_000
"""Fields of a type, those of messages in it included: more are taken for an attack."""

MOST_ELEMENTS = 1_000_000
"""Messages or texts of a sequence that are walked past; a message with more cannot be read."""

_FILLER = {"structure_needs_at_least_one_member": FieldType("uint8")}


class Layout:
    """How messages lie in the bytes of one byte order."""

    def __init__(self, types: TypeDescriptions, order: str) -> None:
        """Begin to describe.

        Args:
            types: Who describes message types.
            order: ``<`` or ``>``, as :mod:`struct` has it.
        """
        self._types = types
        self._messages: dict[str, list[_Part]] = {}
        self._noting: dict[str, tuple[Walk, list[int]]] = {}
        self._unpack_count: Callable[[bytes, int], tuple[int, ...]] = struct.Struct(
            f"{order}I"
        ).unpack_from

    def end(self, type_name: str) -> Walk:
        """Return the walk past a message.

        Raises:
            MessageError: The type, or one in it, is unknown, or has no layout that is known.
        """
        return _chain(_merged(self._parts(FieldType(type_name))))

    def lengths_at(self, type_name: str, data: bytes) -> tuple[int, ...]:
        """Return where the lengths of all texts and arrays are in a message.

        Args:
            type_name: The type of the message.
            data: A message of it.
        """
        if type_name not in self._noting:
            self._noting[type_name] = self._walk_that_notes(type_name)
        walk, found = self._noting[type_name]
        found.clear()
        walk(data, ORIGIN)
        return tuple(found)

    def _walk_that_notes(self, type_name: str) -> tuple[Walk, list[int]]:
        """Return a walk past a message, and the list in which it notes where lengths are."""
        found: list[int] = []
        noting = Layout(self._types, "<")

        def note(data: bytes, at: int) -> tuple[int, ...]:
            found.append(at)
            return self._unpack_count(data, at)

        noting._unpack_count = note
        return noting.end(type_name), found

    def place(self, type_name: str, field: FieldPath) -> Walk:
        """Return the walk from the start of a message to a number or a text in it.

        The walk raises :class:`MessageError` where a message lacks the element.

        Args:
            type_name: The type of the message.
            field: A path that is in the type.

        Raises:
            MessageError: As :meth:`end` does.
        """
        walks: list[Walk] = []
        parts: list[_Part] = []
        owner = type_name
        for part in field.parts:
            fields = self._fields(owner)
            if part.picks:
                walks += [*_merged(parts), self._pick(fields, part, field.text)]
                parts = []
            else:
                parts += self._parts_before(fields, part.name)
            owner = fields[part.name].name
        return _chain([*walks, *_merged(parts), _aligned(SIZES.get(owner, 4))])

    def text_at(self, data: bytes, at: int) -> bytes:
        """Return the text that begins at some place or, aligned, behind it."""
        at += -at & 3
        return bytes(data[at + 4 : at + 4 + self._unpack_count(data, at)[0]].rstrip(b"\0"))

    def _fields(self, type_name: str) -> Mapping[str, FieldType]:
        return self._types.fields(type_name) or _FILLER  # nothing is empty in CDR

    def _parts_before(self, fields: Mapping[str, FieldType], name: str) -> list[_Part]:
        names = list(fields)
        return [part for each in names[: names.index(name)] for part in self._parts(fields[each])]

    def _parts(self, field: FieldType, depth: int = 0) -> list[_Part]:
        """Return what a field consists of, messages in it taken apart."""
        if depth > _DEEPEST:
            raise MessageError(f"message type {field.name!r} contains itself")
        if field.is_array and not field.is_fixed:
            return [self._sequence(field, depth)]
        count = field.capacity if field.is_array and field.capacity is not None else 1
        if field.name in SIZES:
            return [(SIZES[field.name], count)]
        element = self._element(field, depth)
        if count * len(element) > MOST_PARTS:
            raise _too_large(field.name)
        return count * element

    def _element(self, field: FieldType, depth: int) -> list[_Part]:
        """Return what one element of a field consists of, where that is not a number."""
        if field.is_message:
            if field.name not in self._messages:
                self._messages[field.name] = self._message(field.name, depth)
            return self._messages[field.name]
        if field.name == "string":
            return [self._text]
        raise MessageError(f"fields of type {field.name} are not supported")

    def _message(self, type_name: str, depth: int) -> list[_Part]:
        parts: list[_Part] = []
        for each in self._fields(type_name).values():
            parts += self._parts(each, depth + 1)
            if len(parts) > MOST_PARTS:
                raise _too_large(type_name)
        return parts

    def _text(self, data: bytes, at: int) -> int:
        at += -at & 3
        return at + 4 + int(self._unpack_count(data, at)[0])

    def _sequence(self, field: FieldType, depth: int) -> Walk:
        unpack_count = self._unpack_count
        size = SIZES.get(field.name, 0)
        if size:

            def walk_numbers(data: bytes, at: int) -> int:
                at += -at & 3
                (count,) = unpack_count(data, at)
                at += 4
                return at + -(at - ORIGIN) % size + int(count) * size if count else at

            return walk_numbers
        past = _chain(_merged(self._element(field, depth)))

        def walk(data: bytes, at: int) -> int:
            at += -at & 3
            (count,) = unpack_count(data, at)
            return _repeated(past, count, data, at + 4)

        return walk

    def _pick(self, fields: Mapping[str, FieldType], part: PathPart, text: str) -> Walk:
        """Return the walk from the start of a message to an element of an array in it."""
        field = fields[part.name]
        to_array = _chain(_merged(self._parts_before(fields, part.name)))
        to_element = self._elements(field, part, text)
        if part.names is None:
            element = part.element or 0
            return lambda data, at: to_element(data, to_array(data, at), element)
        to_names = _chain(_merged(self._parts_before(fields, part.names)))
        index = self._index(fields[part.names], part, text)
        return lambda data, at: to_element(
            data, to_array(data, at), index(data, to_names(data, at))
        )

    def _count(self, field: FieldType, data: bytes, at: int) -> tuple[int, int]:
        """Return how many elements an array has, and where the first may begin."""
        if field.is_fixed:
            return field.capacity or 0, at
        at += -at & 3
        return int(self._unpack_count(data, at)[0]), at + 4

    def _elements(
        self, field: FieldType, part: PathPart, text: str
    ) -> Callable[[bytes, int, int], int]:
        """Return the walk from the start of an array to one of its elements."""
        size = SIZES.get(field.name, 0)
        past = None if size else _chain(_merged(self._element(field, 0)))

        def walk(data: bytes, at: int, element: int) -> int:
            count, at = self._count(field, data, at)
            if element >= count:
                raise MessageError(
                    f"field {text!r}: {part.name} has {count} elements in this message"
                )
            if past is None:
                return at + -(at - ORIGIN) % size + element * size
            return _repeated(past, element, data, at)

        return walk

    def _index(self, field: FieldType, part: PathPart, text: str) -> Walk:
        """Return the search for a name in an array of them."""
        key = (part.key or "").encode(errors="surrogateescape")

        def search(data: bytes, at: int) -> int:
            count, at = self._count(field, data, at)
            names: list[bytes] = []
            for index in range(min(count, len(data))):
                names.append(self.text_at(data, at))
                if names[-1] == key:
                    return index
                at = self._text(data, at)
            shown = [name.decode(errors="replace") for name in names]
            raise MessageError(f"field {text!r}: {part.key!r} is not in {part.names} {shown!r}")

        return search


def _merged(parts: Iterable[_Part]) -> list[Walk]:
    """Return the walks past parts, numbers side by side taken in one."""
    walks: list[Walk] = []
    numbers: list[tuple[int, int]] = []
    for part in [*parts, None]:
        if isinstance(part, tuple):
            numbers.append(part)
            continue
        if numbers:
            walks.append(_numbers(numbers))
            numbers = []
        if part is not None:
            walks.append(part)
    return walks


def _numbers(numbers: Sequence[tuple[int, int]]) -> Walk:
    """Return the walk past numbers; how long they are depends on where they begin."""
    lengths = []
    for phase in range(8):
        at = phase
        for size, count in numbers:
            at += -at % size + size * count
        lengths.append(at - phase)
    return lambda data, at: at + lengths[(at - ORIGIN) & 7]


def _aligned(size: int) -> Walk:
    return lambda data, at: at + -(at - ORIGIN) % size


def _too_large(type_name: str) -> MessageError:
    return MessageError(
        f"message type {type_name!r} has more than {MOST_PARTS} fields, nested ones included"
    )


def _repeated(past: Walk, times: int, data: bytes, at: int) -> int:
    if times > min(len(data), MOST_ELEMENTS):
        raise struct.error(f"{times} elements do not fit into {len(data)} bytes")
    for _ in range(times):
        at = past(data, at)
    return at


def _chain(walks: Sequence[Walk]) -> Walk:
    if len(walks) == 1:
        return walks[0]

    def walk(data: bytes, at: int) -> int:
        for each in walks:
            at = each(data, at)
        return at

    return walk
