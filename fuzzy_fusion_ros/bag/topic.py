# SPDX-License-Identifier: Apache-2.0
"""What a bag holds: topics, their definitions, and messages."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from rosbags.interfaces import Qos


MSG_ENCODINGS = frozenset({"ros2msg"})
IDL_ENCODINGS = frozenset({"ros2idl", "omgidl"})


MOST_TOPICS = 10_000
"""Topics of a storage file; one with more is refused."""


class Definition(NamedTuple):
    """The definition of a message type as a bag carries it.

    Attributes:
        encoding: ``ros2msg`` or ``ros2idl``; any other one cannot be parsed. Recorders that do not
            know a type leave it empty or write ``unknown``.
        text: The definition, followed by those of all nested types.
        digest: The type's RIHS01 hash; empty where it is not known.
    """

    encoding: str
    text: str
    digest: str = ""


UNDESCRIBED = Definition("", "")
"""Of a type that nobody describes; other readers of bags take it too."""


class Topic(NamedTuple):
    """A topic in a bag.

    Attributes:
        name: Such as ``/s1``.
        msgtype: ``package/msg/Type``.
        message_count: Messages on it; None where the bag does not say.
        definition: The type's definition; None where bags of this kind have none.
        qos: The profiles it was offered with.
        encoding: How its messages are serialised; always ``cdr`` in rosbag2.
        other_types: Further types of which there are messages on it.
    """

    name: str
    msgtype: str
    message_count: int | None = None
    definition: Definition | None = None
    qos: tuple[Qos, ...] = ()
    encoding: str = "cdr"
    other_types: tuple[str, ...] = ()

    @property
    def obstacle(self) -> str:
        """Why no number can be read from its messages; empty if one can."""
        if self.other_types:
            types = " and ".join((self.msgtype, *self.other_types))
            return f"its messages are of {1 + len(self.other_types)} types, {types}"
        if self.encoding != "cdr":
            return f"its messages are serialised as {self.encoding!r}, only 'cdr' can be read"
        if not self.msgtype:
            return "its messages are 'cdr', but the bag does not name their type"
        known = MSG_ENCODINGS | IDL_ENCODINGS
        if self.definition is not None and self.definition.encoding not in known:
            return (
                f"its messages are 'cdr', but their type {self.msgtype} is described as "
                f"{self.definition.encoding!r}, only 'ros2msg' and 'ros2idl' can be read"
            )
        return ""


class BagMessage(NamedTuple):
    """A message in a bag, still serialised.

    Attributes:
        topic: The topic's name.
        msgtype: ``package/msg/Type``.
        log_ns: When it was recorded, ns since the epoch; used only for ordering.
        data: CDR with its encapsulation header.
    """

    topic: str
    msgtype: str
    log_ns: int
    data: bytes
