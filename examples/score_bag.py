# SPDX-License-Identifier: Apache-2.0
"""Replays a recording with tuned parameters, scores the estimates and plots them.

    python examples/score_bag.py bags/car_accel bags/car_accel.yaml car_accel.png 300

The last argument is where scoring starts, in seconds: the parameters were tuned on what is before.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

from fuzzy_fusion_ros import plot_score, replay, score


def main(bag: str, parameters: str, plot: str, start: str = "0") -> None:
    """Print the RMS error of every estimator, the best first, and draw a plot."""
    with tempfile.TemporaryDirectory() as folder:
        replayed = Path(folder, "replayed")
        written = replay(bag, replayed, parameters=parameters).estimates
        found = score(replayed, parameters=parameters, start=float(start))
    print(f"{written} estimates written, {found.matched} scored")
    rmse = {name: found.scores(name)["rmse"] for name in found.values}
    for name in sorted(rmse, key=rmse.__getitem__):
        print(f"{name:22} {rmse[name]:.3f}")
    plot_score(found, plot)


if __name__ == "__main__":
    main(*sys.argv[1:])
