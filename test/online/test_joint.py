# SPDX-License-Identifier: Apache-2.0
"""What several channels estimate at one stamp is let out together."""

from __future__ import annotations

from fuzzy_fusion_ros.core.sample import Sample
from fuzzy_fusion_ros.online.fusion import Fusion
from fuzzy_fusion_ros.online.joint import Joint
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import replace

SECOND_NS = 1_000_000_000


class Pair:
    """Two channels, x and y, that are given samples of S1 once a second."""

    def __init__(self, period: float = 0.0) -> None:
        self.joint = Joint()
        parameters = replace(Parameters(), {"signal.period": period})
        self.fusions = {name: Fusion(parameters) for name in "xy"}
        for name, fusion in self.fusions.items():
            self.joint.add(name, fusion)
            fusion.on_s2(Sample(SECOND_NS, 5.0))

    def out(self, second: int, names: str) -> list[tuple[int, str]]:
        """Give channels a sample; return the seconds let out, and whose estimates they have."""
        for name in names:
            verdict = self.fusions[name].on_s1(Sample(second * SECOND_NS, 0.5))
            self.joint.take(name, verdict.estimates)
        return [(at // SECOND_NS, "".join(fused)) for at, fused, _ in self.joint.due()]


def test_the_first_estimate_of_a_channel_is_not_waited_for() -> None:
    pair = Pair()
    assert [pair.out(k, "x") for k in (1, 2)] == [[(1, "x")], [(2, "x")]]
    assert pair.out(3, "xy") == [(3, "xy")]
    assert pair.out(4, "x") == []


def test_a_channel_is_waited_for_five_times_in_a_row() -> None:
    pair = Pair()
    pair.out(1, "xy")
    assert [pair.out(k, "x") for k in range(2, 8)] == [[]] * 5 + [[(7, "x")]]
    pair.out(8, "xy")
    assert [len(pair.out(k, "x" if k % 2 else "xy")) for k in range(9, 29)] == [0, 1] * 10
    assert pair.joint.withheld == {"y": 15}


def test_after_a_reset_no_channel_is_waited_for() -> None:
    pair = Pair()
    pair.out(1, "xy")
    for each in pair.fusions.values():
        each.reset()
    pair.joint.reset()
    pair.fusions["x"].on_s2(Sample(2 * SECOND_NS, 5.0))
    assert pair.out(2, "x") == [(2, "x")]


def test_after_a_restart_a_channel_is_not_waited_for_until_its_next_estimate() -> None:
    pair = Pair()
    pair.out(1, "xy")
    pair.fusions["y"].restart()
    assert pair.out(2, "x") == [(2, "x")]
    pair.fusions["y"].on_s2(Sample(3 * SECOND_NS, 5.0))
    assert pair.out(3, "xy") == [(3, "xy")]
    assert pair.out(4, "x") == []


def test_who_has_no_estimate_shows_its_newest_s2_within_the_period() -> None:
    pair = Pair(4.0)
    pair.fusions["y"].on_s2(Sample(2 * SECOND_NS, 7.0))
    (fused,) = pair.fusions["x"].on_s1(Sample(3 * SECOND_NS, 0.5)).estimates
    pair.joint.take("x", [fused])
    (together,) = pair.joint.due()
    assert together.held == {"y": -1.0}
    pair.fusions["y"].reset()
    assert pair.fusions["y"].held_s2 is None
