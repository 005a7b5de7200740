# SPDX-License-Identifier: Apache-2.0
"""Spikes are told from noise and from motion."""

from __future__ import annotations

import math

import numpy as np
import pytest

from fuzzy_fusion_ros.self_tuning.allan import Reals
from fuzzy_fusion_ros.self_tuning.spikes import NO_SPIKES, Spikes, judged, threshold


def of(values: Reals) -> Spikes:
    kept = NO_SPIKES
    for value in values.tolist():
        kept = judged(kept, value)
    return kept


def moving(n: int = 4000) -> Reals:
    """Noise of 0.01 on a signal that rests, then swings."""
    time_s = np.arange(n) * 0.02
    swing = np.where(time_s > time_s[-1] / 2.0, np.sin(2.0 * time_s), 0.0)
    return swing + 0.01 * np.random.default_rng(4).standard_normal(n)


def test_noise_and_motion_are_no_spikes() -> None:
    assert threshold(of(moving())) == 0.0
    assert threshold(of(np.where(np.arange(3000) < 1500, 0.0, np.arange(3000) - 1500.0))) == 0.0


@pytest.mark.parametrize("share", [0.03, 0.1])
def test_spikes_are_beyond_the_threshold_and_noise_is_not(share: float) -> None:
    generator = np.random.default_rng(5)
    values = moving()
    hit = generator.random(values.size) < share
    spikes = of(np.where(hit, values + generator.choice([-2.0, 2.0], values.size), values))
    assert spikes.share == pytest.approx(share, rel=0.5)
    assert 0.1 < threshold(spikes) < 1.5


def test_its_memory_is_bounded_and_huge_samples_stay_finite() -> None:
    spikes = of(np.tile([0.0, 1e100, -1e100, 0.0, 0.0, 0.0, 0.0], 3000))
    assert (len(spikes.newest), spikes.samples) == (11, 2000)
    assert all(math.isfinite(each) for each in (spikes.distance, spikes.share, threshold(spikes)))
