# SPDX-License-Identifier: Apache-2.0
"""Parameters of the baselines after a look at the recording."""

from __future__ import annotations

import numpy as np
import pytest

from fuzzy_fusion_ros.baselines import BaselineParameters, baselines_for
from fuzzy_fusion_ros.batch.series import Series
from fuzzy_fusion_ros.batch.smoothing import lagged

SECOND = 1_000_000_000


def recorded(
    *, delay_s: float = 0.0, noise: float = 0.05, every: int = 1, seconds: float = 60.0
) -> Series:
    """Return a slowly wandering signal, seen by a noisy biased S1 and an S2 that comes late."""
    generator = np.random.default_rng(0)
    n = round(seconds * 100)
    stamps = SECOND + np.arange(n, dtype=np.int64) * 10_000_000
    truth = lagged(0.01 * np.arange(n), generator.normal(0.0, 2.0, n), 0.5)
    late = round(delay_s * 100)
    s2 = np.concatenate([np.full(late, truth[0]), truth[: n - late]])
    return Series(
        s1_ns=stamps,
        s1=truth + 0.3 + generator.normal(0.0, noise, n),
        s2_ns=stamps[::every],
        s2=s2[::every],
        s2_known=np.arange(n, dtype=np.int64) // every + 1,
    )


def test_noise_is_found() -> None:
    parameters = baselines_for(recorded(noise=0.2))
    assert parameters.kalman_bias.s1_noise == pytest.approx(0.2, rel=0.1)


def test_an_s2_that_lags_serves_as_low_pass() -> None:
    late = baselines_for(recorded(delay_s=0.5)).complementary
    prompt = baselines_for(recorded(delay_s=0.0, every=10)).complementary
    assert (late.s2_lags, prompt.s2_lags) == (True, False)
    assert late.time_constant == pytest.approx(0.5, rel=0.2)


@pytest.mark.parametrize(
    ("s1", "s2"),
    [
        ([1.0] * 50, [1.0] * 50),
        (list(np.arange(50.0)), [0.0] * 50),
        ([0.0] * 50, list(np.arange(50.0) % 2)),
        ([1e90] * 50, list(1e90 * (np.arange(50.0) % 3))),
    ],
)
def test_odd_recordings_give_parameters_too(s1: list[float], s2: list[float]) -> None:
    stamps = SECOND + np.arange(50, dtype=np.int64) * SECOND
    series = Series(stamps, np.array(s1), stamps, np.array(s2), np.arange(1, 51))
    assert isinstance(baselines_for(series), BaselineParameters)


def test_a_very_short_recording_gives_the_plain_defaults() -> None:
    series = recorded(seconds=0.05)
    assert baselines_for(series) == BaselineParameters()


def test_sensors_that_do_not_overlap_have_no_lag() -> None:
    series = recorded()
    apart = series._replace(s2_ns=series.s2_ns + 1000 * SECOND)
    assert not baselines_for(apart).complementary.s2_lags
