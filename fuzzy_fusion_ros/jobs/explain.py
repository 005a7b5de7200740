# SPDX-License-Identifier: Apache-2.0
"""Explains an estimate in a bag."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

from fuzzy_fusion_ros.bag import open_bag
from fuzzy_fusion_ros.core.numerics import seconds_between
from fuzzy_fusion_ros.jobs.parameter_file import Source, fusion_parameters
from fuzzy_fusion_ros.offline.explain import estimate_at
from fuzzy_fusion_ros.offline.topics import Topics
from fuzzy_fusion_ros.online.explanation import explanation


class Explained(NamedTuple):
    """Why an estimate is what it is.

    Attributes:
        at_s: When it came about, seconds from the bag's first message.
        value: The estimate, unit of the signal.
        text: Why it is what it is, and which parameter would change it.
    """

    at_s: float
    value: float
    text: str


def explain(
    bag: str | Path,
    at: float,
    *,
    parameters: Source = None,
    topics: Topics | None = None,
    unit: str | None = None,
) -> Explained:
    """Explain the newest estimate at a time, as ``fusion_node`` makes it with these parameters.

    Args:
        bag: A rosbag2 directory or an ``.mcap`` file.
        at: The time, seconds from the first message of the bag.
        parameters: Of the fusion, or the YAML file with them; the defaults unless given.
        topics: Where the sensors are; ``/s1`` and ``/s2`` unless given.
        unit: Unit of the signal; unless given, that of the message type, if it has one.

    Raises:
        FusionError: The bag or the parameters cannot be used, or there is no estimate by then.
    """
    wanted = topics or Topics()
    used = fusion_parameters(parameters).channel(wanted.channel)
    with open_bag(bag) as reader:
        (log_ns, fused), own_unit = estimate_at(reader, wanted, used, at)
        at_s = seconds_between(reader.start_ns or log_ns, log_ns)
    text = explanation(used, fused, own_unit if unit is None else unit)
    return Explained(at_s, fused.estimate.value, text)
