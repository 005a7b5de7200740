# SPDX-License-Identifier: Apache-2.0
"""Tunes on the first half of every stand-in and scores on the second, beside the baselines.

python test/tuning/evaluate.py --seeds 0-4

Or on recordings: CSV files with the columns ``t,s1,ref`` (``ref`` may be empty) and, beside each,
one with ``t,s2`` whose name ends in ``_s2``.

python test/tuning/evaluate.py --csv car_accel.csv --markdown

The best baseline is best on the second half, the one picked on the first. ``constant`` is our error
with the four weights of Table 1 replaced by the one that does best on the first half. Bags with a
truth are given by ``--bags``. Two more tables of ``--markdown`` show how far standard deviations
hold, and what the predictor does to the error.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from tuning.recordings import START_NS, Made
from tuning.standins import HOSTILE, STANDINS, standin

from fuzzy_fusion_ros.bag import open_bag
from fuzzy_fusion_ros.baselines import methods
from fuzzy_fusion_ros.batch.arrays import Flags, Reals, nearest
from fuzzy_fusion_ros.batch.series import Method, Series, fusion, held_s2, run, seconds, values
from fuzzy_fusion_ros.offline.recording import read_recording
from fuzzy_fusion_ros.offline.topics import Topics
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import replace
from fuzzy_fusion_ros.scoring.join import interpolated
from fuzzy_fusion_ros.scoring.metrics import SURENESS, Matched
from fuzzy_fusion_ros.tuning import tune
from fuzzy_fusion_ros.tuning.characterise import TINY
from fuzzy_fusion_ros.tuning.space import WEIGHTS

SINGLE = ("s1", "s2")
ENOUGH = 0.9
"""Beaten by 10 %."""

NO_WORSE = 1.03
"""No worse than a sensor, on data that neither was fitted to."""

DOUBTS = np.geomspace(1.0, 300.0, 40)
"""Factors of S2's noise to try as the constant in place of Table 1's weights."""

GATES = (0.3, 1.0, 3.0)
"""Tolerances of the predictor's gate to try, in multiples of the error on the first half."""


def main() -> None:
    """Print a row per kind and mode, then what they come to."""
    given = _parser().parse_args()
    first, _, last = given.seeds.partition("-")
    rows = []
    recordings = [(path.stem, recorded(path)) for path in given.csv]
    recordings += [(path.name, in_bag(path)) for path in given.bags]
    chosen = [] if recordings else given.kinds or [*STANDINS, *HOSTILE]
    kinds = [(name, seed) for name in chosen for seed in range(int(first), int(last or first) + 1)]
    cases = [(name, seed, standin(name, seed)) for name, seed in kinds]
    cases += [(name, 0, made) for name, made in recordings]
    modes = (True,) if given.with_truth else (True, False)
    for name, seed, made in cases:
        for with_truth in modes:
            rows.append(evaluated(name, seed, made, with_truth))
            print(line(rows[-1]), flush=True)
    for title in ("stand-ins", "hostile", "recordings"):
        for with_truth in modes:
            these = [r for r in rows if title == group(r) and r["truth"] == with_truth]
            if these:
                print(f"{title}, {'with' if with_truth else 'without'} truth: {summed(these)}")
    if given.json:
        Path(given.json).write_text(json.dumps(rows, indent=1), encoding="utf-8")
    if given.markdown:
        print("\n".join([*markdown(rows), "", *sureness_table(rows), "", *predictor_table(rows)]))


def group(row: dict[str, Any]) -> str:
    """Return what a row is counted with."""
    if row["kind"] in HOSTILE:
        return "hostile"
    return "stand-ins" if row["kind"] in STANDINS else "recordings"


def recorded(path: Path) -> Made:
    """Read a recording from its two CSV files."""
    fast = np.genfromtxt(path, delimiter=",", names=True)
    slow = np.genfromtxt(path.with_name(f"{path.stem}_s2.csv"), delimiter=",", names=True)
    s1_ns, s2_ns = (START_NS + np.round(each["t"] * 1e9).astype(np.int64) for each in (fast, slow))
    known = np.searchsorted(s2_ns, s1_ns, side="right")
    return Made(Series(s1_ns, fast["s1"], s2_ns, slow["s2"], known), fast["ref"])


def in_bag(path: Path) -> Made:
    """Read a bag with a truth."""
    with open_bag(path) as bag:
        found = read_recording(bag, Topics().found_in(bag), Parameters())
    series = found.series
    truth = interpolated(found.truth, series.s1_ns, found.period)
    return Made(series, nearest(truth, held_s2(series), found.period))


def evaluated(name: str, seed: int, made: Made, with_truth: bool) -> dict[str, Any]:
    """Tune on the first half; return every error on the second."""
    began = time.monotonic()
    half = made.truth.size // 2
    series = made.series
    known = series.s2_known[:half]
    learnt = Series(
        series.s1_ns[:half],
        series.s1[:half],
        series.s2_ns[: known[-1]],
        series.s2[: known[-1]],
        known,
    )
    tuned = tune(learnt, made.truth[:half] if with_truth else None, threads=1)

    known_truth = np.isfinite(made.truth) & (series.s2_known > 0)
    where = known_truth & (np.arange(made.truth.size) >= half)

    def rmse(method: Any, where: Flags = where) -> float:
        error = (values(method, series) - made.truth)[where]
        return float(np.sqrt(np.mean(np.square(error))))

    constants = [with_constant_weight(tuned.parameters, float(each)) for each in DOUBTS]
    constant = min(constants, key=lambda each: rmse(fusion(each), known_truth & ~where))

    others = methods(tuned.baselines)
    scored = {"ours": fusion(tuned.parameters), **others}
    return {
        "sureness": {each: sureness(method, made, where) for each, method in scored.items()},
        "predictor": with_predictor(tuned.parameters, rmse, known_truth & ~where),
        "kind": name,
        "seed": seed,
        "truth": with_truth,
        "ours": rmse(scored["ours"]),
        "constant": rmse(fusion(constant)),
        "chosen": tuned.chosen,
        "correlation": tuned.sensors.lag.correlation,
        "others": {each: rmse(method) for each, method in others.items()},
        "picked": min(tuned.baseline_errors, key=tuned.baseline_errors.__getitem__),
        "candidates": {
            each.name: (
                each.fitted,
                each.unseen,
                rmse(fusion(each.parameters)),
                *each.unseen_parts,
            )
            for each in tuned.candidates
        },
        "seconds": time.monotonic() - began,
    }


def sureness(method: Method, made: Made, where: Flags) -> list[float]:
    """Return coverage at 1 and 2 standard deviations and the mean negative log-likelihood.

    Args:
        method: The method.
        made: What to run it on.
        where: The samples that count.

    Returns:
        The three, NaN where the method does not know its standard deviation.
    """
    trace = run(method, made.series)
    where = where & (trace.standard_deviation > 0.0)
    if not where.any():
        return [np.nan] * len(SURENESS)
    matched = Matched(
        seconds(made.series)[0][where],
        trace.value[where],
        made.truth[where],
        trace.standard_deviation[where],
    )
    return [metric.function(matched) for metric in SURENESS.values()]


def with_predictor(
    parameters: Parameters, rmse: Callable[..., float], first_half: Flags
) -> list[float]:
    """Return the error with the predictor over that without, on the first half and on the other.

    Its gate is the one of :data:`GATES` with which the error on the first half is smallest.

    Args:
        parameters: As tuned.
        rmse: The error of a method where it counts, by default on the other half.
        first_half: What it is tuned on.
    """
    off = fusion(replace(parameters, {"predictor.enabled": False}))
    first, other = max(rmse(off, first_half), TINY), max(rmse(off), TINY)
    found = []
    for gate in GATES:
        changes = {"predictor.enabled": True, "gate.tolerance": gate * first}
        on = fusion(replace(parameters, changes))
        found.append([rmse(on, first_half) / first, rmse(on) / other])
    return min(found)


def with_constant_weight(parameters: Parameters, doubt: float) -> Parameters:
    """Return parameters with one weight in place of the four of Table 1.

    Args:
        parameters: As tuned.
        doubt: The factor by which S2's noise then always counts.
    """
    weight = 1.0 - 1.0 / doubt
    return replace(parameters, {f"aggregator.weight.{each}": weight for each in WEIGHTS})


def ratio(row: dict[str, Any]) -> float:
    """Return our error over that of the best baseline; of hostile kinds, the best sensor."""
    names = SINGLE if row["kind"] in HOSTILE else row["others"]
    return float(row["ours"] / max(min(row["others"][each] for each in names), 1e-3))


def ratio_to_picked(row: dict[str, Any]) -> float:
    """Return our error over that of the baseline that did best on the first half."""
    return float(row["ours"] / max(row["others"][row["picked"]], 1e-3))


def line(row: dict[str, Any]) -> str:
    """Return a row of the table."""
    best = min(row["others"], key=row["others"].__getitem__)
    candidates = " ".join(f"{name[:4]} {x[2]:.4f}" for name, x in row["candidates"].items())
    return (
        f"{row['kind']:16}{row['seed']:4} {'truth' if row['truth'] else 'free ':6}"
        f"{ratio(row):6.2f}  ours {row['ours']:.4f} ({row['chosen'][:5]:5}) "
        f"constant {row['constant']:.4f}  "
        f"{best} {row['others'][best]:.4f}  {candidates}  r {row['correlation']:.2f} "
        f"1sd {row['sureness']['ours'][0]:.2f} 2sd {row['sureness']['ours'][1]:.2f} "
        f"{row['seconds']:.0f} s"
    )


def markdown(rows: list[dict[str, Any]]) -> list[str]:
    """Return a table of errors: a row per recording, one also without a truth."""
    lines = [
        "| recording | truth | better sensor | best baseline | ours | ratio | to that picked | "
        "constant |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for row in rows:
        best = min(row["others"], key=row["others"].__getitem__)
        lines.append(
            f"| {row['kind']} | {'yes' if row['truth'] else 'no'} | "
            f"{min(row['others'][each] for each in SINGLE):.3g} | "
            f"{row['others'][best]:.3g} `{best}` | {row['ours']:.3g} | {ratio(row):.2f} | "
            f"{ratio_to_picked(row):.2f} `{row['picked']}` | "
            f"{row['constant'] / max(row['ours'], TINY):.2f} |"
        )
    return lines


def sureness_table(rows: list[dict[str, Any]]) -> list[str]:
    """Return how far standard deviations hold: a row per recording, one also without a truth."""
    lines = [
        "| recording | truth | within 1 | within 2 | log-likelihood | `kalman_bias` | "
        "best baseline |",
        "|---|---|---|---|---|---|---|",
    ]
    for row in rows:
        known = dict(row["sureness"])
        within_1, within_2, ours = known.pop("ours")
        best = min(known, key=lambda name: np.nan_to_num(known[name][2], nan=np.inf))
        lines.append(
            f"| {row['kind']} | {'yes' if row['truth'] else 'no'} | {within_1:.2f} | "
            f"{within_2:.2f} | {-ours:.2f} | {-known['kalman_bias'][2]:.2f} | "
            f"{-known[best][2]:.2f} `{best}` |"
        )
    return lines


def predictor_table(rows: list[dict[str, Any]]) -> list[str]:
    """Return the error with the predictor over that without: a row per recording with a truth."""
    return [
        "| recording | first half | other half |",
        "|---|---|---|",
        *(
            f"| {row['kind']} | {row['predictor'][0]:.3f} | {row['predictor'][1]:.3f} |"
            for row in rows
            if row["truth"]
        ),
    ]


def summed(rows: list[dict[str, Any]]) -> str:
    """Return what ratios come to."""
    ratios = np.array([ratio(each) for each in rows])
    if rows[0]["kind"] in HOSTILE:
        return f"{np.sum(ratios <= NO_WORSE)} of {ratios.size} no worse than the best sensor"
    picked = np.array([ratio_to_picked(each) for each in rows])
    return (
        f"ours over the best baseline {geometric_mean(ratios):.3f} (geometric mean), worst "
        f"{ratios.max():.2f}; {np.sum(ratios <= ENOUGH)} of {ratios.size} at most {ENOUGH:g}; "
        f"over that picked on the first half {geometric_mean(picked):.3f}, worst {picked.max():.2f}"
        f"; {sum(map(is_sure, rows))} of {ratios.size} standard deviations hold"
    )


def is_sure(row: dict[str, Any]) -> bool:
    """Return whether neither too few nor too many errors are within one and two deviations."""
    within_1, within_2, _ = row["sureness"]["ours"]
    return bool(0.55 <= within_1 <= 0.85 and within_2 >= 0.88)


def geometric_mean(ratios: Reals) -> float:
    """Return the geometric mean."""
    return float(np.exp(np.mean(np.log(ratios))))


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", default="0", help="one, or FIRST-LAST")
    parser.add_argument("--kinds", nargs="*", help="all unless given")
    parser.add_argument("--csv", nargs="*", type=Path, default=[], help="recordings instead")
    parser.add_argument("--bags", nargs="*", type=Path, default=[], help="bags with a truth")
    parser.add_argument("--with-truth", action="store_true", help="only with the truth")
    parser.add_argument("--markdown", action="store_true", help="tables at the end")
    parser.add_argument("--json", metavar="FILE")
    return parser


if __name__ == "__main__":
    main()
