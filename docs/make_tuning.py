# SPDX-License-Identifier: Apache-2.0
"""Makes the pictures and the table of docs/tuning.md: the commands that it shows, on a real drive.

python docs/make_tuning.py
"""

from __future__ import annotations

import json
import tempfile
from collections.abc import Iterator
from pathlib import Path

from pictures import shrink

from fuzzy_fusion_ros.cli.replay import main as replay
from fuzzy_fusion_ros.cli.score import main as score
from fuzzy_fusion_ros.cli.tune import main as tune

HERE = Path(__file__).resolve().parent
BAG = HERE.parent / "bags" / "car_accel"
HALF = "300"
BEGIN, END = "<!-- made by make_tuning.py: -->\n", "<!-- end -->\n"


def main() -> None:
    """Tune on the first half, score on the second, with and without the truth."""
    with tempfile.TemporaryDirectory() as folder:
        runs = {
            "with the truth": _run(Path(folder, "with"), []),
            "without": _run(Path(folder, "without"), ["--no-truth"]),
        }
        for name in ("tune", "score"):
            shrink(Path(folder, "with", f"{name}.png"), HERE / "images" / f"{name}_car_accel.png")
    page = HERE / "tuning.md"
    before, _, rest = page.read_text(encoding="utf-8").partition(BEGIN)
    table = "\n".join(_table(runs)) + "\n"
    page.write_text(before + BEGIN + table + END + rest.partition(END)[2], encoding="utf-8")


def _run(folder: Path, more: list[str]) -> dict[str, float]:
    """Return the RMSE of every estimator on the second half."""
    folder.mkdir()
    params, replayed, scores = folder / "tuned.yaml", folder / "replayed", folder / "score.json"
    span = ["--start", "0", "--end", HALF]
    drawn = ["--unit", "m/s^2", "--plot", str(folder / "tune.png")]
    assert tune([str(BAG), *span, *more, *drawn, "--output", str(params)]) == 0
    assert replay([str(BAG), "--params", str(params), "--output", str(replayed)]) == 0
    common = ["--params", str(params), "--unit", "m/s^2", "--plot", str(folder / "score.png")]
    assert score([str(replayed), "--start", HALF, *common, "--json", str(scores)]) == 0
    estimators = json.loads(scores.read_text(encoding="utf-8"))["estimators"]
    return {name: each["rmse"] for name, each in estimators.items()}


def _table(runs: dict[str, dict[str, float]]) -> Iterator[str]:
    yield f"| RMSE on the second half, m/s² | {' | '.join(f'tuned {name}' for name in runs)} |"
    yield "|---|" + "---|" * len(runs)
    for estimator in next(iter(runs.values())):
        yield (
            f"| `{estimator}` | " + " | ".join(f"{x[estimator]:.3f}" for x in runs.values()) + " |"
        )


if __name__ == "__main__":
    main()
