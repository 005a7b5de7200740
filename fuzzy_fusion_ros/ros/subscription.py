"""One sensor as a node sees it: any message type in, samples out."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.qos import QoSProfile

from fuzzy_fusion_ros.core.numerics import seconds_between
from fuzzy_fusion_ros.core.sample import Sample
from fuzzy_fusion_ros.messages import InstalledTypes, ScalarCodec, load_message_class
from fuzzy_fusion_ros.online.guard import Drop, Guard
from fuzzy_fusion_ros.parameters.errors import MessageError
from fuzzy_fusion_ros.parameters.fusion import SensorParameters
from fuzzy_fusion_ros.ros.backlog import Backlog
from fuzzy_fusion_ros.ros.clock import NodeTime
from fuzzy_fusion_ros.ros.node import ConfiguredNode
from fuzzy_fusion_ros.ros.qos import OVERRIDABLE, log_unfit_publisher, overridable
from fuzzy_fusion_ros.ros.recorder import Recorder
from fuzzy_fusion_ros.ros.sequence_gaps import SequenceGapCounter, WithNumber


class Received(NamedTuple):
    """A message that came in, and what it says.

    Attributes:
        data: The message, serialised.
        sample: The sample in it, whatever it holds.
        now_ns: Time of receipt on the node's clock, nanoseconds.
        log_ns: The time to record it, and all that follows from it, at.
    """

    data: bytes
    sample: Sample
    now_ns: int
    log_ns: int


class SensorInput:
    """Subscribes to one sensor and hands on a sample per message.

    Attributes:
        topic: The full name of the topic.
        codec: Reads its messages.
        received: Messages that have been taken.
        last_problem: What the last unreadable message lacked; empty if none was.
    """

    def __init__(
        self,
        node: ConfiguredNode[Any],
        node_time: NodeTime,
        topic: str,
        parameters: SensorParameters,
        profile: QoSProfile,
        guard: Guard,
        recorder: Recorder,
        take: Callable[[Received], bool],
        future_tolerance: Callable[[], float],
    ) -> None:
        """Subscribe.

        Args:
            node: The node to subscribe for.
            node_time: Its clocks.
            topic: The topic, remapped or not.
            parameters: Type and field.
            profile: Quality of service.
            guard: Counts the messages without the field or the number asked for.
            recorder: Where messages go, bytes unchanged.
            take: Called with each message and its sample; tells whether the sample was of use.
            future_tolerance: Tells how far stamps may be ahead of the clock, seconds.

        Raises:
            MessageError: The type is not installed or has no such field.
        """
        self.codec = ScalarCodec(InstalledTypes(), parameters.type, parameters.field)
        self.received = 0
        self.last_problem = ""
        self._node = node
        self._time = node_time
        self._heard_ns = node_time.age_ns()
        self._guard = guard
        self._recorder = recorder
        self._take = take
        self._future_tolerance = future_tolerance
        self._warned = False
        self._gaps = SequenceGapCounter()
        self._backlog = Backlog(node, self._on_message)
        events = SubscriptionEventCallbacks(
            incompatible_qos=lambda event: log_unfit_publisher(node, self.topic, profile, event),
            message_lost=self._on_lost,
        )
        with overridable(topic):
            self._subscription = node.create_subscription(
                load_message_class(self.codec.type_name),
                topic,
                WithNumber(node.guarded(self._on_arrival)),
                profile,
                event_callbacks=events,
                qos_overriding_options=OVERRIDABLE,
                raw=True,
            )
        self.topic: str = self._subscription.topic_name
        recorder.add(self.topic, self.codec.type_name, profile)

    @property
    def lost(self) -> int:
        """Messages that were published but never taken."""
        return self._gaps.count + self._backlog.shed

    @property
    def age(self) -> float:
        """Time since the last sample of use came, or since the start, seconds."""
        now_ns = self._time.age_ns()
        if self._heard_ns == 0 or self._heard_ns > now_ns:  # /clock has come, or jumped back
            self._heard_ns = now_ns
        return seconds_between(self._heard_ns, now_ns)

    def other_types(self) -> list[str]:
        """Return the types other than ours that the topic is published as."""
        offers = self._node.get_publishers_info_by_topic(self.topic)
        return sorted({offer.topic_type for offer in offers} - {self.codec.type_name})

    def _on_lost(self, event: Any) -> None:
        self._gaps.report(event.total_count)

    def _on_arrival(self, data: bytes, number: int | None) -> None:
        self._gaps.see(number, self._subscription.get_publisher_count)
        self._backlog.take(data)

    def _on_message(self, data: bytes) -> None:
        self.received += 1
        now_ns = self._time.now_ns()
        try:
            sample = self.codec.sample(data, now_ns)
        except MessageError as error:
            self._guard.drop(Drop.UNREADABLE)
            self.last_problem = str(error)
            self._recorder.write(self.topic, now_ns, data)
            return
        if not (self._warned or self.codec.is_stamped):
            self._warn_unstamped()
        received = self._dated(data, sample, now_ns)
        self._recorder.write(self.topic, received.log_ns, data)
        if self._take(received):
            self._heard_ns = self._time.age_ns()

    def _dated(self, data: bytes, sample: Sample, now_ns: int) -> Received:
        """Say when a message came; simulated runs are dated by stamps, so that they repeat."""
        if not self._time.simulated:
            return Received(data, sample, now_ns, now_ns)
        if now_ns == 0:  # /clock has not come yet
            now_ns = sample.stamp_ns
        too_early = seconds_between(now_ns, sample.stamp_ns) > self._future_tolerance()
        return Received(data, sample, now_ns, now_ns if too_early else sample.stamp_ns)

    def _warn_unstamped(self) -> None:
        self._warned = True
        self._node.log.warning(
            f"{self.topic}: {self.codec.type_name} carries no stamp, the time of receipt is used: "
            "delays on the way count as motion of the signal"
        )
