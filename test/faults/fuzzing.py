# SPDX-License-Identifier: Apache-2.0
"""Fuzzing, case by case: the tests run a few hundred of each kind, the soak all."""

from __future__ import annotations

import contextlib
import math
import random
import shutil
from collections import Counter
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from faults.commands import mannerly, no_hang
from faults.fusing import CONDITIONING, run
from faults.mutations import CHANGES_MESSAGES, Original, mutated
from faults.streams import Stream
from fuzzy_fusion_ros.bag import jazzy_types, open_bag
from fuzzy_fusion_ros.cli import replay, score
from fuzzy_fusion_ros.messages import InstalledTypes, ScalarCodec
from fuzzy_fusion_ros.parameters.errors import FusionError, MessageError, ParameterError
from fuzzy_fusion_ros.parameters.file import parameters_from
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import Descriptor, descriptors, replace


def spoilt_bags(whole: Original, scratch: Path, seeds: Iterable[int]) -> Counter[str]:
    """Read and replay spoilt copies of a bag; return how often each outcome came.

    Raises:
        AssertionError: A command misbehaved, or a message came out that had not gone in.
    """
    outcomes: Counter[str] = Counter()
    path, output = scratch / "bag", scratch / "replayed"
    for seed in seeds:
        name = mutated(whole, path, seed)
        shutil.rmtree(output, ignore_errors=True)
        command = replay.main if seed % 4 else score.main
        arguments = [str(path)] + (["--output", str(output)] if seed % 4 else [])
        end = mannerly(command, arguments)
        outcomes[f"{name}: {'read' if end.status == 0 else 'refused'}"] += 1
        with no_hang():
            found = read(path)
        if name not in CHANGES_MESSAGES:
            assert found <= whole.messages, (name, seed)
    return outcomes


def read(path: Path) -> set[bytes]:
    """Return the messages of a bag, after taking the number out of each that holds one."""
    found = set()
    codecs: dict[str, ScalarCodec] = {}
    with contextlib.suppress(FusionError), open_bag(path) as bag:
        for message in bag.messages():
            found.add(message.data)
            with contextlib.suppress(FusionError):
                if message.msgtype not in codecs:
                    codecs[message.msgtype] = ScalarCodec(bag.types, message.msgtype)
                codecs[message.msgtype].sample(message.data, 0)
    return found


NUMBERS: tuple[Any, ...] = (
    0,
    1,
    -1,
    0.0,
    1e-300,
    1e300,
    -1e300,
    1e19,
    math.nan,
    math.inf,
    2**63,
    True,
    "1",
    None,
    [1.0],
)


CHANNELS = (
    "roll", "pitch", "Yaw", "axis_2", "s1", "s2", "rate", "qos", "own", "channels", "", "a.b",
    "a b", "a__b", "_a", "a_", "2nd", "é", "\x00", "\n", "x" * 300, "use_sim_time",
)  # fmt: skip
USABLE = 4
"""How many of them are allowed."""


def parameter_sets(stream: Stream, seeds: Iterable[int]) -> Counter[str]:
    """Try parameter sets; what is accepted must fuse a stream to finite, bounded estimates.

    Half of them leave S1 as it comes; one in three has channels, most of these with names that
    are allowed.

    Returns:
        How many were refused and fused, and of how many estimates were compared with the sensors.

    Raises:
        AssertionError: It does not.
    """
    outcomes: Counter[str] = Counter()
    for seed in seeds:
        rng = random.Random(seed)
        wild = rng.random() < 0.3
        changes = {
            name: rng.choice(NUMBERS) if wild and rng.random() < 0.2 else within(each, rng)
            for name, each, _ in descriptors(Parameters)
            if rng.random() < 0.4 and each.kind not in (str, tuple)
        }
        if rng.random() < 0.5:
            changes = {name: each for name, each in changes.items() if name not in CONDITIONING}
        changes["trigger"] = rng.choice(("s1", "pair"))
        if rng.random() < 0.3:
            usual = rng.random() < 0.7
            names = rng.sample(CHANNELS[: USABLE if usual else None], rng.randint(1, 2))
            changes["channels"] = names
            changes |= {f"{name}.gate.tolerance": rng.random() for name in names[1:]}
        try:
            parameters = replace(Parameters(), changes)
        except ParameterError as error:
            one_line(error)
            outcomes["refused"] += 1
            continue
        for name, alone in parameters.by_channel().items():
            with no_hang():
                ran = run(alone, stream)
            outcomes["bounded"] += ran.bounded > 0
            outcomes["channels"] += name != ""
        outcomes["fused"] += 1
    return outcomes


def one_line(error: FusionError) -> None:
    """Check that an error, as commands say it, is a line that can be read.

    Raises:
        AssertionError: It is not.
    """
    line = " ".join(str(error).split())
    assert line.isprintable(), repr(line)
    assert len(line) < 20_000, line[:200]


def within(descriptor: Descriptor, rng: random.Random) -> Any:
    """Return a value that a parameter may have, its extremes often."""
    if descriptor.kind is bool:
        return rng.random() < 0.5
    low, high = descriptor.low, descriptor.high
    if descriptor.kind is int:
        return rng.randint(int(low), int(min(high, 60)))
    top = min(high, 1e6)
    if rng.random() < 0.2:
        return float(rng.choice((low, top)))
    return min(top, max(low, 10 ** rng.uniform(-4, 2)))


WORDS = (
    "fusion_node", "/**", "ros__parameters", "s1", "s2.timeout", "timeout", "aggregator", ":",
    " ", "\n  ", "\n    ", "\n", "-", "[", "]", "{", "}", "1e5", "0x1F", "010", ".nan", "y", "'",
    '"', "#", "&a", "*a", "!!python/object:os.system", "!!float", "|", ">", "?", "---", "\t", "%",
    "<<", "<<: *a", "[" * 300, "- " * 60, "{a: " * 300, "\x85", "é", "\x00",
    "1" * 5000, "trigger: pair", "rate: -1", "@",
)  # fmt: skip


def parameter_files(example: str, path: Path, seeds: Iterable[int]) -> Counter[str]:
    """Read spoilt parameter files.

    Raises:
        FusionError: Of any kind but that of parameters.
    """
    outcomes: Counter[str] = Counter()
    for seed in seeds:
        path.write_bytes(spoilt_text(example, random.Random(seed)))
        try:
            with no_hang():
                parameters_from(path)
        except ParameterError as error:
            one_line(error)
            outcomes["refused"] += 1
        else:
            outcomes["read"] += 1
    return outcomes


def spoilt_text(example: str, rng: random.Random) -> bytes:
    """Return an example with words put in and taken out, words alone, or with broken bytes."""
    kind = rng.randrange(4)
    if kind == 0:
        return "".join(rng.choice(WORDS) for _ in range(rng.randrange(1, 30))).encode()
    text = example
    for _ in range(rng.randrange(1, 4)):
        at = rng.randrange(len(text))
        text = text[:at] + rng.choice(WORDS) + text[at + rng.choice((0, 0, 1, 5, 40)) :]
    data = text.encode()
    if kind == 1:
        at = rng.randrange(len(data))
        data = data[:at] + rng.randbytes(3) + data[at:]
    return data


PIECES = (
    "point", ".", "x", "[0]", "[", "]", "name", "=", ":", "position", "header", "stamp", "data",
    "[999999999999999999999]", "[-1]", "..", "", " ", "é", "0", "__class__", "\n", "(", "*", "sec",
    "covariance", "[35]", "linear_acceleration", "velocity", "frame_id",
)  # fmt: skip
TYPES = (
    "geometry_msgs/msg/PointStamped",
    "sensor_msgs/JointState",
    "sensor_msgs/msg/Imu",
    "nav_msgs/msg/Odometry",
    "std_msgs/msg/String",
    "std_msgs/msg/Empty",
    "no/msg/Such",
    "",
    "a/b/c/d",
    "../msg/X",
)


def field_paths(seeds: Iterable[int]) -> Counter[str]:
    """Resolve random paths in random types, and read with those that are accepted.

    Raises:
        FusionError: Of any kind but that of messages.
    """
    outcomes: Counter[str] = Counter()
    sources: list[Any] = [InstalledTypes(), jazzy_types()]
    for seed in seeds:
        rng = random.Random(seed)
        text = "".join(rng.choice(PIECES) for _ in range(rng.randrange(8)))
        try:
            with no_hang():
                codec = ScalarCodec(rng.choice(sources), rng.choice(TYPES), text)
                codec.sample(b"\0\1\0\0" + rng.randbytes(rng.randrange(200)), 0)
        except MessageError as error:
            one_line(error)
        outcomes["tried"] += 1
    return outcomes


OPTIONS = (
    "--params", "--s1", "--s2", "--estimate", "--truth", "--field", "--start", "--end", "--seed",
    "--json", "--plot", "--output", "--rate", "--loop", "--baseline", "--tolerance", "--unit",
    "--help=", "--nonsense", "-x", "--", "--rate=", "--start=-1",
)  # fmt: skip
VALUES = (
    "", "-", "0", "1", "-1", "nan", "\udcff", "\x1b[2J",
    "inf", "1e400", "0x10", "1" * 5000, "é", "/s1", "/s2", "/none",
    "s1=point.x", "s1=", "=", "/s9=x", "point.y", "data", "name=a:b", "/dev/null", "/", ".",
    "/proc/nowhere/at/all", "/proc/self/mem", "\x00", "\n", "%s", "{}", "--start",
)  # fmt: skip


def command_lines(
    mains: dict[str, Callable[..., int]], bag: Path, seeds: Iterable[int]
) -> Counter[str]:
    """Give commands random arguments, in an empty directory that is the working one.

    Raises:
        AssertionError: A command misbehaved.
    """
    outcomes: Counter[str] = Counter()
    for seed in seeds:
        rng = random.Random(seed)
        name = rng.choice(list(mains))
        words = [str(bag)] if rng.random() < 0.7 else []
        for _ in range(rng.randrange(6)):
            words += [rng.choice(OPTIONS)] if rng.random() < 0.8 else []
            words += [rng.choice(VALUES)] if rng.random() < 0.8 else []
        end = mannerly(mains[name], words)
        outcomes[f"{name}: {'done' if end.status == 0 else 'refused'}"] += 1
    return outcomes
