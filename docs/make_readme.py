# SPDX-License-Identifier: Apache-2.0
"""Fills the README's tables and pictures with what the commands print: ``make docs``."""

from __future__ import annotations

import json
import re
import shutil
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from pictures import shrink

from fuzzy_fusion_ros import Parameters, plot_score, score, tune
from fuzzy_fusion_ros.scoring.score import Score

ROOT = Path(__file__).parents[1]
README = ROOT / "README.md"
IMAGES = ROOT / "docs" / "images"

METHODS = {
    "ideal": "ideal sensor",
    "s1": "S1 alone",
    "s2": "S2 alone",
    "average": "average of S1 and S2",
    "complementary": "complementary filter",
    "kalman": "Kalman filter that knows plant and sensors",
    "no_drift": "fuzzy aggregator without drift",
    "aggregator": "fuzzy aggregator",
    "complete": "fuzzy aggregator and predictor",
}
FILTERS = {
    "s1": "S1",
    "s2": "S2, held",
    "average": "average",
    "constant_weight": "best constant weight",
    "complementary": "complementary filter",
    "complementary_lowpass": "complementary filter, S1 low-passed first",
    "kalman": "Kalman filter, random walk",
    "kalman_bias": "Kalman filter with S1's bias as a state",
    "kalman_lag": "Kalman filter with S1's bias and S2's lag as states",
    "kalman_lag_cv": "the same, the signal with a velocity",
    "error_state": "error-state filter: S1's bias from S2, through its lag",
    "estimate": "this package",
}
PARTS = {
    "bias": "the observer: S1 minus its bias, learnt from S2",
    "slope": "the observer with a slope of the bias",
    "full": "the observer, S2 trusted by the rules",
}
CAR = "bags/car_accel"
PARAMETERS = f"{CAR}.yaml"
HALF = 300.0
"""PARAMETERS were tuned on what comes before, seconds; the rest is scored."""


def main() -> None:
    """Rewrite the README's tables and pictures."""
    with tempfile.TemporaryDirectory() as scratch:
        results = Path(scratch, "paper.json")
        call("reproduce", "--output", scratch, "--json", str(results), allowed=(0, 1))
        shutil.copy(Path(scratch, "fig18.png"), IMAGES)
        runs = json.loads(results.read_text())["runs"]
        draw_minute(Path(scratch, "car_accel.png"))
        shrink(Path(scratch, "car_accel.png"), IMAGES / "car_accel.png")
    on_half = score(ROOT / CAR, parameters=ROOT / PARAMETERS, start=HALF)
    text = README.read_text()
    text = filled(text, "reproduce: nominal", nominal_table(runs))
    text = filled(text, "demo: car_accel", car_table(on_half))
    text = filled(text, "parts: car_accel", parts_table(on_half))
    README.write_text(text)


def draw_minute(path: Path) -> None:
    """Draw a lively minute of the drive."""
    found = score(ROOT / CAR, parameters=ROOT / PARAMETERS, start=460.0, end=520.0, unit="m/s^2")
    plot_score(found._replace(behind={}), path)


def call(*arguments: str, allowed: Sequence[int] = (0,)) -> None:
    """Run a command; end with its status if that is not allowed."""
    done = subprocess.run(
        ["fuzzy-fusion", *arguments], cwd=ROOT, stdout=subprocess.DEVNULL, check=False
    )
    if done.returncode not in allowed:
        sys.exit(done.returncode)


def filled(text: str, marker: str, rows: Iterable[str]) -> str:
    """Put rows between a marker and the next end."""
    pattern = re.compile(rf"(<!-- {re.escape(marker)} -->\n).*?(<!-- end -->)", re.DOTALL)
    return pattern.sub(lambda found: found[1] + "\n".join(rows) + "\n" + found[2], text)


def nominal_table(runs: Sequence[dict[str, Any]]) -> Iterable[str]:
    """Yield the rows of the benchmark's nominal point."""
    yield "| balanced on | IAE, rad s | ITAE, rad s² | RMS error of the estimate, rad |"
    yield "|---|---|---|---|"
    for method, name in METHODS.items():
        at = [r for r in runs if r["method"] == method and is_nominal(r)]
        means = [statistics.fmean(r[key] for r in at) for key in ("iae", "itae", "rmse")]
        yield f"| {name} | {means[0]:.3g} | {means[1]:.3g} | {means[2]:.2g} |"


def is_nominal(run: dict[str, Any]) -> bool:
    """Return whether a run is at the benchmark's nominal point."""
    return (run["tau2"], run["sigma1"], run["bias1"]) == (0.2, 0.05, -0.03)


def car_table(on_half: Score) -> Iterable[str]:
    """Yield the rows of the real recording, every filter as it was tuned."""
    yield "| filter | RMS error, m/s² |"
    yield "|---|---|"
    for key, name in FILTERS.items():
        yield f"| {name} | {rmse(on_half, key):.3f} |"


def parts_table(on_half: Score) -> Iterable[str]:
    """Yield the rows of what each part of the fusion reaches on its own, tuned like the whole."""
    tuned = tune(ROOT / CAR, end=HALF).tuned
    kalman = "kalman_bias"
    rows = [("the defaults, which are the pendulum's", tuned.before_error, part(Parameters()))]
    rows += [
        (PARTS.get(each.name, each.text), each.fitted, part(each.parameters))
        for each in tuned.candidates
    ]
    rows += [(FILTERS[kalman], tuned.baseline_errors[kalman], rmse(on_half, kalman))]
    yield "| RMS error, m/s² | first half, tuned on | second half |"
    yield "|---|---|---|"
    for text, fitted, unseen in rows:
        yield f"| {text} | {fitted:.3f} | {unseen:.3f} |"


def part(parameters: Parameters) -> float:
    """Return what the fusion reaches on the second half with some parameters."""
    on_half = score(ROOT / CAR, parameters=parameters, start=HALF, fit_baselines=False)
    return rmse(on_half, "estimate")


def rmse(found: Score, estimator: str) -> float:
    """Return the root mean square error of an estimator."""
    return found.scores(estimator)["rmse"]


if __name__ == "__main__":
    main()
