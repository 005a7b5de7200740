"""The estimator without its predictor over a whole series.

Instead of ``batch.series.run`` because a fit takes thousands of runs and needs the estimates only,
which this returns three times as fast. The steps are those of ``core.estimator.update`` and the
results are equal to the last bit, which a test holds.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from fuzzy_fusion_ros.batch.arrays import Reals
from fuzzy_fusion_ros.batch.compiled import compiled
from fuzzy_fusion_ros.batch.series import Series
from fuzzy_fusion_ros.core.aggregator import SlowSensor, aggregate, no_slow_sensor, observe_slow
from fuzzy_fusion_ros.core.conditioning import Conditioned, condition, unconditioned
from fuzzy_fusion_ros.core.estimator import FUSED, mode_at
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import numbers


class Output(NamedTuple):
    """Output at each S1 sample, shape (n,) each.

    Attributes:
        value: The aggregator's output; conditioned S1 where S2 is awaited or lost.
        difference: ``|S1 - S2|`` as the rules take it, NaN where they do not run.
        rate: ``|dS2/dt|`` as the rules take it, NaN where they do not run.
    """

    value: Reals
    difference: Reals
    rate: Reals


def outputs(parameters: Parameters, series: Series) -> Output:
    """Run the estimator without its predictor over a series."""
    n = series.s1.size
    output = Output(np.empty(n), np.empty(n), np.empty(n))
    compiled(_outputs)(numbers(parameters), unconditioned(), no_slow_sensor(), series, output)
    return output


def _outputs(
    parameters: Any, s1: Conditioned, s2: SlowSensor, series: Series, output: Output
) -> None:
    seen = 0
    for k in range(series.s1.size):
        while seen < series.s2_known[k]:
            s2 = observe_slow(
                parameters.aggregator.rate_time_constant,
                parameters.s2.timeout,
                s2,
                series.s2_ns[seen],
                series.s2[seen],
            )
            seen += 1
        stamp_ns = series.s1_ns[k]
        s1 = condition(
            parameters.s1, parameters.s2, parameters.aggregator.rate, s1, s2, stamp_ns, series.s1[k]
        )
        output.difference[k] = np.nan
        output.rate[k] = np.nan
        output.value[k] = s1.value
        if mode_at(parameters.s2.timeout, s2, series.s1_ns[0], stamp_ns) == FUSED:
            output.difference[k] = abs(s1.value - s2.value)
            output.rate[k] = abs(s2.rate)
            output.value[k] = aggregate(parameters.aggregator, s1.value, s2.value, s2.rate).value
