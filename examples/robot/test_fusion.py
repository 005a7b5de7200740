# SPDX-License-Identifier: Apache-2.0
"""Tests a parameter file on real DDS: copy this folder, change file and signal, run pytest."""

from pathlib import Path

from fuzzy_fusion_ros.testing import Harness

PARAMETERS = Path(__file__).with_name("tuned.yaml")


def test_the_estimate_rests_when_the_signal_does(fusion_harness: Harness) -> None:
    fusion_harness.fusion_node(parameter_file=PARAMETERS)
    feed = fusion_harness.feed()
    estimates = [feed(at=0.01 * k, s1=0.5 + 0.1 * (-1) ** k, s2=0.5) for k in range(50)]
    assert max(abs(estimate - 0.5) for estimate in estimates) < 0.1
