# SPDX-License-Identifier: Apache-2.0
"""Compiles what replays, fits and sweeps run, so that the first of them need not wait for it."""

from __future__ import annotations

from concurrent.futures import ProcessPoolExecutor

import numpy as np

from fuzzy_fusion_ros.baselines import BASELINES, BaselineParameters, methods
from fuzzy_fusion_ros.batch.compiled import can_compile
from fuzzy_fusion_ros.batch.series import Series, fusion, interval_after, run, values
from fuzzy_fusion_ros.batch.smoothing import lagged, smoothed
from fuzzy_fusion_ros.paper.methods import contenders
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.simulation.closed_loop import simulate
from fuzzy_fusion_ros.simulation.scenario import Scenario
from fuzzy_fusion_ros.tuning.kernel import outputs

STAMPS = np.arange(1, 9, dtype=np.int64) * 10**7
SERIES = Series(STAMPS, np.zeros(8), STAMPS, np.zeros(8), np.arange(1, 9))
BALANCED = ("kalman", "average", "complementary")
"""What balances the pendulum in ``reproduce``, besides the fusion, each by other functions."""


def main() -> None:
    """Compile in as many processes as there are processors, what takes longest first.

    The loops over the fusion share what they call, which takes longer than they do.
    """
    if can_compile():
        with ProcessPoolExecutor() as processes:
            shared = processes.submit(_run)
            jobs = [processes.submit(_balance, name) for name in BALANCED]
            jobs += [processes.submit(_baseline, name) for name in BASELINES]
            jobs.append(processes.submit(_smoother))
            shared.result()
            jobs.append(processes.submit(_balance, "aggregator"))
            jobs += [processes.submit(each) for each in (_outputs, _values)]
            for job in jobs:
                job.result()


def _run() -> None:
    run(fusion(Parameters()), SERIES)


def _outputs() -> None:
    outputs(Parameters(), SERIES)


def _values() -> None:
    values(fusion(Parameters()), SERIES)


def _smoother() -> None:
    smoothed(np.arange(8.0), SERIES.s1, 1.0)
    lagged(np.arange(8.0), SERIES.s1, 1.0)
    interval_after(0.0, 0, STAMPS, compiles=True)


def _baseline(name: str) -> None:
    method = methods(BaselineParameters())[name]
    run(method, SERIES)
    values(method, SERIES)


def _balance(name: str) -> None:
    by_name = {each.name: each.method for each in contenders(Parameters())}
    simulate(by_name[name], Scenario(), np.random.default_rng(0))


if __name__ == "__main__":
    main()
