# SPDX-License-Identifier: Apache-2.0
"""A message becomes a sample, and a sample becomes a message, in nodes and bags.

Instead of deserialising with rclpy or rosbags: see :mod:`fuzzy_fusion_ros.messages.cdr`.
"""

from __future__ import annotations

import math
import re
import struct
from collections.abc import Callable, Iterable
from typing import Any, NamedTuple

from fuzzy_fusion_ros.core.numerics import SECOND_NS
from fuzzy_fusion_ros.core.sample import Sample
from fuzzy_fusion_ros.messages.cdr import EMPTY_ARRAY_BYTES, FORMATS, ORDERS, ORIGIN, PADDING_BYTES
from fuzzy_fusion_ros.messages.defaults import HEADER
from fuzzy_fusion_ros.messages.field_path import Field, FieldPath
from fuzzy_fusion_ros.messages.functions import PLAIN, Function, Numbers, scaled
from fuzzy_fusion_ros.messages.layout import Layout, Walk
from fuzzy_fusion_ros.messages.resolve import resolve_field
from fuzzy_fusion_ros.messages.type_fields import (
    FLOATS,
    INTEGER_RANGES,
    FieldType,
    TypeDescriptions,
)
from fuzzy_fusion_ros.messages.type_names import normalise_type_name
from fuzzy_fusion_ros.parameters.errors import MessageError, StampError

TIME = "builtin_interfaces/msg/Time"

MOST_BYTES = 1 << 16
"""Of a message whose layout is kept for the next: it may have a length at every fourth byte."""


class ScalarCodec:
    """Reads stamp and number of serialised messages of a type, and replaces them.

    The stamp is ``header.stamp``, else a bare ``stamp``, else the time of receipt.

    Attributes:
        type_name: The type, ``package/msg/Type``.
        field: Where the scalar is in it.
        function: From the numbers of the field to the scalar, scale and offset included.
        scale: The scale.
        is_stamped: Whether it carries its own stamp.
    """

    def __init__(
        self,
        types: TypeDescriptions,
        type_name: str,
        field: str = "",
        scale: float = 1.0,
        offset: float = 0.0,
    ) -> None:
        """Find out where things lie.

        Args:
            types: Who describes message types.
            type_name: ``package/msg/Type``, or the short form ``package/Type``.
            field: The path of the number, or a function of paths; empty for the type's own, see
                :func:`resolve_field`.
            scale: The scalar is this times the field,
            offset: plus this.

        Raises:
            MessageError: The type, or one in it, is unknown or cannot be read, it has no such
                field, or the field is not a number.
        """
        type_name = normalise_type_name(type_name)
        self.type_name = type_name
        self.field = resolve_field(types, type_name, field)
        self.function = scaled(self.field.function, scale, offset)
        self.scale = scale
        stamp = _stamp_path(types, type_name)
        self.is_stamped = stamp is not None
        self._views = {
            begin: _view(types, type_name, self.field, stamp, order)
            for begin, order in ORDERS.items()
        }
        self._slack = _slack(types, type_name)
        self._size = 0
        self._known = _NOTHING_YET

    def sample(self, data: bytes, receive_ns: int, kept: bytes = b"") -> Sample:
        """Return the sample that a message carries, NaN and infinite ones too.

        Args:
            data: The message, serialised.
            receive_ns: When it was received, ns.
            kept: The message once more where the sample is to keep it.

        Raises:
            MessageError: It lacks the element, or is not a message of the type.
            StampError: The nanoseconds of its timestamp are a second or more.
        """
        place = self.place(data)
        try:
            value = float(self.function.read(_numbers(place, data)))
        except OverflowError as error:
            raise MessageError(f"a message is not a {self.type_name}: {error}") from None
        if place.stamp_at is None:
            return Sample(receive_ns, value, kept)
        seconds, nanoseconds = place.stamp.unpack_from(data, place.stamp_at)
        if nanoseconds >= SECOND_NS:
            raise StampError(f"a message has {nanoseconds} ns in its timestamp")
        return Sample(seconds * SECOND_NS + nanoseconds, value, kept)

    def value(self, data: bytes) -> float:
        """Return the scalar of a message that another codec of the same type can read.

        Raises:
            MessageError: It lacks the element.
        """
        return float(self.function.read(_numbers(self.place(data), data)))

    def deviation(self, value: float, deviation: float) -> float:
        """Return the standard deviation of the field's number where its scalar has one.

        That is another unit for an altitude, which is written as a pressure. An angle's is its own,
        whatever numbers hold it.

        Args:
            value: The scalar.
            deviation: Its standard deviation.

        Returns:
            Negative where the number falls as the scalar rises.
        """
        write, own = self.function.write, deviation / self.scale
        if write is None or self.field.function is PLAIN or len(self.field.paths) > 1:
            return own
        (above,), (below,) = (write((), value + step) for step in (self.scale, -self.scale))
        return own * 0.5 * (above - below)

    def place(self, data: bytes) -> Place:
        """Return where stamp and numbers are in a message.

        The same holds for every message of the same size and byte order whose strings and arrays
        have the same lengths, unless the path looks up a name. So it is searched for only where
        the message is not laid out as the one before.

        Raises:
            MessageError: It lacks the element, or is not a message of the type.
        """
        size, unpack_lengths, lengths, place = self._known
        if len(data) == size and unpack_lengths(data) == lengths:
            return place
        return self._search(data)

    def _search(self, data: bytes) -> Place:
        view = self._view(data)
        try:
            excess = len(data) - view.end(data, ORIGIN)
            place = view.place(data)
        except (struct.error, OverflowError) as error:
            raise MessageError(f"a message is not a {self.type_name}: {error}") from None
        if not 0 <= excess <= self._slack:
            problem = f"{excess} bytes too many" if excess > 0 else f"{-excess} bytes too few"
            raise MessageError(f"a message is not a {self.type_name}: it has {problem}")
        if len(data) == self._size <= MOST_BYTES and not self.field.looks_up:
            unpack_lengths = _unpacker(ORDERS[data[:2]], self.lengths_at(data))
            self._known = _Known(len(data), unpack_lengths, unpack_lengths(data), place)
        self._size = len(data)
        return place

    def lengths_at(self, data: bytes) -> tuple[int, ...]:
        """Return where the lengths of all texts and arrays are in a message.

        Args:
            data: A message that :meth:`sample` can read.
        """
        return self._view(data).layout.lengths_at(self.type_name, data)

    def frame(self, data: bytes) -> str:
        """Return the ``frame_id`` of a message's header; ``""`` without a header.

        Args:
            data: A message that :meth:`sample` can read.
        """
        view = self._view(data)
        return view.text(view.frame_at, data)

    def element_name(self, data: bytes) -> str:
        """Return what a message calls the element of the field ``position[0]``: its ``name[0]``.

        Args:
            data: A message that :meth:`sample` can read.

        Returns:
            ``""`` for a field that takes no element by its index, or a message without names.
        """
        view = self._view(data)
        try:
            return view.text(view.name_at, data)
        except MessageError:
            return ""  # fewer names than elements

    def template(self, data: bytes) -> Template:
        """Return a message in which stamp and number can be replaced.

        Args:
            data: A message that :meth:`sample` can read, but for the element it may lack.

        Raises:
            MessageError: It lacks the element.
        """
        return Template(data, self.field, self.function, self.place(data))

    def _view(self, data: bytes) -> _View:
        view = self._views.get(data[:2])
        if view is None:
            raise MessageError(
                f"a message is not a {self.type_name}: it begins with {data[:4]!r}, not as CDR"
            )
        return view


class Place(NamedTuple):
    """Where stamp and numbers are in a message.

    Attributes:
        numbers: Of each number of the field its byte order and type, as :mod:`struct` writes them,
            and where it begins.
        stamp_at: Where the stamp begins, 32-bit seconds and nanoseconds; None if there is none.
        stamp: Packs and unpacks both.
    """

    numbers: tuple[tuple[str, int], ...]
    stamp_at: int | None
    stamp: struct.Struct


class _Known(NamedTuple):
    """Where things are in all messages of one size and byte order with lengths like these."""

    size: int
    unpack_lengths: Callable[[bytes], tuple[Any, ...]]
    lengths: tuple[Any, ...]
    place: Place


_NOTHING_YET = _Known(-1, lambda data: (), (), Place((), None, struct.Struct("")))


class Template:
    """A message of which stamp and number are replaced; the rest stays as it is."""

    def __init__(self, data: bytes, field: Field, function: Function, place: Place) -> None:
        self._data = data
        self._field = field
        self._write = function.write
        self._place = place
        self._slots = [
            (form, at, None if path.number in FLOATS else INTEGER_RANGES[path.number])
            for path, (form, at) in zip(field.paths, place.numbers, strict=True)
        ]
        self._before = _numbers(place, data)

    def filled(self, value: float, stamp_ns: int) -> bytes:
        """Return the message with another number and, if it has one, another stamp.

        Args:
            value: The scalar; a field of an integer type takes the nearest number.
            stamp_ns: The stamp, ns since the epoch of the message's clock.

        Raises:
            MessageError: The number or the stamp does not fit, or the field is a function that
                cannot be inverted.
        """
        filled = self.stamped(stamp_ns)
        self.fill(filled, value)
        return bytes(filled)

    def stamped(self, stamp_ns: int) -> bytearray:
        """Return the message with another stamp, if it has one, to be filled.

        Args:
            stamp_ns: The stamp, ns since the epoch of the message's clock.

        Raises:
            MessageError: The stamp does not fit.
        """
        stamped = bytearray(self._data)
        _, stamp_at, stamp = self._place
        if stamp_at is not None:
            try:
                stamp.pack_into(stamped, stamp_at, *divmod(stamp_ns, SECOND_NS))
            except struct.error:
                raise MessageError(
                    f"stamp {stamp_ns} ns is past 2038: it does not fit into 32-bit seconds"
                ) from None
        return stamped

    def fill(self, message: bytearray, value: float) -> None:
        """Replace the number in a copy of the message, in which other numbers may differ.

        Args:
            message: The copy.
            value: The scalar; a field of an integer type takes the nearest number.

        Raises:
            MessageError: The number does not fit, or the field is a function that cannot be
                inverted.
        """
        if self._write is None:
            raise MessageError(f"field {self._field.text!r} cannot be inverted")
        try:
            before = self._before if len(self._slots) == 1 else _numbers(self._place, message)
            numbers = self._write(before, value)
            for (form, at, limits), number in zip(self._slots, numbers, strict=True):
                fitting = number if limits is None else _rounded(number, *limits)
                struct.pack_into(form, message, at, fitting)
        except (OverflowError, ValueError):
            raise _unfit(self._field, value) from None


class _View(NamedTuple):
    """Where things are in the messages of one byte order, and how to read them."""

    layout: Layout
    end: Walk
    place: Callable[[bytes], Place]
    frame_at: Walk | None
    name_at: Walk | None

    def text(self, at: Walk | None, data: bytes) -> str:
        """Return the text at some place of a message, ``""`` if there is none."""
        if at is None:
            return ""
        return self.layout.text_at(data, at(data, ORIGIN)).decode(errors="replace")


def _view(
    types: TypeDescriptions, type_name: str, field: Field, stamp: str | None, order: str
) -> _View:
    layout = Layout(types, order)
    has_frame = _has_frame(types, type_name)
    name_path = _name_path(types, type_name, field)
    stamp_at = layout.place(type_name, FieldPath(f"{stamp}.sec")) if stamp else None
    walks = [(order + FORMATS[path.number], layout.place(type_name, path)) for path in field.paths]

    stamp_form = struct.Struct(f"{order}iI")

    def place(data: bytes) -> Place:
        numbers = tuple([(form, walk(data, ORIGIN)) for form, walk in walks])
        return Place(numbers, stamp_at and stamp_at(data, ORIGIN), stamp_form)

    return _View(
        layout=layout,
        end=layout.end(type_name),
        place=place,
        frame_at=layout.place(type_name, FieldPath("header.frame_id")) if has_frame else None,
        name_at=layout.place(type_name, FieldPath(name_path)) if name_path else None,
    )


def _unpacker(order: str, lengths_at: Iterable[int]) -> Callable[[bytes], tuple[Any, ...]]:
    """Return what takes the lengths of strings and arrays from a message, after its first bytes."""
    forms, at = [f"{order}2s"], 2
    for each in lengths_at:
        forms.append(f"{each - at}xI")
        at = each + 4
    return struct.Struct("".join(forms)).unpack_from


def _numbers(place: Place, data: bytes | bytearray) -> Numbers:
    """Return the numbers of a message; the usual one alone without a loop."""
    if len(place.numbers) == 1:
        ((form, at),) = place.numbers
        return struct.unpack_from(form, data, at)
    return [struct.unpack_from(form, data, at)[0] for form, at in place.numbers]


def _name_path(types: TypeDescriptions, type_name: str, field: Field) -> str | None:
    """Return where the name of the element is that a field takes by its index, as of a joint."""
    if len(field.paths) != 1 or field.looks_up:
        return None
    *owners, last = field.paths[0].parts
    owner = type_name
    for part in owners:
        owner = types.fields(owner)[part.name].name
    names = types.fields(owner).get("name")
    if last.element is None or names is None or not (names.name == "string" and names.is_array):
        return None
    return re.sub(rf"{last.name}\[\d+\]$", f"name[{last.element}]", field.paths[0].text)


def _has_frame(types: TypeDescriptions, type_name: str) -> bool:
    """Return whether a type has a header with a frame; a bag describes its types itself."""
    header = types.fields(type_name).get("header")
    if header is None or header.name != HEADER or header.is_array:
        return False
    frame = types.fields(HEADER).get("frame_id")
    return frame is not None and frame[:2] == ("string", False)


def _stamp_path(types: TypeDescriptions, type_name: str) -> str | None:
    """Return where the stamp of a type is, if it has one."""
    fields = types.fields(type_name)
    header = fields.get("header")
    if header is not None and header.is_message and not header.is_array:
        stamp = types.fields(header.name).get("stamp")
        if stamp is not None and _is_time(types, stamp):
            return "header.stamp"
    stamp = fields.get("stamp")
    return "stamp" if stamp is not None and _is_time(types, stamp) else None


def _is_time(types: TypeDescriptions, field: FieldType) -> bool:
    if field[:2] != (TIME, False):
        return False
    parts = {name: part[:2] for name, part in types.fields(TIME).items()}
    return parts == {"sec": ("int32", False), "nanosec": ("uint32", False)}


def _slack(types: TypeDescriptions, type_name: str) -> float:
    """Return how many bytes may follow a message; any number where arrays are nested."""
    slack = float(PADDING_BYTES)
    for field in types.fields(type_name).values():
        if field.is_array and field.is_message:
            return math.inf
        if field.is_array and not field.is_fixed:
            slack += EMPTY_ARRAY_BYTES
        elif field.is_message:
            slack += _slack(types, field.name) - PADDING_BYTES
    return slack


def _rounded(value: float, low: int, high: int) -> int:
    """Return the integer nearest to a value.

    Raises:
        OverflowError: It is not within the range, as an infinite one.
        ValueError: It is not a number.
    """
    if not low <= round(value) <= high:
        raise OverflowError
    return round(value)


def _unfit(field: Field, value: float) -> MessageError:
    return MessageError(f"field {field.text!r} is of type {field.types}, {value!r} does not fit")
