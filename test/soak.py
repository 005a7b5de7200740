# SPDX-License-Identifier: Apache-2.0
"""The faults of test/faults in their full form, as a table.

    make soak ARGS="kills links --scale 0.1"

Each part stops the run with a traceback where something is not as it must be.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import platform
import statistics
import subprocess
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from datetime import datetime, timezone
from pathlib import Path

from faults import fuzzing
from faults.cutting import cut_the_cable
from faults.endurance import run_over_dds, step
from faults.guided import fuzz
from faults.killing import LARGEST, expected_s1, kill
from faults.mutations import original
from faults.overload import flood
from faults.restarting import kill_the_fusion, kill_the_sensors
from faults.stopping import EXECUTABLES, SIGNALS, stop_at_random
from faults.streams import clean_stream

from fuzzy_fusion_ros.cli import replay, score, tune
from fuzzy_fusion_ros.testing import Harness

ROOT = Path(__file__).resolve().parents[1]
SEED = 1000

Rows = Iterable[str]
Part = Callable[[float, Path], Rows]
"""``(scale, folder) -> what was found``, one row each; ``scale`` 1 is the full form."""


def times(full: int, scale: float) -> int:
    """Return how often to do what is done ``full`` times in the full form."""
    return max(1, round(full * scale))


def bags(scale: float, folder: Path) -> Rows:
    """Spoilt bags."""
    cases = times(10_000, scale)
    outcomes = fuzzing.spoilt_bags(original(folder / "whole"), folder, range(cases))
    yield f"{cases} spoilt bags read, replayed or scored: {summary(outcomes)}"
    guided = fuzz(folder, cases, SEED)
    yield (
        f"{guided.cases} bags guided by coverage: {guided.kept} led to new code, "
        f"{guided.steps} pairs of lines seen, {guided.first_steps} by whole bags"
    )


def parameters(scale: float, folder: Path) -> Rows:
    """Parameter sets and files."""
    cases = times(10_000, scale)
    outcomes = fuzzing.parameter_sets(clean_stream(60, 3), range(cases))
    yield f"{cases} parameter sets: {summary(outcomes)}"
    example = (ROOT / "config/fusion_node.yaml").read_text(encoding="utf-8")
    outcomes = fuzzing.parameter_files(example, folder / "some.yaml", range(cases))
    yield f"{cases} parameter files: {summary(outcomes)}"


def arguments(scale: float, folder: Path) -> Rows:
    """Field paths and command lines."""
    cases = times(10_000, scale)
    yield f"{cases} field paths: {summary(fuzzing.field_paths(range(cases)))}"
    cases = times(2_000, scale)
    whole = original(folder / "whole")
    place = folder / "here"
    place.mkdir()
    back = Path.cwd()
    os.chdir(place)
    try:
        outcomes = fuzzing.command_lines(
            {"replay": replay.main, "score": score.main}, whole.path, range(cases)
        )
        outcomes += fuzzing.command_lines({"tune": tune.main}, whole.path, range(cases // 10))
    finally:
        os.chdir(back)
    yield f"{cases + cases // 10} command lines: {summary(outcomes)}"


def kills(scale: float, folder: Path) -> Rows:
    """SIGKILL of a recorder."""
    tries, whole = times(50, scale), expected_s1()
    with Harness() as harness:
        left = [kill(harness, folder / "run", SEED + k, whole) for k in range(tries)]
    messages = [each.messages for each in left]
    yield (
        f"{tries} recorders killed at up to {LARGEST} bytes: {min(messages)} to {max(messages)} "
        "messages, all whole chunks, each replayed"
    )


def restarts(scale: float, folder: Path) -> Rows:
    """SIGKILL of sensors and of the fusion."""
    tries = times(50, scale)
    with Harness() as harness:
        estimates = kill_the_sensors(harness, tries, SEED)
    yield (
        f"sensors killed and restarted {tries} times: fusing again each time, {estimates} estimates"
    )
    with Harness() as harness:
        estimates = kill_the_fusion(harness, tries, SEED)
    yield (
        f"fusion_node killed and restarted {tries} times: the pendulum stands, "
        f"{estimates} estimates"
    )


def links(scale: float, folder: Path) -> Rows:
    """A link that is cut."""
    tries = times(20, scale)
    estimates, gap = cut_the_cable(folder / "bag", tries, SEED)
    yield (
        f"link cut for 3 s {tries} times: S1_ONLY and FUSED again each time, {estimates} "
        f"estimates, never more than {gap:.2f} s apart"
    )


def stops(scale: float, folder: Path) -> Rows:
    """SIGINT and SIGTERM."""
    tries = times(100, scale)
    for name, executable in EXECUTABLES.items():
        ended = stop_at_random(executable, folder / name, tries, SEED, longest=1.5)
        bags = [each.messages for each in ended if each.messages is not None]
        if executable.records:
            yield f"{name}: {len(bags)} bags, all whole, {sum(map(bool, bags))} with messages"
        for number in SIGNALS:
            those = [each for each in ended if each.number is number]
            statuses = Counter(f"status {each.status}" for each in those)
            seconds = sorted(each.seconds for each in those)
            yield (
                f"{name}: {tries} {number.name} at random moments: {summary(statuses)}; end after "
                f"{statistics.median(seconds):.2f} s (median), {seconds[-1]:.2f} s at the latest"
            )


def overload(scale: float, folder: Path) -> Rows:
    """More than the node can take."""
    flooded = flood(60.0 * scale)
    yield (
        f"flood of {flooded.per_second:.0f} samples/s for {60.0 * scale:g} s: {flooded.received} "
        f"taken, {flooded.lost} counted as lost, 0 unaccounted for; memory +{flooded.growth:.1f} "
        f"MiB (second half +{flooded.late_growth:.1f}); the newest sample came out, recovery at "
        "once"
    )


def core(scale: float, folder: Path) -> Rows:
    """A long run in the core."""
    stepped = step(times(10_000_000, scale), SEED)
    yield (
        f"{stepped.samples} samples of S1 with a fault in each 200: {stepped.estimates} "
        f"estimates within their bound in {stepped.seconds:.0f} s; memory +{stepped.growth:.1f} "
        f"MiB (second half +{stepped.late_growth:.1f}), descriptors +{stepped.more_descriptors}"
    )


def dds(scale: float, folder: Path) -> Rows:
    """A long run over DDS."""
    ran = run_over_dds(1800.0 * scale, 1000.0, SEED)
    yield (
        f"{ran.seconds:.0f} s at {ran.rate:.0f} Hz over DDS with faults: {ran.estimates} "
        f"estimates equal to the core's bit for bit; memory of the node +{ran.growth:.1f} MiB "
        f"(second half +{ran.late_growth:.1f}), descriptors +{ran.more_descriptors}; median "
        f"latency {ran.first_latency:.2f} ms at the start, {ran.last_latency:.2f} ms at the end"
    )


PARTS: dict[str, Part] = {
    each.__name__: each
    for each in (
        bags,
        parameters,
        arguments,
        kills,
        restarts,
        links,
        stops,
        overload,
        core,
        dds,
    )
}


def summary(outcomes: Counter[str]) -> str:
    """Return outcomes in words: those of one ending added up."""
    ends: Counter[str] = Counter()
    for name, count in outcomes.items():
        ends[name.rpartition(": ")[2]] += count
    return ", ".join(f"{count} {name}" for name, count in sorted(ends.items()))


def machine() -> str:
    """Return where and when this runs, and what."""
    with contextlib.suppress(OSError):
        lines = Path("/proc/cpuinfo").read_text().splitlines()
        model = next((each.split(": ")[1] for each in lines if "model name" in each), "")
    commit = subprocess.run(
        ["git", "-C", ROOT, "describe", "--always", "--dirty"],
        capture_output=True,
        text=True,
        check=False,
    ).stdout.strip()
    day = datetime.now(tz=timezone.utc).date()
    return (
        f"{model or platform.machine()}, {os.cpu_count()} cores, "
        f"Python {platform.python_version()}; {day}; commit {commit}"
    )


def main(words: Sequence[str] | None = None) -> int:
    """Run parts and print a table of what was found."""
    parser = argparse.ArgumentParser("soak", description=__doc__)
    parser.add_argument("parts", nargs="*", metavar="PART", help=f"of {', '.join(PARTS)} {{all}}")
    parser.add_argument(
        "--scale", type=float, default=1.0, help="share of the full form {1: some hours}"
    )
    given = parser.parse_args(words)
    unknown = set(given.parts) - set(PARTS)
    if unknown:
        parser.error(f"no part {', '.join(sorted(unknown))}; there are {', '.join(PARTS)}")
    print(f"{machine()}; scale {given.scale:g}\n\n| part | found | s |\n|---|---|---|", flush=True)
    for name in given.parts or PARTS:
        with tempfile.TemporaryDirectory() as folder:
            begin = time.monotonic()
            for row in PARTS[name](given.scale, Path(folder)):
                print(f"| {name} | {row} | {time.monotonic() - begin:.0f} |", flush=True)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
