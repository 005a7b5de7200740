# SPDX-License-Identifier: Apache-2.0
"""Large bags to replay: what pendulum_node records, without the estimate, at 100 Hz."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from pathlib import Path

from fuzzy_fusion_ros.bag import BagWriter, jazzy_types
from fuzzy_fusion_ros.core.numerics import SECOND_NS
from fuzzy_fusion_ros.messages.cdr import CdrWriter
from fuzzy_fusion_ros.messages.outputs import POINT, point_template

STEP_NS = 10_000_000
JOINTS = "sensor_msgs/msg/JointState"

Topics = Sequence[tuple[str, str, int]]
"""Topics, their types, and every how many steps there is a message."""

RECORDING: Topics = (
    ("/truth", POINT, 1),
    ("/joint_states", JOINTS, 1),
    ("/s2", POINT, 1),
    ("/s1", POINT, 1),
    ("/control", POINT, 1),
)
SENSORS: Topics = (("/s2", POINT, 10), ("/s1", POINT, 1))


def write_bag(path: Path, messages: int, topics: Topics) -> None:
    """Write a bag.

    Args:
        path: Its directory.
        messages: How many messages, over all topics.
        topics: What is in it.
    """
    point = point_template(jazzy_types())
    due = (
        (step, topic, kind)
        for step in itertools.count()
        for topic, kind, every in topics
        if step % every == 0
    )
    with BagWriter(path) as writer:
        for step, topic, kind in itertools.islice(due, messages):
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
