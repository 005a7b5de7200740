"""Balances the pendulum over DDS, records it, replays it bit for bit, and scores it.

pendulum_node and fusion_node run as processes of their own and close the loop in lockstep. The
recording goes through the same fusion offline, which must give the same bytes; then it is scored.
So is the drive of a real car that comes with the package, in its second half, with parameters that
tune fitted to the first. The baselines are those that tune fitted to bags/nominal and to that
first half. Plots are left beside the bags.
"""

from __future__ import annotations

import contextlib
import os
import shutil
import signal
import tempfile
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from fuzzy_fusion_ros.bag import BagMessage, open_bag
from fuzzy_fusion_ros.cli import options
from fuzzy_fusion_ros.cli.progress import bar, progress
from fuzzy_fusion_ros.cli.score import baselines_of
from fuzzy_fusion_ros.cli.status import DONE, FAILED, command, say
from fuzzy_fusion_ros.messages.outputs import EXPLANATION
from fuzzy_fusion_ros.offline.replay import differences, replay
from fuzzy_fusion_ros.offline.topics import Topics
from fuzzy_fusion_ros.parameters.errors import BagError, FusionError
from fuzzy_fusion_ros.parameters.file import parameters_from
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import replace
from fuzzy_fusion_ros.scoring.report import report
from fuzzy_fusion_ros.scoring.score import Score, score_bag

PACKAGE = "fuzzy_fusion_ros"
SECONDS = 50.0
LONGEST = 300.0
"""Seconds that the live run may take on a machine that has other things to do."""

PARAMETERS = {"trigger": "pair", "qos": "reliable"}
"""What makes a live run repeatable: no sample is lost, and none counts before its partner."""

LIVE, EXPLAINED, REPLAYED = "live", "live_fusion", "replayed"
REAL, NOMINAL = "car_accel", "nominal"
UNSEEN = 300.0
"""From here on, in seconds, the real recording was not seen by the fit."""


class DemoError(FusionError):
    """The demo lacks something, or a node has failed."""


class DemoResult(NamedTuple):
    """What the demo found.

    Attributes:
        differences: How replay and live run differ, one line each.
        scores: Those of the pendulum and of the real recording.
    """

    differences: list[str]
    scores: list[Score]


@command("demo")
def main(arguments: Sequence[str] | None = None) -> int:
    """Run the demo; return whether the replay is the live run."""
    parser = options.Parser("demo", __doc__)
    parser.add_argument(
        "--output",
        metavar="DIR",
        type=Path,
        default=Path("out/demo"),
        help="where bags and plots go {out/demo}",
    )
    options.add_seed(parser)
    given = parser.parse_args(arguments)
    outcome = demo(given.output, given.seed, SECONDS)
    print("\n\n".join(report([each]) for each in outcome.scores))
    for problem in outcome.differences:
        say("demo", f"the replay is not the live run: {problem}")
    if outcome.differences:
        return FAILED
    print("\nlive = replay, bit for bit: every estimate, and all that explains it")
    print(f"bags and plots are in {given.output}")
    return DONE


def demo(output: Path, seed: int, seconds: float) -> DemoResult:
    """Do the whole job.

    Args:
        output: Where bags and plots go; those of an earlier demo are replaced.
        seed: Of the sensors' noise.
        seconds: Length of the run, simulated.

    Raises:
        FusionError: A node, a bag or the output cannot be used.
    """
    real = real_bag()
    with options.writing(output):
        output.mkdir(parents=True, exist_ok=True)
        for name in (LIVE, EXPLAINED, REPLAYED):
            _remove_bag(output / name)
    run_live(output, seed, seconds)
    parameters = replace(Parameters(), PARAMETERS)
    with open_bag(output / LIVE) as bag:
        replay(
            bag,
            output / REPLAYED,
            Topics(),
            parameters,
            progress=lambda messages: progress(messages, "replay", bag.message_count, " messages"),
        )
    found = differences(output / LIVE, output / REPLAYED, ["/s1", "/s2", "/truth", "/estimate"])
    explained = ["/estimate", *(f"/fusion_node/{name}" for name in EXPLANATION)]
    found += differences(output / EXPLAINED, output / REPLAYED, explained)
    scores = [_score_pendulum(output / REPLAYED, parameters, real.parent), _score_car(real)]
    _plot(scores, output)
    return DemoResult(found, scores)


def run_live(output: Path, seed: int, seconds: float) -> None:
    """Close the loop over DDS between two processes, both recording.

    Raises:
        DemoError: ROS 2 is missing, or a node has failed.
    """
    try:
        from fuzzy_fusion_ros.testing import Process, claimed_domain
    except ImportError as error:
        raise DemoError(
            f"{error}: source ROS 2 Jazzy, or let make demo bring it from PyPI"
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
        ):
            _watch(lambda: node.status is None and pendulum.status is None, output, seconds)
            if node.status is not None:
                raise DemoError(f"fusion_node has ended: {_last_line(node.stderr)}")
            if pendulum.wait() != DONE:
                raise DemoError(f"pendulum_node has failed: {_last_line(pendulum.stderr)}")
            node.send(signal.SIGINT)
            if node.wait() != DONE:
                raise DemoError(f"fusion_node has failed: {_last_line(node.stderr)}")


def real_bag() -> Path:
    """Return the real recording: that beside the sources, else the installed one.

    Raises:
        DemoError: It is in neither place.
    """
    prefixes = filter(None, os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep))
    folders = [Path(__file__).parents[2] / "bags"]
    folders += [Path(prefix, "share", PACKAGE, "bags") for prefix in prefixes]
    found = next((folder / REAL for folder in folders if (folder / REAL).is_dir()), None)
    if found is None:
        raise DemoError(f"bag {REAL!r} is in none of {', '.join(map(str, folders))}")
    return found


def _remove_bag(path: Path) -> None:
    """Remove what an earlier demo left, if it is a bag indeed."""
    if path.exists():
        if not (path / "metadata.yaml").exists():
            raise DemoError(f"{str(path)!r} is no bag of a demo: remove it, or use --output")
        shutil.rmtree(path)


def _as_arguments(parameters: Mapping[str, object]) -> list[str]:
    given = [f"{name}:={value}" for name, value in parameters.items()]
    return ["--ros-args", *(word for each in given for word in ("-p", each))]


def _watch(running: Callable[[], bool], output: Path, seconds: float) -> None:
    """Wait for the end of the live run, and show how far its recording has come."""
    deadline = time.monotonic() + LONGEST
    with bar("live", round(seconds), " s") as shown:
        while running():
            if time.monotonic() > deadline:
                raise DemoError(f"the live run is not over after {LONGEST:g} s")
            time.sleep(0.1)
            if not shown.disable:
                shown.update(_recorded(output / LIVE) - shown.n)


def _recorded(path: Path) -> int:
    """Return how much of a growing recording there is, in whole seconds."""
    with contextlib.suppress(BagError), open_bag(path) as bag:
        return round(((bag.end_ns or 0) - (bag.start_ns or 0)) * 1e-9)
    return 0


def _score_pendulum(path: Path, parameters: Parameters, bags: Path) -> Score:
    """Score the recording; fitting the baselines here would take a good part of the minute."""
    baselines = baselines_of(str(bags / f"{NOMINAL}.yaml"))
    scored = score_bag(path, Topics(), parameters, baselines, progress=_reading)
    return scored._replace(name="pendulum", unit="rad")


def _score_car(path: Path) -> Score:
    file = path.with_suffix(".yaml")
    scored = score_bag(
        path,
        Topics(),
        parameters_from(file),
        baselines_of(str(file)),
        start_s=UNSEEN,
        progress=_reading,
    )
    return scored._replace(name=REAL, unit="m/s^2")


def _reading(messages: Iterable[BagMessage]) -> Iterable[BagMessage]:
    return progress(messages, "score", unit=" messages")


def _plot(scores: Sequence[Score], output: Path) -> None:
    from fuzzy_fusion_ros.plots.traces import plot_score  # costs start-up time

    for each in progress(scores, "plot"):
        plot_score(each, output / f"{each.name}.png")


def _last_line(said: str) -> str:
    return (said.strip().splitlines() or ["it said nothing"])[-1]
