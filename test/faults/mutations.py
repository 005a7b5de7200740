# SPDX-License-Identifier: Apache-2.0
"""Bags spoilt in every way that a disk, a copy, a kill or a stranger can think of."""

from __future__ import annotations

import contextlib
import itertools
import random
import shutil
import sqlite3
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import yaml
from bag.making import (
    BEGIN_NS,
    POINT,
    STEP_NS,
    Channel,
    chunk_ends,
    definition_text,
    point_data,
    write_by_rosbags,
    write_channels,
)
from mcap.writer import MCAP0_MAGIC
from rosbags.rosbag2 import StoragePlugin

from fuzzy_fusion_ros.bag import BagMessage, BagWriter, Definition, open_bag

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


PRIMITIVES = ("bool", "byte", "char", "int8", "uint64", "float32", "float64", "string", "wstring")
SIZES = ("", "", "[]", "[3]", "[<=4]", "[0]", "[100000]", "[1000000000]", f"[{10**25}]")
IDL = (
    "module", "struct", "typedef", "const", "enum", "sequence<", "double", "string", "B", "a::B",
    ";", "{", "}", "(", ")", "<", ">", "[", "]", "1", "9" * 50, "<<", "-", "+", "*", "/", "=",
    "@verbatim", "#include", '"', "//", "/*", "*/", "\n", " ", "::", "A",
)  # fmt: skip


def _odd_types(path: Path, rng: random.Random) -> None:
    """Rewrite it with types that are deep, wide, long, recursive or no types."""
    odd = rng.choice((("/s1",), ("/s2",), ("/other",)))
    topics = dict.fromkeys(("/s1", "/s2"), POINT) | dict.fromkeys(odd, "odd_msgs/msg/L0")
    shutil.rmtree(path)
    with BagWriter(path) as writer:
        for topic in odd:
            idl = rng.random() < 0.3
            text = " ".join(rng.choice(IDL) for _ in range(rng.randrange(200)))
            definition = Definition("ros2idl", text) if idl else Definition("ros2msg", _odd(rng))
            writer.add_topic(topic, "odd_msgs/msg/L0", definition=definition)
        for k in range(SAMPLES):
            for topic, msgtype in topics.items():
                data = point_data(BEGIN_NS + k * STEP_NS, 0.01 * k)
                writer.write(topic, msgtype, BEGIN_NS + k * STEP_NS, data)


def _odd(rng: random.Random) -> str:
    """Return a definition of several types that contain each other."""
    levels = rng.choice((1, 2, 5, 40))
    parts = []
    for level in range(levels):
        fields = rng.choice((0, 1, 2, 3, 3, 2000 if levels < 5 else 3))
        lines = []
        for k in range(fields):
            inner = f"odd_msgs/L{rng.choice((level + 1, level + 1, level + 1, level, 0, 99))}"
            kind = rng.choice((*PRIMITIVES, inner, inner, inner, inner, inner, "std_msgs/Header"))
            lines.append(f"{kind}{rng.choice(SIZES)} f{k}{rng.choice(('', '', '=1', ' 1', ' []'))}")
        rng.shuffle(lines)
        head = f"{'=' * 80}\nMSG: odd_msgs/L{level}\n" if level else "std_msgs/Header header\n"
        parts.append(head + "".join(f"{line}\n" for line in lines))
    return "".join(parts)


def _odd_names(path: Path, rng: random.Random) -> None:
    """Rewrite it with topics and types whose names are bytes, escapes or very long."""
    names = ("", "/", "s1", "/s1", "\x1b[2J", "/\n/s1", "\x9b", "é" * 3000, "/s2\0", "\u202e")
    types = (POINT, POINT, "", "a", "\x1b/msg/B", "a/B")
    definition = Definition("ros2msg", definition_text(POINT))
    shutil.rmtree(path)
    with BagWriter(path) as writer:
        for k in range(SAMPLES):
            for topic in ("/s1", "/s2", rng.choice(names)):
                data = point_data(BEGIN_NS + k * STEP_NS, 0.01 * k)
                msgtype = POINT if topic in {"/s1", "/s2"} else rng.choice(types)
                writer.add_topic(topic, msgtype, definition=definition)
                writer.write(topic, msgtype, BEGIN_NS + k * STEP_NS, data)
    changed = bytearray(_file(path).read_bytes())
    at = changed.rfind(b"/s1")
    changed[at + 1 : at + 2] = rng.choice((b"\xff", b"s", b"\0"))
    _file(path).write_bytes(changed)


def _odd_claims(path: Path, rng: random.Random) -> None:
    """Let chunks and their frames claim other sizes."""
    data = bytearray(_file(path).read_bytes())
    for end in [0, *chunk_ends(bytes(data))[:-1]]:
        at = data.find(b"\x28\xb5\x2f\xfd", end)
        if at < 0 or rng.random() < 0.5:
            continue
        size = rng.choice((0, 1, 1 << 20, 1 << 31, 1 << 40, (1 << 64) - 1))
        place = at + rng.choice((4, 5, 6, -8, -24, -28))  # its header, or what the chunk says of it
        width = rng.choice((1, 2, 4, 8))
        data[place : place + width] = (size % (1 << 8 * width)).to_bytes(width, "little")
    _file(path).write_bytes(data)


YAML_PIECES = (
    "&a ", "*a", "&b ", "*b", "[", "]", "{", "}", ",", ":", "\n", "  ", "- ", "<<: *a", "? ", "a",
    "[" * 200, "{a: " * 200, "- " * 60, "!!python/object:os.system ", "!!binary ", "|\n", ">\n",
    "1:2:3", "0x1F", "1e999", "'", '"', "%", "---", "...", "\t", "\x85", "[*a, *a, *a, *a, *a, *a]",
)  # fmt: skip


def _odd_yaml(path: Path, rng: random.Random) -> None:
    """Put YAML of any kind into the metadata, or into a topic's QoS profiles."""
    text = "".join(rng.choice(YAML_PIECES) for _ in range(rng.randrange(1, 60)))
    file = path / "metadata.yaml"
    lines = file.read_text().splitlines(keepends=True)
    at = rng.randrange(len(lines))
    if rng.random() < 0.5:
        file.write_text("".join([*lines[:at], text, "\n", *lines[at:]]))
        return
    messages = _messages(path)
    shutil.rmtree(path)
    path.mkdir()
    qos = {"offered_qos_profiles": text}
    write_channels(path / "bag_0.mcap", [Channel(*each, metadata=qos) for each in messages.items()])


def _messages(path: Path) -> dict[str, list[tuple[int, bytes]]]:
    found: dict[str, list[tuple[int, bytes]]] = {}
    with open_bag(path) as bag:
        for each in bag.messages():
            found.setdefault(each.topic, []).append((each.log_ns, each.data))
    return found


STATEMENTS = (
    "UPDATE topics SET id = '1) OR 1=1 --' WHERE name = '/s1'",
    "UPDATE topics SET name = CAST(x'FF1B5B' AS TEXT)",
    "UPDATE topics SET name = NULL",
    "UPDATE topics SET type = 7",
    "UPDATE topics SET serialization_format = NULL",
    "UPDATE topics SET offered_qos_profiles = 5",
    "UPDATE messages SET timestamp = 'soon' WHERE id % 3 = 0",
    "UPDATE messages SET timestamp = -timestamp",
    "UPDATE messages SET timestamp = 1.5 WHERE id = 7",
    "UPDATE messages SET data = NULL WHERE id % 2 = 0",
    "UPDATE messages SET data = 'text' WHERE id = 9",
    "UPDATE messages SET topic_id = 'x' WHERE id = 9",
    "UPDATE message_definitions SET encoding = NULL",
    "UPDATE message_definitions SET encoded_message_definition = x'FFFE'",
    "DELETE FROM message_definitions",
    "DELETE FROM topics",
    "DROP TABLE message_definitions",
    "DROP TABLE messages",
    "ALTER TABLE topics DROP COLUMN type",
    "ALTER TABLE messages RENAME TO m",
    "CREATE VIEW messages AS SELECT * FROM m",
    "ALTER TABLE topics RENAME COLUMN name TO title",
)


def _odd_database(path: Path, rng: random.Random) -> None:
    """Make it a bag of sqlite3 whose rows and tables are others than rosbag2's."""
    messages = [
        BagMessage(topic, POINT, log_ns, data)
        for topic, each in _messages(path).items()
        for log_ns, data in each
    ]
    shutil.rmtree(path)
    file = write_by_rosbags(path, messages, StoragePlugin.SQLITE3)
    connection = sqlite3.connect(file)
    with contextlib.closing(connection), connection:
        for statement in [
            "PRAGMA ignore_check_constraints = 1",
            *rng.sample(STATEMENTS, rng.choice((1, 1, 1, 3))),
        ]:
            with contextlib.suppress(sqlite3.Error):
                connection.execute(statement)


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
    "odd types": _odd_types,
    "odd names": _odd_names,
    "odd claims": _odd_claims,
    "odd YAML": _odd_yaml,
    "odd database": _odd_database,
}
"""Each by its name."""

CHANGES_MESSAGES = frozenset({"schemas swapped", "odd types", "odd names"})
"""With the others no message comes out that did not go in."""
