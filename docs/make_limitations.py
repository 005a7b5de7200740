# SPDX-License-Identifier: Apache-2.0
"""Makes the table of docs/known_limitations.md: made-up recordings of what goes wrong.

    python docs/make_limitations.py

Each is tuned, with the truth, on its first half and scored on its second. Everything is seeded.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from fuzzy_fusion_ros.baselines import methods
from fuzzy_fusion_ros.batch.arrays import Reals, root_mean_square
from fuzzy_fusion_ros.batch.series import Series, fusion, held_s2, run
from fuzzy_fusion_ros.core.numerics import lag_gain
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import replace
from fuzzy_fusion_ros.tuning import characterise, reference_without_truth, tune

PAGE = Path(__file__).resolve().parent / "known_limitations.md"
BEGIN, END = "<!-- made by make_limitations.py: -->\n", "<!-- end -->\n"
SECONDS, RATE, EVERY = 240.0, 50.0, 10

Sensors = Callable[[np.random.Generator, Reals, Reals], tuple[Reals, Reals]]
"""Makes S1 and S2, both at all times, of times and the truth."""


def white(generator: np.random.Generator, time_s: Reals, truth: Reals) -> tuple[Reals, Reals]:
    """Both right on the average, and at once: noise is all that ails them."""
    return truth + _noise(generator, truth, 0.5), truth + _noise(generator, truth, 0.2)


def lagging(generator: np.random.Generator, time_s: Reals, truth: Reals) -> tuple[Reals, Reals]:
    """What the package is for: S1 noisy and off, S2 late."""
    s1 = truth + 0.3 + _noise(generator, truth, 0.1)
    return s1, _lagged(time_s, truth, 0.6) + _noise(generator, truth, 0.01)


def both_off(generator: np.random.Generator, time_s: Reals, truth: Reals) -> tuple[Reals, Reals]:
    """The same, and both off by 0.5 in the second half."""
    s1, s2 = lagging(generator, time_s, truth)
    off = np.where(time_s >= SECONDS / 2.0, 0.5, 0.0)
    return s1 + off, s2 + off


def stretched(generator: np.random.Generator, time_s: Reals, truth: Reals) -> tuple[Reals, Reals]:
    """The same, and S1 reads 30 % too much."""
    s1, s2 = lagging(generator, time_s, truth)
    return s1 + 0.3 * truth, s2


def changed(generator: np.random.Generator, time_s: Reals, truth: Reals) -> tuple[Reals, Reals]:
    """The same, but in the second half S2 lags 1.8 s, three times as much."""
    s1, s2 = lagging(generator, time_s, truth)
    later = _lagged(time_s, truth, 1.8) + _noise(generator, truth, 0.01)
    return s1, np.where(time_s >= SECONDS / 2.0, later, s2)


def garbage(generator: np.random.Generator, time_s: Reals, truth: Reals) -> tuple[Reals, Reals]:
    """The same, but in the second half every tenth sample of S2 or so is wild."""
    s1, s2 = lagging(generator, time_s, truth)
    wild = (time_s >= SECONDS / 2.0) & (generator.random(truth.size) < 0.1)
    return s1, s2 + np.where(wild, generator.uniform(-5.0, 5.0, truth.size), 0.0)


def silent(generator: np.random.Generator, time_s: Reals, truth: Reals) -> tuple[Reals, Reals]:
    """The same, S1 drifts by a random walk, and S2 is silent for half of each minute."""
    s1, s2 = lagging(generator, time_s, truth)
    return s1 + 0.1 * _walk(generator, time_s), np.where(time_s % 60.0 < 30.0, s2, np.nan)


Values = Mapping[str, float]

NOTHING: Values = MappingProxyType({})
LAG: Values = {"adapt.lag_time_constant": 2.0}
UNBOUNDED: Values = {"s2.outlier_threshold": 0.0}


class Case(NamedTuple):
    """A row of the table.

    Attributes:
        truth: The kind of signal: ``swings`` or ``walk``.
        sensors: Makes S1 and S2.
        before: Parameters set before tuning.
        after: Parameters set after tuning.
    """

    truth: str
    sensors: Sensors
    before: Values = NOTHING
    after: Values = NOTHING


CASES = {
    "S1 noisy and biased, S2 late": Case("swings", lagging),
    "white noise only, no lag, a random walk": Case("walk", white),
    "S1 drifts, S2 silent for half of each minute": Case("swings", silent),
    "both sensors off by the same amount in the second half": Case("swings", both_off),
    "S1 reads 30 % high": Case("swings", stretched),
    "S2's lag triples halfway": Case("swings", changed),
    "the same, tuned with `adapt.lag_time_constant` 2 s": Case("swings", changed, LAG),
    "a tenth of S2 is garbage in the second half": Case("swings", garbage),
    "the same, with `s2.outlier_threshold` 0": Case("swings", garbage, after=UNBOUNDED),
}


def main() -> None:
    """Write the table into the page."""
    table = "\n".join(_table()) + "\n"
    before, _, rest = PAGE.read_text(encoding="utf-8").partition(BEGIN)
    PAGE.write_text(before + BEGIN + table + END + rest.partition(END)[2], encoding="utf-8")


def _table() -> Iterator[str]:
    yield "| recording | better sensor | best baseline | ours | with hindsight |"
    yield "|---|---|---|---|---|"
    for name, case in CASES.items():
        yield f"| {name} | " + " | ".join(_row(case)) + " |"


def _row(case: Case) -> Iterator[str]:
    generator = np.random.default_rng(7)
    time_s = np.arange(round(SECONDS * RATE)) / RATE
    truth = _walk(generator, time_s) if case.truth == "walk" else _swings(generator, time_s)
    s1, s2 = case.sensors(generator, time_s, truth)
    series = _series(time_s, s1, s2)
    half = truth.size // 2
    m = int(series.s2_known[half - 1])
    first = Series(
        series.s1_ns[:half],
        series.s1[:half],
        series.s2_ns[:m],
        series.s2[:m],
        series.s2_known[:half],
    )

    def rmse(values: Reals) -> float:
        return root_mean_square((values - truth)[half:])

    tuned = tune(first, truth[:half], replace(Parameters(), case.before))
    errors = {
        name: rmse(run(each, series).value) for name, each in methods(tuned.baselines).items()
    }
    name = min(errors, key=lambda each: errors[each])
    yield f"{min(rmse(series.s1), rmse(held_s2(series))):.3f}"
    yield f"{errors[name]:.3f} `{name}`"
    yield f"{rmse(run(fusion(replace(tuned.parameters, case.after)), series).value):.3f}"
    yield f"{rmse(reference_without_truth(series, characterise(series))):.3f}"


def _series(time_s: Reals, s1: Reals, s2: Reals) -> Series:
    stamps_ns = 1_000_000_000 + np.round(time_s * 1e9).astype(np.int64)
    there = np.isfinite(s2) & (np.arange(s2.size) % EVERY == 0)
    return Series(stamps_ns, s1, stamps_ns[there], s2[there], np.cumsum(there, dtype=np.int64))


def _swings(generator: np.random.Generator, time_s: Reals) -> Reals:
    """Return a signal that rests and moves in turns."""
    moving = np.repeat(generator.random(round(SECONDS / 6.0)) < 0.6, round(6.0 * RATE))
    white_noise = np.where(moving, _noise(generator, time_s, 1.0), 0.0)
    swings = _lagged(time_s, _lagged(time_s, white_noise, 0.8), 0.5)
    return np.array(swings / np.std(swings))


def _walk(generator: np.random.Generator, time_s: Reals) -> Reals:
    return np.array(np.cumsum(_noise(generator, time_s, 1.0)) * np.sqrt(1.0 / RATE))


def _noise(generator: np.random.Generator, like: Reals, sigma: float) -> Reals:
    return np.array(sigma * generator.standard_normal(like.size))


def _lagged(time_s: Reals, values: Reals, time_constant: float) -> Reals:
    gain = lag_gain(float(time_s[1] - time_s[0]), time_constant)
    found = np.array(values)
    for k in range(1, found.size):
        found[k] = found[k - 1] + gain * (values[k] - found[k - 1])
    return found


if __name__ == "__main__":
    main()
