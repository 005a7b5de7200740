"""Bags spoilt in every way that a disk, a copy, a kill or a stranger can think of."""

from __future__ import annotations

import itertools
import random
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import yaml
from bag.making import BEGIN_NS, POINT, STEP_NS, chunk_ends, definition_text, point_data
from mcap.writer import MCAP0_MAGIC

from fuzzy_fusion_ros.bag import BagWriter, Definition

SAMPLES = 150
TYPES = (POINT, "std_msgs/msg/Float64", "sensor_msgs/msg/JointState", "sensor_msgs/msg/Imu")

Mutation = Callable[[Path, random.Random], None]
"""Spoils a bag directory in place."""


class Original(NamedTuple):
    """A whole bag.

    Attributes:
        path: Its directory.
        messages: The bytes of all its messages.
    """

    path: Path
    messages: frozenset[bytes]


def original(path: Path) -> Original:
    """Write the bag that is to be spoilt: both sensors, three chunks."""
    messages = []
    with BagWriter(path) as writer:
        for k in range(SAMPLES):
            for topic in ("/s2", "/s1"):
                stamp_ns = BEGIN_NS + k * STEP_NS * 2
                messages.append(point_data(stamp_ns, 0.01 * k + (topic == "/s1")))
                writer.write(topic, POINT, stamp_ns, messages[-1])
    return Original(path, frozenset(messages))


def mutated(whole: Original, path: Path, seed: int) -> str:
    """Make a spoilt copy of a bag; return the name of what was done to it."""
    rng = random.Random(seed)
    name = list(MUTATIONS)[seed % len(MUTATIONS)]
    shutil.rmtree(path, ignore_errors=True)
    shutil.copytree(whole.path, path)
    MUTATIONS[name](path, rng)
    return name


def _file(path: Path) -> Path:
    return next(path.glob("*.mcap"))


def _cut_at_a_chunk(path: Path, rng: random.Random) -> None:
    data = _file(path).read_bytes()
    end = rng.choice(chunk_ends(data)) + rng.choice((-9, -8, -1, 0, 0, 0, 1, 8, 9))
    _file(path).write_bytes(data[:end])


def _cut(path: Path, rng: random.Random) -> None:
    data = _file(path).read_bytes()
    _file(path).write_bytes(data[: rng.randrange(len(data))])


def _flip_bits(path: Path, rng: random.Random) -> None:
    data = bytearray(_file(path).read_bytes())
    for _ in range(rng.choice((1, 1, 2, 20))):
        data[rng.randrange(len(data))] ^= 1 << rng.randrange(8)
    _file(path).write_bytes(data)


def _zero_the_tail(path: Path, rng: random.Random) -> None:
    data = _file(path).read_bytes()
    keep = rng.randrange(len(data))
    more = rng.choice((0, 0, 5, 4096))
    _file(path).write_bytes(data[:keep] + bytes(len(data) - keep + more))


def _noise(path: Path, rng: random.Random) -> None:
    data = bytearray(_file(path).read_bytes())
    at = rng.randrange(len(data))
    data[at : at + rng.randrange(1, 60)] = rng.randbytes(rng.randrange(80))
    _file(path).write_bytes(data)


def _swap_chunks(path: Path, rng: random.Random) -> None:
    data = _file(path).read_bytes()
    ends = [0, *chunk_ends(data)]
    parts = [data[a:b] for a, b in itertools.pairwise(ends)]
    rng.shuffle(parts)
    _file(path).write_bytes(b"".join(parts) + data[ends[-1] :])


def _swap_schemas(path: Path, rng: random.Random) -> None:
    """Rewrite it: each topic claims a type, described as another, and holds a third."""
    shutil.rmtree(path)
    with BagWriter(path) as writer:
        msgtypes = {topic: rng.choice(TYPES) for topic in ("/s1", "/s2")}
        for topic, msgtype in msgtypes.items():
            text = definition_text(rng.choice(TYPES))
            if rng.random() < 0.3:
                at = rng.randrange(len(text))
                text = text[:at] + rng.choice(("", "\n", "[", "float64 x\n", "§")) + text[at + 3 :]
            encoding = rng.choice(("ros2msg", "ros2msg", "ros2idl", "", "protobuf"))
            writer.add_topic(topic, msgtype, definition=Definition(encoding, text))
        for k in range(SAMPLES):
            for topic, msgtype in msgtypes.items():
                data = point_data(BEGIN_NS + k * STEP_NS, 0.01 * k)
                if rng.random() < 0.02:
                    data = rng.randbytes(rng.randrange(60))
                writer.write(topic, msgtype, BEGIN_NS + k * STEP_NS, data)


NONSENSE: tuple[Any, ...] = ("", "nonsense", "2025-01-01", "../..", "/", -1, 10**30, 1.5, True)
WRONG: tuple[Any, ...] = (*NONSENSE, None, [], {}, [None])


def _wrong_metadata(path: Path, rng: random.Random) -> None:
    """Put something else into a random place of metadata.yaml."""
    file = path / "metadata.yaml"
    document = yaml.safe_load(file.read_text())
    for _ in range(rng.choice((1, 1, 3))):
        place = document
        while True:
            keys = list(place) if isinstance(place, dict) else range(len(place))
            if not keys:
                break
            key = rng.choice(list(keys))
            if isinstance(place[key], (dict, list)) and rng.random() < 0.8:
                place = place[key]
                continue
            if isinstance(place, dict) and rng.random() < 0.3:
                del place[key]
            else:
                place[key] = rng.choice(WRONG)
            break
    file.write_text(yaml.safe_dump(document))


def _spoilt_metadata(path: Path, rng: random.Random) -> None:
    file = path / "metadata.yaml"
    data = bytearray(file.read_bytes())
    at = rng.randrange(len(data))
    data[at : at + rng.randrange(20)] = rng.randbytes(rng.randrange(20))
    file.write_bytes(rng.choice((bytes(data), b"", data[:at])))


def _other_files(path: Path, rng: random.Random) -> None:
    what = rng.randrange(4)
    if what == 0:
        (path / "metadata.yaml").unlink()
    elif what == 1:
        _file(path).unlink()
    elif what == 2:
        shutil.copy(_file(path), path / f"bag_{rng.randrange(1, 4)}.mcap")
        (path / "metadata.yaml").unlink()
    else:
        _file(path).write_bytes(MCAP0_MAGIC * rng.randrange(4))


MUTATIONS: dict[str, Mutation] = {
    "cut at a chunk": _cut_at_a_chunk,
    "cut": _cut,
    "bits flipped": _flip_bits,
    "tail zeroed": _zero_the_tail,
    "noise": _noise,
    "chunks swapped": _swap_chunks,
    "schemas swapped": _swap_schemas,
    "metadata wrong": _wrong_metadata,
    "metadata spoilt": _spoilt_metadata,
    "files missing": _other_files,
}
"""Each by its name."""

KEEPS_MESSAGES = tuple(name for name in MUTATIONS if name != "schemas swapped")
"""With these no message comes out that did not go in."""
