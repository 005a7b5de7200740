"""What a bag holds: topics, their definitions, and messages."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from rosbags.interfaces import Qos


class Definition(NamedTuple):
    """The definition of a message type as a bag carries it.

    Attributes:
        encoding: ``ros2msg`` or ``ros2idl``.
        text: The definition, followed by those of all nested types.
        digest: The type's RIHS01 hash; empty where it is not known.
    """

    encoding: str
    text: str
    digest: str = ""


class Topic(NamedTuple):
    """A topic in a bag.

    Attributes:
        name: Such as ``/s1``.
        msgtype: ``package/msg/Type``.
        message_count: Messages on it; None where the bag does not say.
        definition: The type's definition; None where the bag has none.
        qos: The profiles it was offered with.
        encoding: How its messages are serialised; always ``cdr`` in rosbag2.
    """

    name: str
    msgtype: str
    message_count: int | None = None
    definition: Definition | None = None
    qos: tuple[Qos, ...] = ()
    encoding: str = "cdr"


class BagMessage(NamedTuple):
    """A message in a bag, still serialised.

    Attributes:
        topic: The topic's name.
        msgtype: ``package/msg/Type``.
        log_ns: When it was recorded, ns since the epoch; it only orders.
        data: CDR with its encapsulation header.
    """

    topic: str
    msgtype: str
    log_ns: int
    data: bytes
