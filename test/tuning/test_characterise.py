# SPDX-License-Identifier: Apache-2.0
"""A recording tells what its sensors are like, and says so when it cannot."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from tuning.recordings import Sensors, made

from fuzzy_fusion_ros.batch.cleaning import without_spikes
from fuzzy_fusion_ros.tuning import TuneError, characterise
from fuzzy_fusion_ros.tuning.candidates import candidates_for
from fuzzy_fusion_ros.tuning.characterise import Characteristics
from fuzzy_fusion_ros.tuning.report import described
from fuzzy_fusion_ros.tuning.together import oddities, typical


def test_rates_and_gaps() -> None:
    sensors = characterise(made(Sensors(gap=(10.0, 17.0))).series)
    assert sensors.s1_interval == pytest.approx(0.04)
    assert sensors.s2_interval == pytest.approx(0.2)
    assert sensors.s2_gap == pytest.approx(7.2, abs=0.21)


@pytest.mark.parametrize("size", [2, 5])
def test_an_s2_that_comes_in_bursts_is_not_taken_for_a_fast_one(size: int) -> None:
    """Some samples at a time, a millisecond apart, as when they are stamped on receipt."""
    series = made(Sensors()).series
    k = np.arange(series.s2.size)
    arrival_ns = series.s2_ns[k // size * size] + k % size * 1_000_000
    known = np.searchsorted(arrival_ns, series.s1_ns, side="right")
    sensors = characterise(series._replace(s2_ns=arrival_ns, s2_known=known))
    pause = 0.2 * size - 0.001 * (size - 1)
    assert sensors.s2_interval == pytest.approx(0.2, rel=0.05)
    assert sensors.s2_pause == pytest.approx(pause)
    for each in candidates_for(sensors)[1:]:
        assert each.spec.space.fixed["s2.timeout"] > pause


@pytest.mark.parametrize(("delay", "lag"), [(0.0, 0.4), (0.3, 0.0), (0.3, 0.4), (0.8, 0.1)])
def test_the_lag_of_s2(delay: float, lag: float) -> None:
    sensors = characterise(made(Sensors(delay=delay, lag=lag), seconds=120.0).series).lag
    assert sensors.total == pytest.approx(delay + lag, abs=0.08)
    assert sensors.delay == pytest.approx(delay, abs=0.15)
    assert sensors.correlation > 0.9


def test_bias_drift_and_noise() -> None:
    sensors = characterise(made(Sensors(bias=-0.7, drift=0.01, noise=0.1), seconds=120.0).series)
    assert sensors.bias == pytest.approx(-0.7 + 0.01 * 60.0, abs=0.05)
    assert sensors.drift == pytest.approx(0.01, abs=0.001)
    assert sensors.s1_noise == pytest.approx(0.1, rel=0.2)


@pytest.mark.parametrize("share", [0.0, 0.1])
def test_spikes(share: float) -> None:
    sensors = characterise(made(Sensors(spikes=share)).series)
    assert sensors.has_spikes is (share > 0.0)
    assert sensors.spike_share == pytest.approx(share, abs=0.03)


def test_runs_of_spikes_do_not_hide_the_lag() -> None:
    series = made(Sensors(lag=0.4, noise=0.02), seconds=120.0).series
    s1 = series.s1.copy()
    generator = np.random.default_rng(3)
    for begin in np.flatnonzero(generator.random(s1.size) < 0.06):
        s1[begin : begin + generator.integers(1, 5)] += 5.0 * generator.choice([-1.0, 1.0])
    sensors = characterise(series._replace(s1=s1))
    assert sensors.has_spikes
    assert sensors.lag.correlation > 0.9
    assert sensors.lag.total == pytest.approx(0.4, abs=0.1)


def test_a_spike_at_either_end_is_seen() -> None:
    s1 = made(Sensors(spikes=0.1)).series.s1.copy()
    s1[[0, -1]] = 50.0
    clean, _, _ = without_spikes(s1)
    assert np.abs(clean).max() < 10.0


def test_it_is_told_in_words() -> None:
    made_up = made(Sensors(gap=(10.0, 17.0), spikes=0.1)).series
    text = "\n".join(described(characterise(made_up), "rad"))
    for part in ("S1: 25 Hz", "% spikes", "S2: 5 Hz, with gaps of up to 7.", "rad/s", "lags 0.4"):
        assert part in text
    plain = "\n".join(described(characterise(made(Sensors()).series), ""))
    assert "no spikes" in plain
    assert "gaps" not in plain


WITHOUT_A_LAG = {
    "at its limit": lambda usual: usual._replace(longest_lag=usual.lag.time_constant),
    "clocks apart": lambda usual: usual._replace(clocks_agree=False),
    "one way": lambda usual: usual._replace(one_way=1.0),
    "unrelated": lambda usual: usual._replace(chance=1.0),
}


@pytest.mark.parametrize("change", [lambda usual: usual, *WITHOUT_A_LAG.values()])
def test_text_and_property_agree_on_whether_the_lag_is_identifiable(
    change: Callable[[Characteristics], Characteristics],
) -> None:
    usual = characterise(made(Sensors()).series)
    sensors = change(usual)
    assert sensors.lag_is_identifiable is (sensors == usual)
    text = "\n".join(described(sensors, "rad"))
    assert ("S2's lag is not identifiable" in text) is not sensors.lag_is_identifiable
    assert ("S2 lags" in text) is sensors.lag_is_identifiable


def test_a_lag_at_the_edge_of_its_search_range_is_not_shown_as_a_measurement() -> None:
    late = characterise(made(Sensors(delay=3.0, lag=0.0)).series)  # a twentieth of 40 s is 2 s
    assert late.lag_at_limit
    text = "\n".join(described(late, "rad"))
    assert "S2's lag is not identifiable: the search ended at its longest lag, 2 s" in text
    assert "S2 lags" not in text


def test_where_the_clocks_disagree_no_lag_is_shown() -> None:
    usual = characterise(made(Sensors()).series)
    apart = usual._replace(clocks_agree=False)
    text = "\n".join(described(apart, "rad"))
    assert "S2's lag is not identifiable, nor is S1's bias: the clocks" in text
    assert "S2 lags" not in text
    assert "S1 minus S2 is +0." in text
    assert "S1's bias is" not in text
    assert not typical([usual, apart]).clocks_agree
    odd = apart._replace(lag=usual.lag._replace(delay=9.0))
    assert list(oddities(odd, usual)) == []


def test_unrelated_sensors_are_said_to_be() -> None:
    series = made(Sensors()).series
    noise = np.random.default_rng(1).standard_normal(series.s2.size)
    text = "\n".join(described(characterise(series._replace(s2=noise)), "m/s"))
    assert "no more in common than unrelated signals" in text
    assert "(m/s)/s" in text


def test_too_little_is_refused() -> None:
    series = made(Sensors()).series
    short = series._replace(s2=series.s2[:9], s2_ns=series.s2_ns[:9])
    with pytest.raises(TuneError, match="got 9 samples of S2, expected at least 10"):
        characterise(short)
    with pytest.raises(TuneError, match="S2 is 1 in all"):
        characterise(series._replace(s2=np.ones_like(series.s2)))
    with pytest.raises(TuneError, match="got 0 samples of S1 after the first of S2"):
        characterise(series._replace(s2_known=np.zeros_like(series.s2_known)))


def test_a_few_wild_samples_of_s2_do_not_hide_the_lag() -> None:
    series = made(Sensors(lag=0.4), seconds=120.0).series
    generator = np.random.default_rng(2)
    s2 = series.s2 + 8.0 * generator.standard_normal(series.s2.size) * (
        generator.random(series.s2.size) < 0.03
    )
    sensors = characterise(series._replace(s2=s2))
    assert sensors.related
    assert sensors.lag.total == pytest.approx(0.4, abs=0.1)


def test_a_loose_relation_is_called_a_guess() -> None:
    sensors = characterise(made(Sensors()).series)
    loose = sensors._replace(lag=sensors.lag._replace(correlation=0.4), chance=0.2)
    assert "a guess" in "\n".join(described(loose, "m/s"))


def test_on_one_way_lag_and_bias_are_not_told_apart() -> None:
    series, _ = made(Sensors())
    assert not characterise(series).moves_one_way
    ramp_s = (series.s2_ns - series.s2_ns[0]) * 1e-9
    driving = characterise(series._replace(s2=0.02 * series.s2 + ramp_s))
    assert driving.moves_one_way
    assert "a lag of S2 then looks like a bias of S1" in "\n".join(described(driving, ""))
