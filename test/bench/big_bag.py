"""Large bags to replay: what pendulum_node records, without the estimate, at 100 Hz."""

from __future__ import annotations

import math
import struct
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from fuzzy_fusion_ros.bag import BagWriter, jazzy_types
from fuzzy_fusion_ros.bag.blank import blank_message
from fuzzy_fusion_ros.messages.outputs import POINT
from fuzzy_fusion_ros.messages.sample import SECOND_NS

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

_STAMP = struct.Struct("<iI")
_VALUE = struct.Struct("<d")
_POINT_BYTES = 24


def write_bag(path: Path, messages: int, topics: Sequence[tuple[str, str]]) -> None:
    """Write a bag.

    Args:
        path: Its directory.
        messages: How many messages, over all topics.
        topics: Its topics and their types, one message of each per step.
    """
    blank = {kind: _blank(kind) for _, kind in topics}
    with BagWriter(path) as writer:
        for k in range(messages):
            step, at = divmod(k, len(topics))
            topic, kind = topics[at]
            stamp_ns = SECOND_NS + step * STEP_NS
            data = bytearray(blank[kind])
            _STAMP.pack_into(data, 4, *divmod(stamp_ns, SECOND_NS))
            if kind == POINT:
                wobble = 0.05 * math.sin(1.7 * step * step) if topic == "/s1" else 0.0
                value = 0.3 * math.sin(0.05 * step) + wobble
                _VALUE.pack_into(data, len(data) - _POINT_BYTES, value)
            writer.write(topic, kind, stamp_ns, bytes(data))


def _blank(kind: str) -> bytes:
    types = jazzy_types()
    message = blank_message(types, kind)
    if kind == JOINTS:
        message.name = ["pole"]
        message.position = message.velocity = np.array([0.1])
    return types.serialize(message)
