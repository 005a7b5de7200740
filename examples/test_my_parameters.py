"""Tests a parameter file on real DDS, without launch files: copy it, and change file and signal.

pytest examples/test_my_parameters.py
"""

from pathlib import Path

from fuzzy_fusion_ros.testing import Harness

PARAMETERS = Path(__file__).parents[1] / "config" / "fusion_node.yaml"


def test_the_estimate_rests_when_the_signal_does() -> None:
    with Harness() as harness:
        harness.fusion_node(parameter_file=PARAMETERS)
        feed = harness.feed()
        estimates = [feed(at=0.01 * k, s1=0.5 + 0.1 * (-1) ** k, s2=0.5) for k in range(50)]
    assert max(abs(estimate - 0.5) for estimate in estimates) < 0.1


def test_the_estimate_follows_a_step_before_s2_does() -> None:
    with Harness() as harness:
        harness.fusion_node(parameter_file=PARAMETERS)
        feed = harness.feed()
        for k in range(20):
            feed(at=0.01 * k, s1=0.0, s2=0.0)
        lagging = [1.0 - 0.5**n for n in range(1, 6)]
        estimates = [feed(at=0.2 + 0.01 * n, s1=1.0, s2=s2) for n, s2 in enumerate(lagging)]
    assert all(estimate > s2 for estimate, s2 in zip(estimates, lagging, strict=True))
