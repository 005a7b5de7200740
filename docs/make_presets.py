# SPDX-License-Identifier: Apache-2.0
"""Makes the table of presets in docs/fusion_node.md: errors over simulated sensors.

PYTHONPATH=test python docs/make_presets.py
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

from presets.sensors import RIGS, topics_of, write_rig

from fuzzy_fusion_ros.parameters.file import parameters_from
from fuzzy_fusion_ros.scoring.score import score_bag

PAGE = Path(__file__).resolve().parent / "fusion_node.md"
PRESETS = Path(__file__).resolve().parents[1] / "config" / "presets"
BEGIN, END = "<!-- made by make_presets.py: -->\n", "<!-- end -->\n"
JOBS = {
    "heading": ("yaw rate of an `Imu`", "course of a GNSS receiver, 1 Hz", "yaw of a pose", "rad"),
    "tilt": ("pitch rate of an `Imu`", "its accelerometer's pitch", "pitch of a pose", "rad"),
    "speed": (
        "wheel `Odometry`, 3 % off",
        "speed of a GNSS receiver, 1 Hz",
        "a twist with its variance",
        "m/s",
    ),
    "altitude": ("barometer", "`Range` down, 5 Hz", "a `Range` with its variance", "m"),
    "temperature": (
        "a quick probe, off by 1.5 K",
        "an accurate probe that lags by 3 s, 1 Hz",
        "a `Temperature` with its variance",
        "K",
    ),
    "three_axes": (
        "x, y and z of visual `Odometry`, which drifts",
        "of the GNSS `Odometry`, 5 Hz, in the worst axis",
        "all three of an `Odometry` with their variances",
        "m",
    ),
}
"""Of each preset: S1, S2, the estimate, and the unit."""


def main() -> None:
    """Write the table into the page."""
    before, _, rest = PAGE.read_text(encoding="utf-8").partition(BEGIN)
    table = "\n".join(_table()) + "\n"
    PAGE.write_text(before + BEGIN + table + END + rest.partition(END)[2], encoding="utf-8")


def _table() -> Iterator[str]:
    yield "| preset | S1 | S2 | estimate | RMSE of S2 held | of the estimate |"
    yield "|---|---|---|---|---|---|"
    for name, (s1, s2, estimate, unit) in JOBS.items():
        held, ours = _errors(name)
        errors = f"{held:.3f} {unit} | {ours:.3f} {unit}"
        yield f"| `{name}.yaml` | {s1} | {s2} | {estimate} | {errors} |"


def _errors(name: str) -> tuple[float, float]:
    rig, parameters = RIGS[name], parameters_from(PRESETS / f"{name}.yaml")
    with TemporaryDirectory() as folder:
        bag = write_rig(Path(folder) / "bag", rig)
        found = [
            score_bag(bag, topics_of(rig, channel), parameters.channel(channel))
            for channel in rig.truths
        ]
    held, ours = ([each.scores(name)["rmse"] for each in found] for name in ("s2", "estimate"))
    return max(held), max(ours)


if __name__ == "__main__":
    main()
