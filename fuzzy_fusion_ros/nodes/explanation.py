"""Why an estimate is what it is: the topics below the node's own name."""

from __future__ import annotations

from typing import Any

from rclpy.node import Node
from std_msgs.msg import Float64MultiArray, MultiArrayDimension

from fuzzy_fusion_ros.core.aggregator import FiringStrengths
from fuzzy_fusion_ros.core.estimator import Estimate
from fuzzy_fusion_ros.core.fusion import Fused
from fuzzy_fusion_ros.nodes.outlet import POINT, Outlet, point
from fuzzy_fusion_ros.nodes.recorder import NoRecorder, Recorder

ALWAYS = ("weight", "drift", "aggregate")
PREDICTED = ("prediction", "innovation")
STRENGTHS = "firing_strengths"


class Explanation:
    """Publishes what stands behind each estimate, as far as someone listens or records."""

    def __init__(self, node: Node, recorder: Recorder) -> None:
        """Publish on ``~/weight``, ``~/drift`` and so on."""
        self._recording = not isinstance(recorder, NoRecorder)
        self._scalars = {
            name: Outlet(node, f"~/{name}", POINT, recorder) for name in (*ALWAYS, *PREDICTED)
        }
        self._strengths = Outlet(node, f"~/{STRENGTHS}", "std_msgs/msg/Float64MultiArray", recorder)

    def publish(self, fused: Fused, log_ns: int) -> None:
        """Explain an estimate; without a prediction its two topics are silent."""
        for name, value in scalars(fused.estimate).items():
            outlet = self._scalars[name]
            if self._recording or outlet.subscribers:
                outlet.send(point(fused.stamp_ns, value), log_ns)
        if self._recording or self._strengths.subscribers:
            self._strengths.send(strengths_message(fused.estimate.aggregate.strengths), log_ns)


def scalars(estimate: Estimate) -> dict[str, float]:
    """Return the numbers behind an estimate by their topics' names."""
    aggregate, prediction = estimate.aggregate, estimate.prediction
    known = {"weight": aggregate.weight, "drift": aggregate.drift, "aggregate": aggregate.value}
    if prediction.exists:
        known["prediction"] = prediction.value
        known["innovation"] = aggregate.value - prediction.value
    return known


def strengths_message(strengths: FiringStrengths) -> Any:
    """Return the firing strengths in Table 1's order: by difference, then by rate."""
    message = Float64MultiArray(data=list(strengths))
    message.layout.dim = [
        MultiArrayDimension(label="difference: small, large", size=2, stride=4),
        MultiArrayDimension(label="rate: small, large", size=2, stride=2),
    ]
    return message
