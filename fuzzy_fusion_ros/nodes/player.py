# SPDX-License-Identifier: Apache-2.0
"""Plays recorded messages onto topics, bytes unchanged, with /clock."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import NamedTuple

from rclpy.context import Context
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rosgraph_msgs.msg import Clock

from fuzzy_fusion_ros.bag.topic import BagMessage, Topic
from fuzzy_fusion_ros.core.numerics import SECOND_NS
from fuzzy_fusion_ros.messages import load_message_class
from fuzzy_fusion_ros.parameters.errors import FusionError, MessageError
from fuzzy_fusion_ros.ros.process import Stop

CLOCK = "/clock"
LONGEST_SLEEP = 0.05
"""Seconds between looks at signals, and between clock messages in a silence."""

SETTLED = 0.5
"""Time for subscribers that are discovered to discover this node as well, seconds."""

LEISURE, HASTE = 2.0, 0.3
"""Longest wait for reliable subscribers at the end, and when asked to stop, seconds."""

DEEP = 100
"""Fewest messages kept for a slow reliable subscriber."""


class PlayerError(FusionError):
    """Nothing can be played."""


class Played(NamedTuple):
    """What was played.

    Attributes:
        messages: Messages published, /clock left out.
        loops: How often it has come to the end.
        notes: What was left out, and why, one line each.
    """

    messages: int
    loops: int
    notes: tuple[str, ...]


def play(
    topics: Iterable[Topic],
    read: Callable[[], Iterator[BagMessage]],
    awaited: Sequence[str],
    *,
    rate: float = 1.0,
    loop: bool = False,
    patience: float = 10.0,
    domain_id: int | None = None,
) -> Played:
    """Play messages in their rhythm until they end, or SIGINT or SIGTERM come.

    Args:
        topics: The topics of the recording.
        read: Begins to read the recording, in log order; called once a loop.
        awaited: Topics that must have a subscriber before it starts.
        rate: Seconds of the recording per second.
        loop: Whether to begin again at the end; the clock jumps back then.
        patience: How long to wait for subscribers, seconds; then it starts without.
        domain_id: The DDS domain; that of the environment unless given.

    Raises:
        PlayerError: No type of the recording is installed.
        KeyboardInterrupt: SIGINT or SIGTERM came before it started.
    """
    with Stop() as stop:
        stop.in_order()
        context = Context()
        context.init([], domain_id=domain_id)
        try:
            player = _Player(context, topics, stop)
            try:
                player.wait_for(awaited, patience)
                player.run(read, rate, loop)
                return player.result()
            finally:
                player.destroy_node()
        finally:
            context.try_shutdown()


class _Player(Node):
    """The node that publishes."""

    def __init__(self, context: Context, topics: Iterable[Topic], stop: Stop) -> None:
        super().__init__("player", context=context)
        self._stop = stop
        self._notes: list[str] = []
        self._outputs: dict[str, Publisher] = {}
        self._messages = 0
        self._loops = 0
        for topic in topics:
            if topic.name != CLOCK:
                self._offer(topic)
        if not self._outputs:
            raise PlayerError(f"nothing can be played: {'; '.join(self._notes) or 'no topics'}")
        self._clock_publisher = self.create_publisher(Clock, CLOCK, QoSProfile(depth=1))
        self._time_ns = -1

    def _offer(self, topic: Topic) -> None:
        if topic.encoding != "cdr" or topic.other_types:
            self._notes.append(f"{topic.name} is skipped: {topic.obstacle}")
            return
        try:
            message_class = load_message_class(topic.msgtype)
        except MessageError as error:
            self._notes.append(f"{topic.name} is skipped: {error}")
            return
        self._outputs[topic.name] = self.create_publisher(
            message_class, topic.name, _profile(topic)
        )

    def wait_for(self, topics: Sequence[str], patience: float) -> None:
        """Wait until all have subscribers that know us too.

        Raises:
            KeyboardInterrupt: It is to stop.
        """
        deadline = time.monotonic() + patience
        while missing := [each for each in topics if self._unheard(each)]:
            silence = f"nobody subscribes to {', '.join(missing)}"
            if self._stop.wanted:
                raise KeyboardInterrupt(silence)
            if time.monotonic() > deadline:
                self._notes.append(silence)
                return
            time.sleep(LONGEST_SLEEP)
        self._sleep_until(time.monotonic() + SETTLED)

    def _unheard(self, topic: str) -> bool:
        return topic in self._outputs and self._outputs[topic].get_subscription_count() == 0

    def run(self, read: Callable[[], Iterator[BagMessage]], rate: float, loop: bool) -> None:
        """Publish the recording once, or again and again."""
        while not self._stop.wanted:
            before = self._messages
            self._once(read(), rate)
            if not loop or self._messages == before:
                break

    def _once(self, messages: Iterator[BagMessage], rate: float) -> None:
        begun: tuple[float, int] | None = None
        for message in messages:
            publisher = self._outputs.get(message.topic)
            if publisher is None:
                continue
            if begun is None:
                begun = time.monotonic(), message.log_ns
            self._advance_to(message.log_ns, *begun, rate)
            if self._stop.wanted:
                return
            self._tell_time(message.log_ns)
            publisher.publish(message.data)
            self._messages += 1
        self._loops += 1

    def _advance_to(self, log_ns: int, begun: float, first_ns: int, rate: float) -> None:
        """Wait until a message is due; the clock keeps running."""
        due = begun + (log_ns - first_ns) / SECOND_NS / rate
        while not self._stop.wanted and (left := due - time.monotonic()) > 0.0:
            time.sleep(min(left, LONGEST_SLEEP))
            now_ns = first_ns + round((time.monotonic() - begun) * rate * SECOND_NS)
            self._tell_time(min(now_ns, log_ns))

    def _tell_time(self, time_ns: int) -> None:
        if time_ns == self._time_ns:
            return
        self._time_ns = time_ns
        message = Clock()
        message.clock.sec, message.clock.nanosec = divmod(time_ns, SECOND_NS)
        self._clock_publisher.publish(message)

    def _sleep_until(self, moment: float) -> None:
        while not self._stop.wanted and (left := moment - time.monotonic()) > 0.0:
            time.sleep(min(left, LONGEST_SLEEP))

    def result(self) -> Played:
        """Return what was played."""
        return Played(self._messages, self._loops, tuple(self._notes))

    def destroy_node(self) -> None:
        """Leave the graph once reliable subscribers have all, or do not take it."""
        deadline = time.monotonic() + (HASTE if self._stop.wanted else LEISURE)
        for publisher in self._outputs.values():
            left = max(deadline - time.monotonic(), 0.0)
            publisher.wait_for_all_acked(Duration(seconds=left))
        Node.destroy_node(self)


def _profile(topic: Topic) -> QoSProfile:
    """Return the profile that a topic was offered with, as far as it decides who can listen."""
    offered = topic.qos[0] if topic.qos else None
    profile = QoSProfile(depth=DEEP)
    if offered is not None:
        profile.depth = max(offered.depth, DEEP)
        if offered.reliability.name == "BEST_EFFORT":
            profile.reliability = ReliabilityPolicy.BEST_EFFORT
        if offered.durability.name == "TRANSIENT_LOCAL":
            profile.durability = DurabilityPolicy.TRANSIENT_LOCAL
    return profile
