# SPDX-License-Identifier: Apache-2.0
"""Uses the types of a workspace that has been sourced: JOB OPTIONS, both of which see below.

Run by ``interface_workspace.py`` as a process of its own, as types can only be imported where their
workspace was sourced before Python started. Prints its result as JSON.
"""

from __future__ import annotations

import itertools
import json
import signal
import sys
from collections.abc import Sequence, Sized
from functools import partial
from typing import Any

from fuzzy_fusion_ros.messages import load_message_class
from fuzzy_fusion_ros.ros.qos import ESTIMATE
from fuzzy_fusion_ros.testing import Harness, Process

Samples = list[tuple[int, float]]
"""Stamp, nanoseconds, and value."""


def message(type_name: str, stamp_ns: int, value: float) -> Any:
    """Return a message of either type."""
    made = load_message_class(type_name)()
    stamp = made.header.stamp if hasattr(made, "header") else made.stamp
    stamp.sec, stamp.nanosec = divmod(stamp_ns, 10**9)
    setattr(made, "value" if hasattr(made, "header") else "data", value)
    return made


def sample(message: Any) -> tuple[int, float]:
    """Return the stamp and the number of a message of either type, or of a PointStamped."""
    stamp = message.header.stamp if hasattr(message, "header") else message.stamp
    if hasattr(message, "point"):
        value = message.point.x
    else:
        value = message.value if hasattr(message, "header") else message.data
    return stamp.sec * 10**9 + stamp.nanosec, value


def has_more_than(number: int, things: Sized) -> bool:
    """Return whether there are more things than a number."""
    return len(things) > number


def is_newest(stamp_ns: int, messages: Sequence[Any]) -> bool:
    """Return whether the last message has a stamp."""
    return sample(messages[-1])[0] == stamp_ns


def end(process: Process) -> None:
    """End an executable in good order."""
    process.send(signal.SIGINT)
    assert process.wait() == 0, process.stderr


def fuse(
    s1_type: str, s2_type: str, s1: Samples, s2: Samples, parameters: str, bag: str
) -> dict[str, Any]:
    """Feed ``fusion_node`` pair by pair, each waiting for its estimate, and return the estimates.

    Args:
        s1_type: Type of S1.
        s2_type: Type of S2.
        s1: Samples of S1.
        s2: Samples of S2, as many.
        parameters: A ROS parameter YAML.
        bag: The bag to record to.
    """
    with Harness() as harness:
        process = harness.start(
            "fusion_node", "--ros-args", "--params-file", parameters, "-p", f"record:={bag}"
        )
        first, second = harness.publisher("/s1", s1_type), harness.publisher("/s2", s2_type)
        heard = harness.record("/estimate", s2_type, ESTIMATE)
        harness.spin_until_matched(first, second)
        harness.spin_until(lambda: harness.node.count_publishers("/estimate"))
        names_and_types = dict(harness.node.get_topic_names_and_types())
        for k, (one, other) in enumerate(zip(s1, s2, strict=True)):
            second.publish(message(s2_type, *other))
            first.publish(message(s1_type, *one))
            harness.spin_until(partial(has_more_than, k, heard), f"estimate {k}")
        end(process)
        return {"types": names_and_types["/estimate"], "samples": [sample(each) for each in heard]}


def subscribe(input_type: str, samples: Samples) -> Samples:
    """Feed ``sensor_subscriber`` sample by sample, and return what it publishes of some samples.

    Args:
        input_type: Type of the sensor.
        samples: Its samples, stamped later than 2 s; what is stamped earlier is sent until it is
            known that something arrives.
    """
    early_ns = itertools.count(10**9)
    given = {"input.type": input_type, "qos": "reliable"}
    words = [word for name, value in given.items() for word in ("-p", f"{name}:={value}")]
    with Harness() as harness:
        process = harness.start("sensor_subscriber", "--ros-args", *words)
        sensor = harness.publisher("/input", input_type)
        heard = harness.record("/output")
        harness.spin_until_matched(sensor)

        def is_connected() -> bool:
            sensor.publish(message(input_type, next(early_ns), 0.0))
            return bool(heard)

        harness.spin_until(is_connected, "connected on both sides")
        for stamp_ns, value in samples:
            sensor.publish(message(input_type, stamp_ns, value))
            harness.spin_until(partial(is_newest, stamp_ns, heard), f"the sample of {stamp_ns} ns")
        end(process)
        return [each for each in map(sample, heard) if each[0] >= samples[0][0]]


JOBS = {job.__name__: job for job in (fuse, subscribe)}

if __name__ == "__main__":
    print(json.dumps(JOBS[sys.argv[1]](**json.loads(sys.argv[2]))))
