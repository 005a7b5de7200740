"""Message types of a bag: between serialised bytes and rosbags' dataclasses."""

from __future__ import annotations

import contextlib
import struct
from collections.abc import Iterable, Mapping
from functools import cache
from typing import Any

import numpy as np
from rosbags.interfaces import Msgdef, Nodetype
from rosbags.serde import SerdeError
from rosbags.typesys import Stores, TypesysError, get_types_from_idl, get_types_from_msg
from rosbags.typesys import get_typestore as _get_typestore
from rosbags.typesys.store import Typestore

from fuzzy_fusion_ros.bag.from_rclpy import dataclass_from_rclpy
from fuzzy_fusion_ros.bag.installed import installed_definition
from fuzzy_fusion_ros.bag.topic import Definition, Topic
from fuzzy_fusion_ros.messages.cdr import EMPTY_ARRAY_BYTES, ORDERS, ORIGIN, PADDING_BYTES
from fuzzy_fusion_ros.messages.type_fields import FieldType
from fuzzy_fusion_ros.messages.type_names import type_name_of
from fuzzy_fusion_ros.parameters.errors import BagError, MessageError

_SEPARATOR = "=" * 80 + "\n"

# What rosbags' generated code raises on bytes that do not fit.
_UNFIT = (SerdeError, struct.error, ValueError, LookupError, OverflowError, MemoryError)


class BagTypes:
    """The message types that a bag describes, and those of ROS 2 Jazzy.

    What a bag says about a type holds for its messages, even if Jazzy's type of that name
    differs. A type that neither describes is looked up among the installed ones.

    Attributes:
        problems: One line per definition that cannot be used.
    """

    def __init__(self, topics: Iterable[Topic] = ()) -> None:
        """Read the definitions of topics, nested types included."""
        self.problems: list[str] = []
        self._definitions: dict[str, Definition] = {}
        self._store = _get_typestore(Stores.ROS2_JAZZY)
        own: dict[str, Any] = {}
        for msgtype, definition in dict.fromkeys(
            (each.msgtype, each.definition) for each in topics
        ):
            if definition is not None:
                self._definitions.setdefault(msgtype, definition)
                self._take_in(msgtype, definition, own)
        self._register(own)

    def decode(self, msgtype: str, data: bytes) -> Any:
        """Return a message as rosbags' dataclass.

        Args:
            msgtype: ``package/msg/Type``.
            data: CDR with its encapsulation header.

        Raises:
            BagError: The type is not known.
            MessageError: This message does not have the layout of its type.
        """
        layout = self._store.cache.get(msgtype) or self._layout(msgtype)
        if data[:2] not in ORDERS:
            raise MessageError(f"a message is no {msgtype}: it begins with {data[:4]!r}, no CDR")
        read = layout.deserialize_cdr_le if data[1] else layout.deserialize_cdr_be
        try:
            message, end = read(data[ORIGIN:], 0, layout.cls, self._store)
        except _UNFIT as error:
            raise MessageError(f"a message is no {msgtype}: {error}") from error
        if end + ORIGIN + PADDING_BYTES < len(data):
            excess = len(data) - end - ORIGIN
            if excess > PADDING_BYTES + EMPTY_ARRAY_BYTES * _empty_arrays(message):
                raise MessageError(f"a message is no {msgtype}: it has {excess} bytes too many")
        return message

    def serialize(self, message: Any) -> bytes:
        """Return the CDR bytes of a message of rosbags or of rclpy.

        They are what rclpy's ``serialize_message`` returns, with zeros where that leaves its
        memory as it found it (padding), and without the bytes that it may leave at the end: the
        same message gives the same bytes in every run.

        Raises:
            BagError: The type is not known.
            MessageError: A field holds what its type cannot.
        """
        msgtype = type_name_of(message)
        self._layout(msgtype)
        try:
            if not hasattr(message, "__msgtype__"):
                message = dataclass_from_rclpy(message, msgtype, self._store)
            return bytes(self._store.serialize_cdr(message, msgtype, little_endian=True))
        except Exception as error:  # generated code: any error means that a value does not fit
            raise MessageError(f"{msgtype} cannot be serialised: {error}") from error

    def message_class(self, msgtype: str) -> Any:
        """Return the dataclass of a type.

        Raises:
            BagError: The type is not known.
        """
        self._layout(msgtype)
        return self._store.types[msgtype]

    def fields(self, type_name: str) -> Mapping[str, FieldType]:
        """Return the fields of a type in their order.

        Raises:
            MessageError: The type is not known.
        """
        if type_name not in self._store.fielddefs:
            raise MessageError(f"message type {type_name!r} is not described by the bag")
        return {name: _field_type(each) for name, each in self._store.fielddefs[type_name][1]}

    def definition(self, msgtype: str) -> Definition:
        """Return the definition of a type: the bag's, else Jazzy's, else the installed one.

        Raises:
            BagError: There is none of these.
        """
        known = self._definitions.get(msgtype)
        if known is None and msgtype in self._store.fielddefs:
            text, _ = self._store.generate_msgdef(msgtype, ros_version=2)
            known = Definition("ros2msg", text, _digest(self._store, msgtype))
        if known is None:
            known = installed_definition(msgtype)
        self._definitions[msgtype] = known
        return known

    def _layout(self, msgtype: str) -> Msgdef[Any]:
        """Return how a type is read and written."""
        if msgtype not in self._store.fielddefs:
            self._take_in_installed(msgtype)
        try:
            return self._store.get_msgdef(msgtype)
        except Exception as error:  # generated code: a nested type is missing or recursive
            raise BagError(f"message type {msgtype!r} is described badly: {error!r}") from error

    def _take_in_installed(self, msgtype: str) -> None:
        own: dict[str, Any] = {}
        with contextlib.suppress(BagError):
            self._take_in(msgtype, installed_definition(msgtype), own)
            self._register(own)
        if msgtype not in self._store.fielddefs:
            raise BagError(
                f"message type {msgtype!r} is neither described by the bag nor part of ROS 2 "
                "Jazzy nor installed: its messages can be copied but not decoded"
            )

    def _take_in(self, msgtype: str, definition: Definition, own: dict[str, Any]) -> None:
        try:
            parsed = _parse(msgtype, definition)
        except Exception as error:  # any text at all can stand in a damaged bag
            reason = " ".join(str(error).split())[:120]
            self.problems.append(f"the definition of {msgtype} is not understood: {reason}")
            return
        if msgtype not in parsed:
            self.problems.append(f"the definition of {msgtype} describes other types instead")
        for name, fields in parsed.items():
            if name in own and own[name][1] != fields[1]:
                self.problems.append(f"type {name} is described in two ways; the first is used")
            own.setdefault(name, fields)

    def _register(self, own: dict[str, Any]) -> None:
        """Add types to the store; those that differ from Jazzy's replace them."""
        known = self._store.fielddefs
        for name, described in own.items():
            if _same(known.get(name), described):
                continue
            missing = [each for each in _nested(described) if each not in {**known, **own}]
            if missing:
                self.problems.append(f"type {name} is not usable: {missing[0]} is not described")
                continue
            replaced = known.pop(name, None)
            try:
                self._store.register({name: described})
            except (TypesysError, SyntaxError, ValueError) as error:
                self.problems.append(f"type {name} is not usable as described: {error}")
                if replaced is not None:
                    known[name] = replaced


@cache
def jazzy_types() -> BagTypes:
    """Return the types of ROS 2 Jazzy, and those that are installed."""
    return BagTypes()


def serialize(message: object) -> bytes:
    """Return the CDR bytes of a message, the same in every run: see :meth:`BagTypes.serialize`.

    Args:
        message: A message of rclpy, or one of rosbags' dataclasses, such as
            ``jazzy_types().message_class(...)`` makes.

    Raises:
        BagError: Its type is neither one of Jazzy's nor installed.
        MessageError: A field holds what its type cannot.
    """
    return jazzy_types().serialize(message)


def _parse(msgtype: str, definition: Definition) -> dict[str, Any]:
    if definition.encoding == "ros2msg":
        return dict(get_types_from_msg(definition.text, msgtype))
    if definition.encoding != "ros2idl":
        raise TypesysError(f"encoding {definition.encoding!r} is neither ros2msg nor ros2idl")
    parsed: dict[str, Any] = {}
    for part in definition.text.split(_SEPARATOR):
        if part.strip():
            head, _, body = part.partition("\n")
            parsed.update(get_types_from_idl(body if head.startswith("IDL: ") else part))
    return parsed


def _same(known: Any, other: Any) -> bool:
    """Return whether two definitions have the same fields; case as rosbags compares it."""
    if known is None:
        return False
    return [(name.lower(), each) for name, each in known[1]] == [
        (name.lower(), each) for name, each in other[1]
    ]


def _empty_arrays(message: Any) -> int:
    """Count the arrays without elements in a message and in those in it."""
    count = 0
    for name in message.__dataclass_fields__:
        value = getattr(message, name)
        if isinstance(value, list | np.ndarray):
            count += len(value) == 0
            values = value if isinstance(value, list) else []
        else:
            values = [value]
        count += sum(_empty_arrays(each) for each in values if hasattr(each, "__msgtype__"))
    return count


def _digest(store: Typestore, msgtype: str) -> str:
    """Return the RIHS01 hash of a type: rosidl takes a char for a uint8, rosbags does not."""
    translated = Typestore()
    for name, (constants, fields) in store.fielddefs.items():
        translated.fielddefs[name] = (constants, [(each, _rosidl(kind)) for each, kind in fields])
    return translated.hash_rihs01(msgtype)


def _rosidl(described: Any) -> Any:
    if isinstance(described, tuple):
        return tuple(_rosidl(each) for each in described)
    return "uint8" if described == "char" else described


def _nested(described: Any) -> list[str]:
    """Return the message types in the fields of a type."""
    fields = [_field_type(each) for _, each in described[1]]
    return [field.name for field in fields if field.is_message]


def _field_type(described: Any) -> FieldType:
    kind, what = described
    if kind == Nodetype.NAME:
        return FieldType(what)
    if kind == Nodetype.BASE:
        name = what[0]
        return FieldType("uint8" if name in {"byte", "char"} else name)
    element, size = what
    return FieldType(_field_type(element).name, True, size or None, kind == Nodetype.ARRAY)
