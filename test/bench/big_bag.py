# SPDX-License-Identifier: Apache-2.0
"""Large bags to replay: what pendulum_node records, without the estimate, at 100 Hz."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

from fuzzy_fusion_ros.bag import BagWriter, jazzy_types
from fuzzy_fusion_ros.core.numerics import SECOND_NS
from fuzzy_fusion_ros.messages.cdr import CdrWriter
from fuzzy_fusion_ros.messages.outputs import POINT, point_template

STEP_NS = 10_000_000
JOINTS = "sensor_msgs/msg/JointState"

RECORDING = (
    ("/truth", POINT),
    ("/joint_states", JOINTS),
    ("/s2", POINT),
    ("/s1", POINT),
    ("/control", POINT),
)
SENSORS = (("/s2", POINT), ("/s1", POINT))


def write_bag(path: Path, messages: int, topics: Sequence[tuple[str, str]]) -> None:
    """Write a bag.

    Args:
        path: Its directory.
        messages: How many messages, over all topics.
        topics: Its topics and their types, one message of each per step.
    """
    point = point_template(jazzy_types())
    with BagWriter(path) as writer:
        for k in range(messages):
            step, at = divmod(k, len(topics))
            topic, kind = topics[at]
            stamp_ns = SECOND_NS + step * STEP_NS
            if kind == POINT:
                wobble = 0.05 * math.sin(1.7 * step * step) if topic == "/s1" else 0.0
                data = point.filled(0.3 * math.sin(0.05 * step) + wobble, stamp_ns)
            else:
                data = _joint_state(stamp_ns)
            writer.write(topic, kind, stamp_ns, data)


def _joint_state(stamp_ns: int) -> bytes:
    writer = CdrWriter().stamp(stamp_ns).text("").count(1).text("pole")
    return writer.count(1).number("float64", 0.1).count(1).number("float64", 0.1).count(0).done()
