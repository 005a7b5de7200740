# SPDX-License-Identifier: Apache-2.0
"""Why the estimate at a time in a bag is what it is."""

from __future__ import annotations

from fuzzy_fusion_ros.bag.reader import BagReader
from fuzzy_fusion_ros.offline.bag_fusion import BagFusion, Logged
from fuzzy_fusion_ros.offline.topics import Topics
from fuzzy_fusion_ros.parameters.errors import BagError
from fuzzy_fusion_ros.parameters.fusion import Parameters


def estimate_at(
    bag: BagReader, topics: Topics, parameters: Parameters, at_s: float
) -> tuple[Logged, str]:
    """Return the newest estimate at a time, as a node makes it from the bag's first message on.

    Args:
        bag: The bag; S1 and S2 must be in it.
        topics: Where S1 and S2 are.
        parameters: Of the fusion.
        at_s: The time, seconds from the bag's first message.

    Returns:
        The estimate, and its unit where a parameter or a type states it.

    Raises:
        BagError: S1 or S2 is not in the bag, it ends before that time, or there is no estimate yet.
        MessageError: A field is not in its type.
    """
    topics = topics.found_in(bag)
    topics.require_in(bag)
    bag.require_messages_from(at_s)
    fusion = BagFusion(bag, topics, parameters)
    at_ns = (bag.start_ns or 0) + round(at_s * 1e9)
    newest = None
    for message in bag.messages([topics.s1, topics.s2]):
        for logged in fusion.before(min(message.log_ns, at_ns)):
            newest = logged
        if message.log_ns > at_ns:
            break
        for logged in fusion.on_message(message):
            newest = logged
    if newest is None:
        why = "; ".join([*fusion.notes(), *bag.problems]) or "S1 or S2 has no sample yet"
        raise BagError(f"bag {str(bag.path)!r} gives no estimate by {at_s:g} s: {why}")
    return newest, fusion.unit
