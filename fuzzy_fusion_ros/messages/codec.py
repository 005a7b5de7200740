"""A message becomes a sample, and a sample becomes a message, in nodes and bags.

Instead of deserialising with rclpy or rosbags: see :mod:`fuzzy_fusion_ros.messages.cdr`.
"""

from __future__ import annotations

import contextlib
import math
import struct
from typing import NamedTuple

from fuzzy_fusion_ros.core.numerics import SECOND_NS
from fuzzy_fusion_ros.core.sample import Sample
from fuzzy_fusion_ros.messages.cdr import EMPTY_ARRAY_BYTES, FORMATS, ORDERS, ORIGIN, PADDING_BYTES
from fuzzy_fusion_ros.messages.defaults import HEADER
from fuzzy_fusion_ros.messages.field_path import FieldPath
from fuzzy_fusion_ros.messages.layout import Layout, Walk
from fuzzy_fusion_ros.messages.resolve import resolve_field
from fuzzy_fusion_ros.messages.type_fields import FLOATS, INTEGER_RANGES, TypeDescriptions
from fuzzy_fusion_ros.messages.type_names import normalise_type_name
from fuzzy_fusion_ros.parameters.errors import MessageError, StampError

TIME = "builtin_interfaces/msg/Time"


class ScalarCodec:
    """Reads stamp and number of serialised messages of a type, and replaces them.

    The stamp is ``header.stamp``, else a bare ``stamp``, else the time of receipt.

    Attributes:
        type_name: The type, ``package/msg/Type``.
        field: Where the number is in it.
        is_stamped: Whether it carries a stamp of its own.
    """

    def __init__(self, types: TypeDescriptions, type_name: str, field: str = "") -> None:
        """Find out where things lie.

        Args:
            types: Who describes message types.
            type_name: ``package/msg/Type``, or the short form ``package/Type``.
            field: The path of the number; empty for the type's own, see :func:`resolve_field`.

        Raises:
            MessageError: The type, or one in it, is unknown or cannot be read, it has no such
                field, or the field is no number.
        """
        type_name = normalise_type_name(type_name)
        self.type_name = type_name
        self.field = resolve_field(types, type_name, field)
        stamp = _stamp_path(types, type_name)
        self.is_stamped = stamp is not None
        self._views = {
            begin: _view(types, type_name, self.field, stamp, order)
            for begin, order in ORDERS.items()
        }
        self._slack = _slack(types, type_name)

    def sample(self, data: bytes, receive_ns: int) -> Sample:
        """Return the sample that a message carries, NaN and infinite ones too.

        Args:
            data: The message, serialised.
            receive_ns: When it was received, ns.

        Raises:
            MessageError: It lacks the element, or is no message of the type.
            StampError: The nanoseconds of its timestamp are a second or more.
        """
        view = self._view(data)
        try:
            excess = len(data) - view.end(data, ORIGIN)
            (value,) = view.number.unpack_from(data, view.number_at(data, ORIGIN))
            stamp_ns = receive_ns
            if view.stamp_at is not None:
                seconds, nanoseconds = view.stamp.unpack_from(data, view.stamp_at(data, ORIGIN))
                stamp_ns = seconds * SECOND_NS + nanoseconds
                if nanoseconds >= SECOND_NS:
                    raise StampError(f"a message has {nanoseconds} ns in its timestamp")
        except (struct.error, OverflowError) as error:
            raise MessageError(f"a message is no {self.type_name}: {error}") from None
        if not 0 <= excess <= self._slack:
            problem = f"{excess} bytes too many" if excess > 0 else f"{-excess} bytes too few"
            raise MessageError(f"a message is no {self.type_name}: it has {problem}")
        return Sample(stamp_ns, float(value))

    def place(self, data: bytes) -> Place:
        """Return where stamp and number are in a message.

        They are there in every message of the same size and byte order in which all texts and
        arrays are as long, unless the path looks up a name.

        Raises:
            MessageError: It lacks the element, or is no message of the type.
        """
        with contextlib.suppress(StampError):
            self.sample(data, 0)
        view = self._view(data)
        stamp_at = None if view.stamp_at is None else view.stamp_at(data, ORIGIN)
        return Place(view.number.format, view.number_at(data, ORIGIN), stamp_at)

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
        if view.frame_at is None:
            return ""
        return view.layout.text_at(data, view.frame_at(data, ORIGIN)).decode(errors="replace")

    def template(self, data: bytes) -> Template:
        """Return a message in which stamp and number can be replaced.

        Args:
            data: A message that :meth:`sample` can read, but for the element it may lack.

        Raises:
            MessageError: It lacks the element.
        """
        view = self._view(data)
        stamp_at = None if view.stamp_at is None else view.stamp_at(data, ORIGIN)
        return Template(data, self.field, view, view.number_at(data, ORIGIN), stamp_at)

    def _view(self, data: bytes) -> _View:
        view = self._views.get(data[:2])
        if view is None:
            raise MessageError(
                f"a message is no {self.type_name}: it begins with {data[:4]!r}, no CDR"
            )
        return view


class Place(NamedTuple):
    """Where stamp and number are in a message.

    Attributes:
        number: Byte order and type of the number, as :mod:`struct` writes them.
        number_at: Where it begins.
        stamp_at: Where the stamp begins, 32-bit seconds and nanoseconds; None if there is none.
    """

    number: str
    number_at: int
    stamp_at: int | None


class Template:
    """A message of which stamp and number are replaced; the rest stays as it is."""

    def __init__(
        self, data: bytes, field: FieldPath, view: _View, number_at: int, stamp_at: int | None
    ) -> None:
        self._data = data
        self._field = field
        self._view = view
        self._number_at = number_at
        self._stamp_at = stamp_at

    def filled(self, value: float, stamp_ns: int) -> bytes:
        """Return the message with another number and, if it has one, another stamp.

        Args:
            value: The number, unit of the field; a field of an integer type takes the nearest.
            stamp_ns: The stamp, ns since the epoch of the message's clock.

        Raises:
            MessageError: The number or the stamp does not fit.
        """
        filled = bytearray(self._data)
        try:
            self._view.number.pack_into(filled, self._number_at, _fitting(self._field, value))
        except OverflowError:
            raise _unfit(self._field, value) from None
        if self._stamp_at is not None:
            try:
                self._view.stamp.pack_into(filled, self._stamp_at, *divmod(stamp_ns, SECOND_NS))
            except struct.error:
                raise MessageError(
                    f"stamp {stamp_ns} ns does not fit into 32-bit seconds"
                ) from None
        return bytes(filled)


class _View(NamedTuple):
    """Where things are in the messages of one byte order, and how to read them."""

    layout: Layout
    end: Walk
    number: struct.Struct
    number_at: Walk
    stamp: struct.Struct
    stamp_at: Walk | None
    frame_at: Walk | None


def _view(
    types: TypeDescriptions, type_name: str, field: FieldPath, stamp: str | None, order: str
) -> _View:
    layout = Layout(types, order)
    header = types.fields(type_name).get("header")
    has_frame = header is not None and header.name == HEADER and not header.is_array
    stamp_at = layout.place(type_name, FieldPath(f"{stamp}.sec")) if stamp else None
    return _View(
        layout=layout,
        end=layout.end(type_name),
        number=struct.Struct(order + FORMATS[field.number]),
        number_at=layout.place(type_name, field),
        stamp=struct.Struct(order + "iI"),
        stamp_at=stamp_at,
        frame_at=layout.place(type_name, FieldPath("header.frame_id")) if has_frame else None,
    )


def _stamp_path(types: TypeDescriptions, type_name: str) -> str | None:
    """Return where the stamp of a type is, if it has one."""
    fields = types.fields(type_name)
    header = fields.get("header")
    if header is not None and header.is_message and not header.is_array:
        stamp = types.fields(header.name).get("stamp")
        if stamp is not None and stamp[:2] == (TIME, False):
            return "header.stamp"
    stamp = fields.get("stamp")
    return "stamp" if stamp is not None and stamp[:2] == (TIME, False) else None


def _slack(types: TypeDescriptions, type_name: str) -> float:
    """Return how many bytes may lie behind a message; where arrays nest, any number."""
    slack = float(PADDING_BYTES)
    for field in types.fields(type_name).values():
        if field.is_array and field.is_message:
            return math.inf
        if field.is_array and not field.is_fixed:
            slack += EMPTY_ARRAY_BYTES
        elif field.is_message:
            slack += _slack(types, field.name) - PADDING_BYTES
    return slack


def _fitting(field: FieldPath, value: float) -> float:
    """Return a value as a field takes it."""
    if field.number in FLOATS:
        return value
    low, high = INTEGER_RANGES[field.number]
    if not (math.isfinite(value) and low <= round(value) <= high):
        raise _unfit(field, value)
    return round(value)


def _unfit(field: FieldPath, value: float) -> MessageError:
    return MessageError(f"field {field.text!r} is of type {field.number}, {value!r} does not fit")
