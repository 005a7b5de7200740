# SPDX-License-Identifier: Apache-2.0
"""Tunes on the first half of every stand-in and scores on the second, beside the baselines.

python test/tuning/evaluate.py --seeds 0-4

Or on recordings: CSV files with the columns ``t,s1,ref`` (``ref`` may be empty) and, beside each,
one with ``t,s2`` whose name ends in ``_s2``.

python test/tuning/evaluate.py --csv car_accel.csv --markdown

``constant`` is our error with the four weights of Table 1 replaced by the one that does best on the
first half.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from tuning.recordings import START_NS, Made
from tuning.standins import HOSTILE, STANDINS, standin

from fuzzy_fusion_ros.baselines import methods
from fuzzy_fusion_ros.batch.arrays import Flags
from fuzzy_fusion_ros.batch.series import Series, fusion, run, values
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import replace
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


def main() -> None:
    """Print a row per kind and mode, then what they come to."""
    given = _parser().parse_args()
    first, _, last = given.seeds.partition("-")
    rows = []
    chosen = [] if given.csv else given.kinds or [*STANDINS, *HOSTILE]
    kinds = [(name, seed) for name in chosen for seed in range(int(first), int(last or first) + 1)]
    cases = [(name, seed, standin(name, seed)) for name, seed in kinds]
    cases += [(path.stem, 0, recorded(path)) for path in given.csv]
    for name, seed, made in cases:
        rows += [evaluated(name, seed, made, with_truth) for with_truth in (True, False)]
        for row in rows[-2:]:
            print(line(row), flush=True)
    for title in ("stand-ins", "hostile", "recordings"):
        for with_truth in (True, False):
            these = [r for r in rows if title == group(r) and r["truth"] == with_truth]
            if these:
                print(f"{title}, {'with' if with_truth else 'without'} truth: {summed(these)}")
    if given.markdown:
        print("\n".join(markdown(rows)))
    if given.json:
        Path(given.json).write_text(json.dumps(rows, indent=1), encoding="utf-8")


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

    trace = run(fusion(tuned.parameters), series)
    scaled = (
        np.abs(trace.value - made.truth)[where] / np.maximum(trace.standard_deviation, TINY)[where]
    )
    return {
        "within": [float(np.mean(scaled <= factor)) for factor in (1.0, 2.0)],
        "kind": name,
        "seed": seed,
        "truth": with_truth,
        "ours": rmse(fusion(tuned.parameters)),
        "constant": rmse(fusion(constant)),
        "chosen": tuned.chosen,
        "correlation": tuned.sensors.lag.correlation,
        "others": {each: rmse(method) for each, method in methods(tuned.baselines).items()},
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


def line(row: dict[str, Any]) -> str:
    """Return a row of the table."""
    best = min(row["others"], key=row["others"].__getitem__)
    candidates = " ".join(f"{name[:4]} {x[2]:.4f}" for name, x in row["candidates"].items())
    return (
        f"{row['kind']:16}{row['seed']:4} {'truth' if row['truth'] else 'free ':6}"
        f"{ratio(row):6.2f}  ours {row['ours']:.4f} ({row['chosen'][:5]:5}) "
        f"constant {row['constant']:.4f}  "
        f"{best} {row['others'][best]:.4f}  {candidates}  r {row['correlation']:.2f} "
        f"1sd {row['within'][0]:.2f} 2sd {row['within'][1]:.2f} "
        f"{row['seconds']:.0f} s"
    )


def markdown(rows: list[dict[str, Any]]) -> list[str]:
    """Return a table with a row per recording, errors with a truth before those without."""
    lines = [
        "| recording | better sensor | best baseline | ours | ratio | "
        "best baseline, no truth | ours, no truth | ratio |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for with_truth, without in zip(rows[::2], rows[1::2], strict=True):
        sensor = min(with_truth["others"][each] for each in SINGLE)
        cells = [with_truth["kind"], f"{sensor:.3g}"]
        for row in (with_truth, without):
            best = min(row["others"], key=row["others"].__getitem__)
            cells += [
                f"{row['others'][best]:.3g} `{best}`",
                f"{row['ours']:.3g}",
                f"{row['ours'] / row['others'][best]:.2f}",
            ]
        lines.append("| " + " | ".join(cells) + " |")
    return lines


def summed(rows: list[dict[str, Any]]) -> str:
    """Return what ratios come to."""
    ratios = np.array([ratio(each) for each in rows])
    if rows[0]["kind"] in HOSTILE:
        return f"{np.sum(ratios <= NO_WORSE)} of {ratios.size} no worse than the best sensor"
    mean = float(np.exp(np.mean(np.log(ratios))))
    return (
        f"ours over the best baseline {mean:.3f} (geometric mean), worst {ratios.max():.2f}; "
        f"{np.sum(ratios <= ENOUGH)} of {ratios.size} at most {ENOUGH:g}"
    )


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", default="0", help="one, or FIRST-LAST")
    parser.add_argument("--kinds", nargs="*", help="all unless given")
    parser.add_argument("--csv", nargs="*", type=Path, default=[], help="recordings instead")
    parser.add_argument("--markdown", action="store_true", help="a table at the end")
    parser.add_argument("--json", metavar="FILE")
    return parser


if __name__ == "__main__":
    main()
