# SPDX-License-Identifier: Apache-2.0
"""Which topic plays which role, and where its number is."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING, NamedTuple

from fuzzy_fusion_ros.messages import ScalarCodec
from fuzzy_fusion_ros.parameters.errors import BagError, MessageError
from fuzzy_fusion_ros.parameters.fusion import Parameters, SensorParameters

if TYPE_CHECKING:
    from fuzzy_fusion_ros.bag.reader import BagReader  # takes time to import

NODE = "fusion_node"
ROLES = ("s1", "s2", "estimate", "truth")


class Topics(NamedTuple):
    """The topics that are read.

    Attributes:
        s1: Topic of S1.
        s2: Topic of S2.
        estimate: Topic of the estimate.
        truth: Topic of the truth.
        fields: Paths of the numbers by role; ``""`` stands for every topic whose type has it.
        channel: The channel of the parameters to use, ``""`` for the only one, or for all.
    """

    s1: str = "/s1"
    s2: str = "/s2"
    estimate: str = "/estimate"
    truth: str = "/truth"
    fields: Mapping[str, str] = MappingProxyType({})
    channel: str = ""

    def found_in(self, bag: BagReader) -> Topics:
        """Return the topics as a bag spells them, with or without the leading slash."""
        s1, s2, estimate, truth = map(bag.name_of, self.by_role().values())
        return self._replace(s1=s1, s2=s2, estimate=estimate, truth=truth)

    def by_role(self) -> dict[str, str]:
        """Return the topic of each role."""
        return {role: getattr(self, role) for role in ROLES}

    def require_in(self, bag: BagReader, *roles: str) -> None:
        """Check that the topics of some roles, S1 and S2 unless given, are in a bag.

        Raises:
            BagError: One is not; the error lists the bag's topics and names the options to give.
        """
        by_role = self.by_role()
        missing = [role for role in roles or ("s1", "s2") if by_role[role] not in bag.topics]
        try:
            bag.require_topics(*(by_role[role] for role in missing))
        except BagError as error:
            options = " and ".join(f"--{role}" for role in missing)
            raise BagError(f"{error}; give {options}" if bag.topics else str(error)) from None


def explanation_prefix(estimate: str, channel: str = "") -> str:
    """Return where the node's own topics are: in the namespace of its estimate, below its name.

    Args:
        estimate: The topic of the estimate.
        channel: The channel, ``""`` where it has no name.
    """
    own = f"{estimate.rpartition('/')[0]}/{NODE}/"
    return f"{own}{channel}/" if channel else own


def explanation_topics(bag: BagReader, estimate: str) -> list[str]:
    """Return the topics of a bag that explain its estimates, those of all channels."""
    from fuzzy_fusion_ros.messages.outputs import EXPLANATION, SENTENCE  # takes time to import

    own = explanation_prefix(estimate)
    names = {*EXPLANATION, SENTENCE}
    return [
        each for each in bag.topics if each.startswith(own) and each.rpartition("/")[2] in names
    ]


def codecs_of(
    bag: BagReader, topics: Topics, parameters: Parameters, roles: Sequence[str] = ROLES
) -> dict[str, ScalarCodec]:
    """Return what reads the samples of each role whose topic the bag has.

    A path in ``topics`` comes before one in ``parameters``, and that before the type's own.

    Args:
        bag: The bag.
        topics: The topics of the roles.
        parameters: Of the fusion.
        roles: Those that matter.

    Raises:
        BagError: No number can be read from a topic.
        MessageError: A path is not in its type, or the one for all is in none of the types, or
            there is none and the type has no default.
    """
    configured = {
        "s1": parameters.s1.field,
        "s2": parameters.s2.field,
        "estimate": parameters.estimate.field or parameters.s2.field,
        "truth": "",
    }
    sensors = {"s1": parameters.s1, "s2": parameters.s2}
    codecs = {
        role: codec_of(
            bag,
            topic,
            topics.fields.get(role, ""),
            topics.fields.get("", ""),
            configured[role],
            sensors.get(role),
        )
        for role, topic in topics.by_role().items()
        if role in roles and topic in bag.topics
    }
    _require_common(bag, topics)
    if _is_written_back(codecs, parameters):
        own, s2 = codecs["estimate"], parameters.s2
        codecs["estimate"] = ScalarCodec(
            bag.types, own.type_name, own.field.text, s2.scale, s2.offset
        )
    return codecs


def _is_written_back(codecs: Mapping[str, ScalarCodec], parameters: Parameters) -> bool:
    """Return whether the estimate is in S2's place in its message, and in its unit."""
    if parameters.estimate.field or not {"s2", "estimate"} <= codecs.keys():
        return False
    estimate, s2 = codecs["estimate"], codecs["s2"]
    return (estimate.type_name, estimate.field.text) == (s2.type_name, s2.field.text)


def _require_common(bag: BagReader, topics: Topics) -> None:
    """Refuse a path for all that fits none: it is misspelt."""
    common = topics.fields.get("", "")
    problems = []
    for topic in topics.by_role().values() if common else ():
        try:
            if topic in bag.topics:
                ScalarCodec(bag.types, bag.topics[topic].msgtype, common)
                return
        except MessageError as error:
            problems.append(f"topic {topic}: {error}")
    if problems:
        raise MessageError(problems[0])


def codec_of(
    bag: BagReader,
    topic: str,
    own: str = "",
    common: str = "",
    configured: str = "",
    sensor: SensorParameters | None = None,
) -> ScalarCodec:
    """Return what reads the samples of a topic.

    Args:
        bag: The bag, which has the topic.
        topic: The topic.
        own: The path of its number, where the user gave one for it.
        common: The path given for every topic whose type has it.
        configured: The path in the fusion's parameters.
        sensor: Scale and offset; the field as it is unless given.

    Raises:
        BagError: No number can be read from the topic.
        MessageError: A path is not in its type, or there is none and the type has no default.
    """
    bag.require_readable(topic)
    msgtype = bag.topics[topic].msgtype
    scale, offset = (1.0, 0.0) if sensor is None else (sensor.scale, sensor.offset)
    problems = []
    for text in [own] if own else [common, configured, ""] if common else [configured]:
        try:
            return ScalarCodec(bag.types, msgtype, text, scale, offset)
        except MessageError as error:
            problems.append(error)
    raise MessageError(f"topic {topic}: {problems[0]}")


def unstamped(topics: Topics, codecs: Mapping[str, ScalarCodec]) -> list[str]:
    """Return a line for each topic whose messages have no timestamp.

    Args:
        topics: The topics of the roles.
        codecs: What reads the messages of some roles.
    """
    names = topics.by_role()
    return [
        f"{names[role]}: {codec.type_name} has no timestamp; using the log time, so transport "
        "delay will look like motion"
        for role, codec in codecs.items()
        if not codec.is_stamped
    ]
