# SPDX-License-Identifier: Apache-2.0
"""The estimator without its predictor over a whole series.

Instead of ``batch.series.run`` because a fit takes thousands of runs and needs the estimates only,
which this returns three times as fast. The steps are those of ``core.estimator.update`` and the
results are equal to the last bit, as a test checks.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from fuzzy_fusion_ros.batch.arrays import Reals
from fuzzy_fusion_ros.batch.compiled import compiled
from fuzzy_fusion_ros.batch.series import Series
from fuzzy_fusion_ros.core.estimator import (
    FUSED,
    Sensors,
    fused,
    heard_s2,
    mode_at,
    no_sensors,
)
from fuzzy_fusion_ros.core.observer import observes
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import numbers

SETTLING = 3
"""The first innovations say what was not known before them: they do not count."""


class Output(NamedTuple):
    """Output at each S1 sample, shape (n,), and at each S2 sample, shape (m,).

    Attributes:
        value: The aggregate; S1 as conditioned where S2 is awaited or lost.
        difference: What the rules take for the difference, NaN where they do not run.
        rate: ``|dS2/dt|`` as the rules take it, NaN where they do not run.
        innovation: Innovation of each S2 sample, shape (m,), NaN where the observer has none, and
            for the first ``SETTLING``, which say what was not known before them.
        variance: Its variance, shape (m,), in units of S2's noise variance.
    """

    value: Reals
    difference: Reals
    rate: Reals
    innovation: Reals
    variance: Reals


def outputs(parameters: Parameters, series: Series) -> Output:
    """Run the estimator without its predictor over a series."""
    n, m = series.s1.size, series.s2.size
    output = Output(np.empty(n), np.empty(n), np.empty(n), np.full(m, np.nan), np.full(m, np.nan))
    compiled(_outputs)(numbers(parameters), no_sensors(), series.contiguous(), output)
    return output


def joined(parameters: Parameters, recordings: Sequence[Series]) -> Output:
    """Run the estimator without its predictor over each recording; return its outputs in a row."""
    if len(recordings) == 1:
        return outputs(parameters, recordings[0])
    return Output._make(
        np.concatenate(each)
        for each in zip(*(outputs(parameters, one) for one in recordings), strict=True)
    )


def _outputs(parameters: Any, sensors: Sensors, series: Series, output: Output) -> None:
    seen = 0
    started_ns = series.started_ns if series.started_ns > 0 else series.s1_ns[0]
    for k in range(series.s1.size):
        while seen < series.s2_known[k]:
            samples = sensors.belief.samples
            sensors = heard_s2(parameters, sensors, series.s2_ns[seen], series.s2[seen])
            if sensors.belief.samples > max(samples, SETTLING):
                output.innovation[seen] = sensors.belief.innovation
                output.variance[seen] = sensors.belief.variance
            seen += 1
        stamp_ns = series.s1_ns[k]
        mode = mode_at(parameters.s2.timeout, sensors.s2, started_ns, stamp_ns)
        fa, sensors = fused(parameters, sensors, mode, stamp_ns, series.s1[k])
        output.value[k] = fa.value
        output.difference[k] = np.nan
        output.rate[k] = np.nan
        if mode == FUSED:
            output.difference[k] = abs(sensors.s1.smooth.value - sensors.s2.value)
            output.rate[k] = abs(sensors.s2.rate)
            if observes(parameters):
                output.difference[k] = abs(sensors.belief.innovation)
