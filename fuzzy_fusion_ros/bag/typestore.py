# SPDX-License-Identifier: Apache-2.0
"""Message types of a bag: what fields they have, and how they are defined."""

from __future__ import annotations

import contextlib
from collections import defaultdict
from collections.abc import Iterable, Mapping
from functools import cache
from typing import Any

from rosbags.typesys import Stores
from rosbags.typesys import get_typestore as _get_typestore
from rosbags.typesys.store import Typestore

from fuzzy_fusion_ros.bag.definitions import UNPARSED, field_types, parse
from fuzzy_fusion_ros.bag.installed import installed_definition
from fuzzy_fusion_ros.bag.topic import Definition, Topic
from fuzzy_fusion_ros.messages.type_fields import FieldType
from fuzzy_fusion_ros.parameters.errors import BagError, MessageError


class BagTypes:
    """The message types that a bag describes, those of ROS 2 Jazzy, and the installed ones.

    What a bag says about a type holds for its messages, even where Jazzy's type of that name
    differs. A definition is parsed when its type is first asked for.

    Attributes:
        problems: One line per definition that cannot be used, of those parsed so far.
    """

    def __init__(self, topics: Iterable[Topic] = ()) -> None:
        """Collect the definitions of topics."""
        self.problems: list[str] = []
        self._jazzy = _get_typestore(Stores.ROS2_JAZZY)
        self._unparsed: dict[str, list[Definition]] = defaultdict(list)
        self._definitions: dict[str, Definition] = {}
        self._fields: dict[str, Mapping[str, FieldType]] = {}
        self._refused: dict[str, str] = {}
        for topic in topics:
            if topic.definition is not None:
                self._definitions.setdefault(topic.msgtype, topic.definition)
                if topic.definition not in self._unparsed[topic.msgtype]:
                    self._unparsed[topic.msgtype].append(topic.definition)

    def fields(self, type_name: str) -> Mapping[str, FieldType]:
        """Return the fields of a type in their order.

        Raises:
            MessageError: The type is not known.
        """
        for definition in self._unparsed.pop(type_name, ()):
            self._parse(type_name, definition)
        if type_name not in self._fields and type_name in self._jazzy.fielddefs:
            self._fields[type_name] = field_types(self._jazzy.fielddefs[type_name])
        if type_name not in self._fields:
            with contextlib.suppress(BagError):
                self._parse(type_name, installed_definition(type_name))
        if type_name not in self._fields:
            refused = self._refused.get(type_name)
            raise MessageError(
                refused
                or f"message type {type_name!r} is neither described by the bag nor installed: "
                "source the package that defines it"
            )
        return self._fields[type_name]

    def definition(self, msgtype: str) -> Definition:
        """Return the definition of a type: the bag's, else Jazzy's, else the installed one.

        Raises:
            BagError: There is none of these.
        """
        known = self._definitions.get(msgtype)
        if known is None and msgtype in self._jazzy.fielddefs:
            text, _ = self._jazzy.generate_msgdef(msgtype, ros_version=2)
            known = Definition("ros2msg", text, _digest(self._jazzy, msgtype))
        if known is None:
            known = installed_definition(msgtype)
        self._definitions[msgtype] = known
        return known

    def _parse(self, msgtype: str, definition: Definition) -> None:
        """Add the types that a definition describes, or say why it cannot be used."""
        try:
            parsed = parse(msgtype, definition)
        except UNPARSED as error:
            reason = " ".join(str(error).split())[:120]
            self._refused[msgtype] = f"the definition of {msgtype} cannot be parsed: {reason}"
            self.problems.append(self._refused[msgtype])
            return
        if msgtype not in parsed:
            self.problems.append(f"the definition of {msgtype} describes other types instead")
        for name, fields in parsed.items():
            if self._fields.setdefault(name, fields) != fields:
                self.problems.append(f"type {name} has two definitions; using the first")


@cache
def jazzy_types() -> BagTypes:
    """Return the types of ROS 2 Jazzy, and those that are installed."""
    return BagTypes()


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
