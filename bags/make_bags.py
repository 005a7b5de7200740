# SPDX-License-Identifier: Apache-2.0
"""Makes the recordings in this folder, and the table of them in README.md.

    python bags/make_bags.py [--car CSV]

The simulated ones are what ``pendulum_node`` and ``fusion_node`` publish in lockstep, message by
message. The real one is made from the CSV files named in README.md, and left as it is without
them. The same input gives the same messages.
"""

from __future__ import annotations

import argparse
import csv
import hashlib
import shutil
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from fuzzy_fusion_ros.bag import BagWriter, jazzy_types, offered_qos, open_bag
from fuzzy_fusion_ros.baselines import ConstantWeightParameters, constant_weight
from fuzzy_fusion_ros.batch.series import Method, fusion
from fuzzy_fusion_ros.core.sample import Sample
from fuzzy_fusion_ros.messages.outputs import POINT, point_template
from fuzzy_fusion_ros.online.fusion import Fused, Fusion
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import replace
from fuzzy_fusion_ros.simulation.closed_loop import Run, simulate
from fuzzy_fusion_ros.simulation.scenario import START_NS, Scenario

HERE = Path(__file__).resolve().parent
SEED = 0
BEGIN, END = "<!-- made by make_bags.py: -->\n", "<!-- end -->\n"


class Simulated(NamedTuple):
    """A recording of the benchmark.

    Attributes:
        method: What the controller acts on.
        parameters: Of the fusion, which runs along in any case.
        text: What it shows.
    """

    method: Method
    parameters: Parameters
    text: str


def simulated() -> dict[str, Simulated]:
    """Return the simulated recordings by name."""
    plain = Parameters()
    predicting = replace(plain, {"predictor.enabled": True})
    shares = {"s1": 1.0, "s2": 0.0, "average": 0.5}
    return {
        "nominal": Simulated(fusion(plain), plain, "feedback on the estimate, no predictor"),
        "nominal_predictor": Simulated(
            fusion(predicting), predicting, "feedback on the estimate, with the predictor"
        ),
        **{
            f"feedback_{name}": Simulated(
                constant_weight(ConstantWeightParameters(share)),
                plain,
                f"feedback on {'the average of S1 and S2' if name == 'average' else name.upper()}",
            )
            for name, share in shares.items()
        },
    }


def write_simulated(path: Path, recording: Simulated, seed: int = SEED) -> None:
    """Run the benchmark and write what the nodes would have published."""
    run = simulate(recording.method, Scenario(), np.random.default_rng(seed))
    with Recorder(path, ["/truth", "/s2", "/s1", "/estimate", "/control"]) as recorder:
        for k, fused in enumerate(estimates(run, recording.parameters)):
            stamp_ns = int(run.stamps_ns[k])
            recorder.write("/truth", stamp_ns, run.truth[k])
            recorder.write("/s2", stamp_ns, run.s2[k])
            recorder.write("/s1", stamp_ns, run.s1[k])
            recorder.write("/estimate", stamp_ns, fused.estimate.value)
            recorder.write("/control", stamp_ns, run.control[k])


def estimates(run: Run, parameters: Parameters) -> Iterator[Fused]:
    """Yield what the fusion says to the sensors of a run, sample by sample."""
    node = Fusion(parameters)
    for k in range(run.survived):
        stamp_ns = int(run.stamps_ns[k])
        node.on_s2(Sample(stamp_ns, float(run.s2[k])))
        yield from node.on_s1(Sample(stamp_ns, float(run.s1[k]))).estimates


def write_car(path: Path, source: Path) -> None:
    """Write the real recording: S1 and truth from one CSV, S2 at its own times from the other.

    Numbers are rounded to single precision, which all digits of the CSV survive and zstd likes.
    The truth, which is smooth, is written at every other sample.
    """
    rows: list[tuple[int, int, str, float]] = []
    samples = list(read_csv(source))
    for k, row in enumerate(samples):
        stamp_ns = START_NS + round(float(row["t"]) * 1e9)
        rows.append((stamp_ns, 2, "/s1", float(row["s1"])))
        if row["ref"] and (k % 2 == 0 or k == len(samples) - 1):
            rows.append((stamp_ns, 0, "/truth", float(row["ref"])))
    for row in read_csv(source.with_name(f"{source.stem}_s2.csv")):
        stamp_ns = START_NS + round(float(row["t"]) * 1e9)
        rows.append((stamp_ns, 1, "/s2", float(row["s2"])))
    with Recorder(path, ["/truth", "/s2", "/s1"]) as recorder:
        for stamp_ns, _, topic, value in sorted(rows):
            recorder.write(topic, stamp_ns, float(np.float32(value)))


def read_csv(path: Path) -> Iterator[dict[str, str]]:
    """Yield the rows of a CSV file."""
    with path.open(newline="", encoding="utf-8") as file:
        yield from csv.DictReader(file)


class Recorder:
    """Writes stamped scalars, each at its own stamp; a context manager."""

    def __init__(self, path: Path, topics: list[str]) -> None:
        shutil.rmtree(path, ignore_errors=True)
        self._point = point_template(jazzy_types())
        self._writer = BagWriter(path)
        for topic in topics:
            self._writer.add_topic(topic, POINT, qos=[offered_qos()])

    def __enter__(self) -> Recorder:
        return self

    def __exit__(self, *_: object) -> None:
        self._writer.close()

    def write(self, topic: str, stamp_ns: int, value: float) -> None:
        """Write a scalar."""
        self._writer.write(topic, POINT, stamp_ns, self._point.filled(value, stamp_ns))


def digest(path: Path) -> str:
    """Return the SHA-256 of a bag's messages: topic, time and bytes of each, in their order."""
    sha = hashlib.sha256()
    with open_bag(path) as bag:
        for message in bag.messages():
            sha.update(f"{message.topic} {message.log_ns} {len(message.data)}\n".encode())
            sha.update(message.data)
    return sha.hexdigest()


def table() -> str:
    """Return the table of the bags that are there, in Markdown."""
    texts = {name: recording.text for name, recording in simulated().items()}
    lines = ["| bag | what | messages | SHA-256 of the messages |", "|---|---|---|---|"]
    for name, text in {**texts, "car_accel": "forward acceleration of a road car"}.items():
        with open_bag(HERE / name) as bag:
            count = bag.message_count
        lines.append(f"| `{name}` | {text} | {count} | `{digest(HERE / name)}` |")
    return "\n".join(lines) + "\n"


def main(given: Sequence[str] | None = None) -> None:
    """Make the bags and the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--car", type=Path, metavar="CSV", help="car_accel.csv, its _s2 beside it")
    arguments = parser.parse_args(given)
    for name, recording in simulated().items():
        write_simulated(HERE / name, recording)
    if arguments.car is not None:
        write_car(HERE / "car_accel", arguments.car)
    readme = HERE / "README.md"
    before, _, rest = readme.read_text(encoding="utf-8").partition(BEGIN)
    readme.write_text(before + BEGIN + table() + END + rest.partition(END)[2], encoding="utf-8")


if __name__ == "__main__":
    main()
