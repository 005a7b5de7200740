# SPDX-License-Identifier: Apache-2.0
"""The demo: a real drive scored; the pendulum balanced over DDS, recorded, replayed and scored.

pendulum_node and fusion_node run in processes of their own and close the loop in lockstep. Their
recording is replayed, and the run simulated in this process: both must be the live run, bit for
bit. The baselines have the parameters that ``tune`` fitted to bags/nominal, and to the first half
of the real drive, which is scored on its second.
"""

from __future__ import annotations

import contextlib
import shutil
import signal
import tempfile
import time
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np

from fuzzy_fusion_ros.bag import open_bag
from fuzzy_fusion_ros.baselines import BaselineParameters, methods
from fuzzy_fusion_ros.batch.arrays import (
    integral_absolute_error,
    integral_time_absolute_error,
    seconds_since,
)
from fuzzy_fusion_ros.batch.compiled import interpreted
from fuzzy_fusion_ros.batch.series import fusion
from fuzzy_fusion_ros.jobs.parameter_file import baseline_parameters
from fuzzy_fusion_ros.jobs.progress import SILENT, Progress
from fuzzy_fusion_ros.jobs.replay import replay
from fuzzy_fusion_ros.jobs.score import score
from fuzzy_fusion_ros.jobs.shared import shared_folders
from fuzzy_fusion_ros.messages.outputs import EXPLANATION
from fuzzy_fusion_ros.offline.replay import differences
from fuzzy_fusion_ros.offline.topics import Topics
from fuzzy_fusion_ros.parameters.errors import BagError, FusionError
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import replace
from fuzzy_fusion_ros.parameters.writing import writing
from fuzzy_fusion_ros.scoring.score import Score, score_bag
from fuzzy_fusion_ros.simulation.closed_loop import Run, simulate
from fuzzy_fusion_ros.simulation.scenario import Scenario

SECONDS = 50.0
LONGEST = 300.0
"""Seconds that the live run may take on a busy machine."""

LOOK = 0.5
"""Seconds between looks at how far the live run is."""

PARAMETERS = {"trigger": "pair", "qos": "reliable"}
"""What makes a live run repeatable: no sample is lost, and none counts before its partner."""

LIVE, EXPLAINED, REPLAYED = "live", "live_fusion", "replayed"
REAL, NOMINAL = "car_accel", "nominal"
UNSEEN = 300.0
"""The fit to the real drive has not seen it from here on, seconds."""


class DemoError(FusionError):
    """Something that the demo needs is missing, or a node has failed."""


class ClosedLoop(NamedTuple):
    """How well the pendulum is balanced on a signal.

    Attributes:
        signal: The signal that the controller acts on.
        iae: Eq. (14): the integral of the angle's magnitude, rad s.
        itae: Eq. (15): that integral weighted by time, rad s^2.
    """

    signal: str
    iae: float
    itae: float


class DemoResult(NamedTuple):
    """What the demo found.

    Attributes:
        differences: How replay and simulation differ from the live run, one line each.
        car: The scores on the real drive.
        pendulum: The scores on the live run, which the estimate balances.
        loops: The pendulum, balanced on each signal.
    """

    differences: list[str]
    car: Score
    pendulum: Score
    loops: list[ClosedLoop]


def demo(
    output: str | Path, *, seed: int = 0, seconds: float = SECONDS, progress: Progress = SILENT
) -> DemoResult:
    """Run the demo; leave bags and plots.

    Args:
        output: Directory for bags and plots; those of an earlier demo are replaced.
        seed: Seed of the sensors' noise.
        seconds: Length of the run, simulated time.
        progress: Shows progress; none is shown unless given.

    Raises:
        FusionError: ROS is missing, a node has failed, or the output cannot be used.
    """
    bags, folder = real_bags(), Path(output)
    with writing(output):
        folder.mkdir(parents=True, exist_ok=True)
        for name in (LIVE, EXPLAINED, REPLAYED):
            _remove_bag(folder / name)
    run_live(folder, seed, seconds, progress)  # first: without ROS it fails at once
    car = score(
        bags / REAL,
        parameters=bags / f"{REAL}.yaml",
        start=UNSEEN,
        unit="m/s^2",
        progress=progress,
    )._replace(name=REAL)
    parameters = replace(Parameters(), PARAMETERS)
    replay(folder / LIVE, folder / REPLAYED, parameters=parameters, progress=progress)
    found = differences(folder / LIVE, folder / REPLAYED, ["/s1", "/s2", "/truth", "/estimate"])
    explained = ["/estimate", *(f"/fusion_node/{name}" for name in EXPLANATION)]
    found += differences(folder / EXPLAINED, folder / REPLAYED, explained)
    pendulum = _score_pendulum(folder / REPLAYED, parameters, bags, progress)
    runs = dict(progress.over(_simulated(parameters, seed, seconds), "simulate", 4))
    if not np.array_equal(runs["estimate"].truth, pendulum.truth):
        found.append("/truth differs from the simulation in this process")
    _plot([car, pendulum], folder, progress)
    return DemoResult(found, car, pendulum, [_loop(name, each) for name, each in runs.items()])


def run_live(output: Path, seed: int, seconds: float, progress: Progress = SILENT) -> None:
    """Close the loop over DDS between two processes, both of which record.

    Args:
        output: Directory for the two bags.
        seed: Seed of the sensors' noise.
        seconds: Length of the run, simulated time.
        progress: Shows progress; none is shown unless given.

    Raises:
        DemoError: ROS 2 is missing, or a node has failed.
    """
    try:
        from fuzzy_fusion_ros.testing import Process, claimed_domain
    except ImportError as error:
        raise DemoError(
            f"needs ROS 2: {error}; source it, or run make demo, which gets it from PyPI"
        ) from None
    with claimed_domain() as domain, tempfile.TemporaryDirectory() as logs:
        environment = {
            "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
            "ROS_DOMAIN_ID": str(domain),
            "ROS_LOG_DIR": logs,
        }
        settings = {**PARAMETERS, "record": str(output / EXPLAINED)}
        plant = {"duration": seconds, "seed": seed, "record": str(output / LIVE)}
        with (
            Process("fusion_node", *_as_arguments(settings), environment=environment) as node,
            Process("pendulum_node", *_as_arguments(plant), environment=environment) as pendulum,
            progress.counted("live", " s") as advance,
        ):
            deadline = time.monotonic() + LONGEST
            while pendulum.status is None:
                if node.status is not None:
                    raise DemoError(f"fusion_node has exited: {_last_line(node.stderr)}")
                if time.monotonic() > deadline:
                    raise DemoError(f"the live run did not end within {LONGEST:g} s")
                with contextlib.suppress(TimeoutError):
                    pendulum.wait(LOOK)
                advance(_recorded(output / LIVE), round(seconds))
            if pendulum.status != 0:
                raise DemoError(f"pendulum_node has failed: {_last_line(pendulum.stderr)}")
            node.send(signal.SIGINT)
            if node.wait() != 0:
                raise DemoError(f"fusion_node has failed: {_last_line(node.stderr)}")


def real_bags() -> Path:
    """Return the directory of the recordings: next to the sources, else where it is installed.

    Raises:
        DemoError: It is in neither place.
    """
    folders = shared_folders("bags")
    found = next((folder for folder in folders if (folder / REAL).is_dir()), None)
    if found is None:
        raise DemoError(f"bag {REAL!r} was not found in {', '.join(map(str, folders))}")
    return found


def _remove_bag(path: Path) -> None:
    """Remove a bag that an earlier demo left; refuse to remove anything else."""
    if path.exists():
        if not (path / "metadata.yaml").exists():
            raise DemoError(f"{str(path)!r} is not a bag: remove it, or choose another --output")
        shutil.rmtree(path)


def _as_arguments(parameters: Mapping[str, object]) -> list[str]:
    given = [f"{name}:={value}" for name, value in parameters.items()]
    return ["--ros-args", *(word for each in given for word in ("-p", each))]


def _recorded(path: Path) -> int:
    """Return the length of a growing recording, in whole seconds."""
    with contextlib.suppress(BagError), open_bag(path) as bag:
        return round(((bag.end_ns or 0) - (bag.start_ns or 0)) * 1e-9)
    return 0


def _score_pendulum(path: Path, parameters: Parameters, bags: Path, progress: Progress) -> Score:
    """Score the live run, with the baselines as fitted to another run of the pendulum."""
    baselines = baseline_parameters(bags / f"{NOMINAL}.yaml")
    scored = score_bag(
        path,
        Topics(),
        parameters,
        baselines,
        progress=progress.reading(f"reading {path.name}"),
    )
    return scored._replace(name="pendulum", unit="rad")


def _simulated(parameters: Parameters, seed: int, seconds: float) -> Iterator[tuple[str, Run]]:
    """Yield a run balanced on each signal, all of which meet the same noise."""
    scenario = replace(Scenario(), {"duration": seconds})
    others = methods(BaselineParameters())
    signals = {"estimate": fusion(parameters)}
    signals |= {name: others[name] for name in ("s1", "s2", "average")}
    for name, method in signals.items():
        generator = np.random.default_rng(seed)
        yield name, simulate(method, scenario, generator, bind=interpreted)


def _loop(signal: str, run: Run) -> ClosedLoop:
    time_s = seconds_since(int(run.stamps_ns[0]), run.stamps_ns)
    return ClosedLoop(
        signal,
        integral_absolute_error(time_s, run.truth),
        integral_time_absolute_error(time_s, run.truth),
    )


def _plot(scores: list[Score], output: Path, progress: Progress) -> None:
    from fuzzy_fusion_ros.plots.traces import plot_score  # takes time to import

    for each in progress.over(scores, "plot"):
        plot_score(each, output / f"{each.name}.png")


def _last_line(said: str) -> str:
    return (said.strip().splitlines() or ["it printed nothing"])[-1]
