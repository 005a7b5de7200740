# SPDX-License-Identifier: Apache-2.0
"""Files that are made to exhaust memory or time, to run what they say, or to talk to a terminal."""

from __future__ import annotations

import os
import sqlite3
import struct
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import NamedTuple

import lz4.frame
import yaml
import zstandard
from bag.making import (
    BEGIN_NS,
    Channel,
    float_data,
    point_data,
    points,
    write_bag,
    write_by_rosbags,
    write_channels,
)
from mcap.data_stream import RecordBuilder
from mcap.records import Chunk, DataEnd, Footer, Header
from mcap.writer import MCAP0_MAGIC
from rosbags.rosbag2 import StoragePlugin

DEEP = 5000
LONG = "x" * 5000
STAMPS_NS = [BEGIN_NS + at * 10_000_000 for at in range(200)]
ESCAPES = "\x1b]0;owned\x07\x1b[2J\x9b31m\u202e\x7f"
"""What a terminal obeys: a title, a cleared screen, red, text from right to left, delete."""


class Case(NamedTuple):
    """What a command is given, and what it must do.

    Attributes:
        arguments: The command and its arguments.
        says: What stands in its one line on stderr; with status 0, that it says nothing.
        status: Its exit status.
    """

    arguments: Sequence[str]
    says: str
    status: int = 2


Maker = Callable[[Path], Case]
"""Makes a case in an empty folder."""


def samples(stamps: Iterable[int] = STAMPS_NS) -> list[tuple[int, bytes]]:
    """Return a slow ramp as PointStamped."""
    return [(ns, point_data(ns, (ns - BEGIN_NS) * 1e-9)) for ns in stamps]


S1, S2 = Channel("/s1", samples()), Channel("/s2", samples(STAMPS_NS[::10]))


def replay(path: Path, *arguments: str) -> list[str]:
    """Return a replay of a bag into one beside it."""
    return ["replay", str(path), "--output", str(path.parent / "out"), *arguments]


# --- YAML


def bomb(indent: str = "") -> str:
    """Return YAML of a kilobyte that stands for 10^15 values."""
    lines = ["a0: &a0 [x, x, x, x, x, x, x, x, x, x]"]
    lines += [f"a{k}: &a{k} [{', '.join([f'*a{k - 1}'] * 10)}]" for k in range(1, 15)]
    return "".join(f"{indent}{line}\n" for line in lines)


YAMLS = {
    "aliases that explode": (bomb(), "more than 200000 values"),
    "an alias within itself": ("a: &a [*a]\n", "contains itself"),
    "lists in lists": (f"a: {'[' * DEEP}{']' * DEEP}\n", "nests more than 50 levels deep"),
    "maps in maps": ("".join(f"{' ' * k}a:\n" for k in range(300)), "nests more than 50"),
    "merged maps": (
        "a0: &a0 {x: 1}\n"
        + "".join(f"a{k}: &a{k} {{<<: [{', '.join([f'*a{k - 1}'] * 9)}]}}\n" for k in range(1, 15)),
        "more than 200000 values",
    ),
}


def parameter_file(text: str, says: str) -> Maker:
    """Return what gives a parameter file to a command."""

    def make(folder: Path) -> Case:
        path = write_channels(folder / "bag.mcap", [S1, S2])
        (folder / "some.yaml").write_text(text)
        says_here = "ROS supports none" if "*" in text else says
        return Case(replay(path, "--params", str(folder / "some.yaml")), says_here)

    return make


def endless_file(folder: Path) -> Case:
    """Return a parameter file without end."""
    path = write_channels(folder / "bag.mcap", [S1, S2])
    return Case(replay(path, "--params", "/dev/zero"), "larger than 4194304 bytes")


def metadata(text: str, says: str) -> Maker:
    """Return what puts YAML into the metadata of a bag."""

    def make(folder: Path) -> Case:
        path = write_bag(folder / "bag", points(50, ["/s1", "/s2"])).parent
        with (path / "metadata.yaml").open("a") as file:
            file.write(text)
        return Case(replay(path), says)

    return make


def offered_qos(text: str, says: str) -> Maker:
    """Return what puts YAML into the QoS profiles of a topic."""

    def make(folder: Path) -> Case:
        qos = {"offered_qos_profiles": text}
        channels = [each._replace(metadata=qos) for each in (S1, S2)]
        path = write_channels(folder / "bag.mcap", channels)
        return Case(replay(path), says)

    return make


# --- names


def long_name(option: str) -> Maker:
    """Return what gives a name of 5,000 characters."""

    def make(folder: Path) -> Case:
        path = write_channels(folder / "bag.mcap", [S1, S2, S1._replace(topic="/truth")])
        if option == "BAG":
            return Case(replay(folder / LONG), "name too long")
        name = str(folder / LONG) + (".png" if option == "--plot" else "")
        command = "score" if option in {"--json", "--plot", "--baseline"} else "replay"
        arguments = [command, str(path), option, name]
        return Case(arguments, "name too long")

    return make


def long_topic(folder: Path) -> Case:
    """Return a topic that is asked for by 5,000 characters."""
    path = write_channels(folder / "bag.mcap", [S1, S2])
    return Case(replay(path, "--s1", LONG), "has no topic '/xxx")


def escapes_in_a_topic(folder: Path) -> Case:
    """Return a topic whose name a terminal would obey."""
    path = write_channels(folder / "bag.mcap", [S2, S1._replace(topic=f"/{ESCAPES}")])
    return Case(replay(path), r"\x1b]0;owned\x07\x1b[2J\x9b31m\u202e\x7f")


def escapes_in_a_file(folder: Path) -> Case:
    """Return a bag whose name a terminal would obey, and whose own name is no UTF-8."""
    path = write_channels(folder / f"{ESCAPES}\udcff.mcap", [S1, S2])
    return Case(replay(path, "--s1", "/none"), r"\x1b]0;owned\x07\x1b[2J\x9b31m\u202e\x7f\udcff")


def bytes_in_names(folder: Path) -> Case:
    """Return a bag and an output whose names are no UTF-8."""
    path = write_channels(folder / "in\udcff.mcap", [S1, S2])
    return Case(replay(path, "--output", str(folder / "out\udcff")), "", 0)


def bytes_in_a_topic(folder: Path) -> Case:
    """Return a file with a third topic whose name is no UTF-8."""
    path = write_channels(folder / "bag.mcap", [S1, S2, S1._replace(topic="/####")])
    path.write_bytes(_without_checksums(path).replace(b"/####", b"/\xff\xfe\xc3("))
    return Case(replay(path), "", 0)


def _without_checksums(path: Path) -> bytes:
    """Return an MCAP file written again, uncompressed, without checksums."""
    from bag.making import McapOptions, write_by_mcap
    from bag.recorded import messages
    from mcap.writer import CompressionType

    options = McapOptions(enable_crcs=False, compression=CompressionType.NONE)
    return write_by_mcap(path.with_name("plain.mcap"), messages(path), options).read_bytes()


# --- compression


CLAIM = b"\x28\xb5\x2f\xfd\xe0" + struct.pack("<Q", 3 << 30) + zstandard.compress(bytes(64))[6:]
"""A frame of zstd that claims to become 3 GB."""


def chunk(compression: str, compress: Callable[[], bytes], claims: int) -> Maker:
    """Return what writes a file of one chunk, which claims to become so many bytes."""

    def make(folder: Path) -> Case:
        data = compress()
        path = folder / "bag.mcap"
        with path.open("wb") as file:
            file.write(MCAP0_MAGIC)
            head = Chunk(compression, data, BEGIN_NS, BEGIN_NS, 0, claims)
            file.write(_records(Header("ros2", "test"), head, DataEnd(0), Footer(0, 0, 0)))
            file.write(MCAP0_MAGIC)
        return Case(replay(path), "it has no topics; bag.mcap: ")

    return make


def _records(*records: Header | Chunk | DataEnd | Footer) -> bytes:
    builder = RecordBuilder()
    for each in records:
        each.write(builder)
    return bytes(builder.end())


def zeros(size: int, *, claim: bool = True) -> bytes:
    """Return zeros, compressed by zstd; the frame says how many or does not."""
    parameters = zstandard.ZstdCompressionParameters(write_content_size=claim)
    work = zstandard.ZstdCompressor(compression_params=parameters).compressobj(
        size=size if claim else -1
    )
    block = bytes(1 << 20)
    parts = [work.compress(block) for _ in range(size >> 20)]
    return b"".join([*parts, work.flush()])


def large_file(folder: Path) -> Case:
    """Return a file of some kilobytes that becomes 300 MB."""
    (folder / "bag.mcap.zstd").write_bytes(zeros(300 << 20, claim=False))
    return Case(replay(folder / "bag.mcap.zstd"), "decompresses to more than 100 times its size")


def large_message(folder: Path) -> Case:
    """Return a bag whose messages claim to become 3 GB each."""
    messages = [each._replace(data=CLAIM) for each in points(50, ["/s1", "/s2"])]
    path = write_bag(folder / "bag", messages).parent
    document = yaml.safe_load((path / "metadata.yaml").read_text())
    document["rosbag2_bagfile_information"]["compression_mode"] = "MESSAGE"
    (path / "metadata.yaml").write_text(yaml.safe_dump(document))
    return Case(replay(path), "messages do not decompress")


def many_records(record: bytes) -> Maker:
    """Return what fills a chunk with as many small records as fit."""
    count = (127 << 20) // len(record)
    return chunk("zstd", lambda: zstandard.compress(record * count), count * len(record))


# --- types


def typed(text: str, says: str, *, field: str = "value", status: int = 2) -> Maker:
    """Return what describes the type of S1 and S2."""

    def make(folder: Path) -> Case:
        data = [(ns, float_data(1.0)) for ns in STAMPS_NS]
        encoding = "ros2idl" if "module" in text else "ros2msg"
        channels = [
            Channel(topic, data, "cdr", "bad_msgs/msg/Bad", encoding, text)
            for topic in ("/s1", "/s2")
        ]
        path = write_channels(folder / "bag.mcap", channels)
        return Case(replay(path, "--field", field), says, status)

    return make


def doubled(levels: int, suffix: str = "") -> str:
    """Return a type that contains the next one twice, and so on."""
    text = f"bad_msgs/L0{suffix} a\nbad_msgs/L0{suffix} b\nfloat64 value\n"
    for k in range(levels):
        text += f"{'=' * 80}\nMSG: bad_msgs/L{k}\n"
        inner = f"bad_msgs/L{k + 1}{suffix}"
        text += f"{inner} a\n{inner} b\n" if k + 1 < levels else "float64 value\n"
    return text


def unread(definition: str) -> Maker:
    """Return what describes the type of a topic that nobody asks for."""

    def make(folder: Path) -> Case:
        other = Channel("/other", S1.messages, "cdr", "bad_msgs/msg/Bad", "ros2msg", definition)
        return Case(replay(write_channels(folder / "bag.mcap", [S1, S2, other])), "", 0)

    return make


# --- sqlite3


def database(*statements: str, says: str = "", status: int = 2) -> Maker:
    """Return what changes a bag of sqlite3."""

    def make(folder: Path) -> Case:
        messages = points(300, ["/s1", "/s2", "/s1"])
        path = write_by_rosbags(folder / "bag", messages, StoragePlugin.SQLITE3)
        connection = sqlite3.connect(path)
        with connection:
            for statement in statements:
                connection.execute(statement)
        connection.close()
        return Case(replay(path), says, status)

    return make


NOT_PLAIN = "is not a plain table"
FIELDS = "".join(f"float64 f{k}\n" for k in range(100_000))
MESSAGE = struct.pack("<BQHIQQ", 5, 22, 1, 0, BEGIN_NS, BEGIN_NS)

CASES: dict[str, Maker] = {
    **{f"parameter file: {name}": parameter_file(*each) for name, each in YAMLS.items()},
    "parameter file: without end": endless_file,
    **{f"metadata: {name}": metadata(*each) for name, each in YAMLS.items()},
    **{f"offered QoS: {name}": offered_qos(*each) for name, each in YAMLS.items()},
    **{
        f"a long name for {option}": long_name(option)
        for option in ("BAG", "--params", "--output", "--json", "--plot", "--baseline")
    },
    "a long name for a topic": long_topic,
    "escapes in a topic": escapes_in_a_topic,
    "escapes in a file": escapes_in_a_file,
    "bytes in names of files": bytes_in_names,
    "bytes in the name of a topic": bytes_in_a_topic,
    "a chunk that claims 3 GB": chunk("zstd", lambda: zeros(1 << 20), 3 << 30),
    "a frame that claims 3 GB": chunk("zstd", lambda: CLAIM, 1000),
    "a frame that becomes 300 MB": chunk("zstd", lambda: zeros(300 << 20, claim=False), 1000),
    "lz4 that becomes 300 MB": chunk("lz4", lambda: lz4.frame.compress(bytes(300 << 20)), 1000),
    "lz4 that becomes 300 MB, as it says": chunk(
        "lz4", lambda: lz4.frame.compress(bytes(300 << 20)), 300 << 20
    ),
    "a chunk full of messages": many_records(MESSAGE),
    "a chunk full of schemas": many_records(struct.pack("<BQ", 3, 1) + b"x"),
    "a chunk full of unknown records": many_records(struct.pack("<BQ", 200, 0)),
    "a file that becomes 300 MB": large_file,
    "messages that claim 3 GB": large_message,
    "a type that doubles at 29 levels": typed(doubled(29), "more than 100000 fields"),
    "sequences that double at 29 levels": typed(doubled(29, "[]"), "no estimate"),
    "an array of 10^9 numbers": typed("float64 value\nfloat64[1000000000] a\n", "no estimate"),
    "an array of 10^9 texts": typed("float64 value\nstring[1000000000] a\n", "100000 fields"),
    "an array of 10^9 messages": typed(
        "float64 value\nstd_msgs/Header[1000000000] a\n", "more than 100000 fields"
    ),
    "an array of 10^30 numbers": typed(f"float64 value\nint8[{10**30}] a\n", "no estimate"),
    "10^5 fields": typed(f"{FIELDS}float64 value\n", "at most 262144 are read"),
    "fields without end": typed("float64 a\n" * 500_000, "at most 262144 are read"),
    "a type within itself": typed("bad_msgs/Bad a\nfloat64 value\n", "contains itself"),
    "IDL with nested parentheses": typed(
        f"module bad_msgs {{ module msg {{ const long A = {'(' * 30}1{')' * 30};"
        " struct Bad { double value; }; }; };",
        "parentheses",
    ),
    "IDL with nested sequences": typed(
        f"module bad_msgs {{ module msg {{ struct Bad {{ {'sequence<' * 30}double{'>' * 30} x;"
        " double value; }; }; };",
        "nested sequences",
    ),
    "10^5 fields of a topic that nobody asks for": unread(FIELDS),
    "a type of a topic that nobody asks for doubles": unread(doubled(29)),
    "ids that are SQL": database(
        "CREATE TABLE t2 (id, name, type, serialization_format, offered_qos_profiles)",
        "INSERT INTO t2 SELECT CASE name WHEN '/s1' THEN '1) OR 1=1 --' ELSE id END, name, type, "
        "serialization_format, offered_qos_profiles FROM topics",
        "DROP TABLE topics",
        "ALTER TABLE t2 RENAME TO topics",
        "INSERT INTO topics SELECT 99, '/x''); DROP TABLE messages; --', type, "
        "serialization_format, '' FROM topics LIMIT 1",
        status=0,
    ),
    "messages as a view without end": database(
        "ALTER TABLE messages RENAME TO m",
        "CREATE VIEW messages AS WITH RECURSIVE c(x) AS (SELECT 1 UNION ALL SELECT x + 1 FROM c) "
        "SELECT x AS id, 1 AS topic_id, x AS timestamp, zeroblob(60) AS data FROM c",
        says=NOT_PLAIN,
    ),
    "data that is generated": database(
        "ALTER TABLE messages RENAME TO m",
        "CREATE TABLE messages (id INTEGER PRIMARY KEY, topic_id, timestamp, "
        "data AS (zeroblob(900000000)))",
        "INSERT INTO messages SELECT id, topic_id, timestamp FROM m",
        says=NOT_PLAIN,
    ),
    "names of topics that are no UTF-8": database(
        "INSERT INTO topics SELECT 99, CAST(x'2FFFFE' AS TEXT), type, serialization_format, '', '' "
        "FROM topics LIMIT 1",
        status=0,
    ),
}
"""Each by its name."""


def made(folder: Path) -> dict[str, Case]:
    """Make all cases, each in a folder of its own."""
    cases = {}
    for number, (name, make) in enumerate(CASES.items()):
        place = folder / f"{number}"
        os.mkdir(place)
        cases[name] = make(place)
    return cases
