"""Message types of a bag: between serialised bytes and rosbags' dataclasses."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import cache
from typing import Any

from rosbags.interfaces import Nodetype
from rosbags.serde import SerdeError
from rosbags.typesys import Stores, TypesysError, get_types_from_idl, get_types_from_msg
from rosbags.typesys import get_typestore as _get_typestore

from fuzzy_fusion_ros.bag.installed import installed_definition
from fuzzy_fusion_ros.bag.topic import Definition, Topic
from fuzzy_fusion_ros.core.errors import BagError, MessageError
from fuzzy_fusion_ros.messages.type_fields import FieldType

_SEPARATOR = "=" * 80 + "\n"


class BagTypes:
    """The message types that a bag describes, and those of ROS 2 Jazzy.

    What a bag says about a type holds for its messages, even if Jazzy's type of that name
    differs. A type that neither describes is looked up among the installed ones when its
    definition is asked for.

    Attributes:
        problems: One line per definition that cannot be used.
    """

    def __init__(self, topics: Iterable[Topic] = ()) -> None:
        """Read the definitions of topics, nested types included."""
        self.problems: list[str] = []
        self._definitions: dict[str, Definition] = {}
        self._store = _get_typestore(Stores.ROS2_JAZZY)
        own: dict[str, Any] = {}
        for topic in topics:
            if topic.definition is not None and topic.msgtype not in self._definitions:
                self._definitions[topic.msgtype] = topic.definition
                self._take_in(topic.msgtype, topic.definition, own)
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
        self._require(msgtype)
        try:
            return self._store.deserialize_cdr(data, msgtype)
        except SerdeError as error:
            raise MessageError(f"a message is no {msgtype}: {error}") from error
        except (IndexError, OverflowError, MemoryError) as error:
            raise MessageError(f"a message is no {msgtype}: it ends too early") from error

    def serialize(self, message: object) -> bytes:
        """Return the CDR bytes of one of rosbags' dataclasses, the same that rclpy gives.

        Raises:
            MessageError: It is no such message, or a field holds what its type cannot.
        """
        msgtype = getattr(message, "__msgtype__", None)
        if not isinstance(msgtype, str) or msgtype not in self._store.fielddefs:
            raise MessageError(f"{type(message).__name__} is no message type of this bag")
        try:
            return bytes(self._store.serialize_cdr(message, msgtype, little_endian=True))
        except Exception as error:  # generated code: any error means that a value does not fit
            raise MessageError(f"{msgtype} cannot be serialised: {error}") from error

    def message_class(self, msgtype: str) -> Any:
        """Return the dataclass of a type.

        Raises:
            BagError: The type is not known.
        """
        self._require(msgtype)
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
            known = Definition("ros2msg", text, self._store.hash_rihs01(msgtype))
        if known is None:
            known = installed_definition(msgtype)
        self._definitions[msgtype] = known
        return known

    def _require(self, msgtype: str) -> None:
        """Make sure that a type can be decoded."""
        if msgtype in self._store.cache:
            return
        if msgtype not in self._store.fielddefs:
            raise BagError(
                f"message type {msgtype!r} is neither described by the bag nor part of ROS 2 "
                "Jazzy: its messages can be copied but not decoded"
            )
        try:
            self._store.get_msgdef(msgtype)
        except Exception as error:  # generated code: a nested type is missing or recursive
            raise BagError(f"message type {msgtype!r} is described badly: {error!r}") from error

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
            replaced = known.pop(name, None)
            try:
                self._store.register({name: described})
            except (TypesysError, SyntaxError, ValueError) as error:
                self.problems.append(f"type {name} is not usable as described: {error}")
                if replaced is not None:
                    known[name] = replaced


@cache
def jazzy_types() -> BagTypes:
    """Return the types of ROS 2 Jazzy alone."""
    return BagTypes()


def serialize(message: object) -> bytes:
    """Return the CDR bytes of a message of one of Jazzy's types, the same that rclpy gives.

    Args:
        message: One of rosbags' dataclasses, such as ``jazzy_types().message_class(...)`` makes.

    Raises:
        MessageError: It is no such message, or a field holds what its type cannot.
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


def _field_type(described: Any) -> FieldType:
    kind, what = described
    if kind == Nodetype.NAME:
        return FieldType(what)
    if kind == Nodetype.BASE:
        name = what[0]
        return FieldType("uint8" if name in {"byte", "char"} else name)
    element, size = what
    return FieldType(_field_type(element).name, True, size or None)
