# SPDX-License-Identifier: Apache-2.0
"""Every method of the benchmark, stepped as a node would, is its compiled run bit for bit."""

from __future__ import annotations

import numpy as np
import pytest

from fuzzy_fusion_ros.paper.methods import Contender, contenders
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import replace
from fuzzy_fusion_ros.simulation.closed_loop import act, at_start, sense, simulate
from fuzzy_fusion_ros.simulation.scenario import Scenario
from fuzzy_fusion_ros.simulation.sensors import draw_noise

BRIEF = replace(Scenario(), {"duration": 1.0})


@pytest.mark.parametrize("contender", contenders(Parameters()), ids=lambda each: each.name)
def test_stepping_is_the_run_bit_for_bit(contender: Contender) -> None:
    scenario = contender.with_its_sensors(BRIEF)
    method = contender.method
    run = simulate(method, scenario, np.random.default_rng(11))
    noise = draw_noise(np.random.default_rng(11), 100)
    loop, state = at_start(scenario), method.state
    for k in range(100):
        stamp_ns = int(run.stamps_ns[k])
        reading = sense(scenario, loop, noise[k, 0], noise[k, 1])
        state = method.observe_s2(method.parameters, state, stamp_ns, reading.s2)
        estimate, state = method.update(method.parameters, state, stamp_ns, reading.s1)
        assert (loop.plant.angle, *reading) == (run.truth[k], run.s1[k], run.s2[k])
        assert estimate.value == run.trace.value[k]
        control, loop = act(scenario, loop, estimate.value)
        assert control == run.control[k]
