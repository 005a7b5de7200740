# SPDX-License-Identifier: Apache-2.0
"""Damaged bags: what is whole is read, what is not is told, and nothing else happens."""

from __future__ import annotations

import contextlib
import random
import sqlite3
from collections.abc import Callable, Iterable
from pathlib import Path

import pytest
from bag.making import (
    BEGIN_NS,
    FLOAT,
    POINT,
    McapOptions,
    chunk_ends,
    definition_text,
    float_data,
    points,
    salvage_by_mcap,
    write_bag,
    write_by_mcap,
    write_by_rosbags,
)
from hypothesis import example, given
from hypothesis import strategies as st
from mcap.writer import CompressionType
from rosbags.rosbag2 import StoragePlugin

from fuzzy_fusion_ros.bag import BagMessage, BagReader, BagWriter, Definition, open_bag
from fuzzy_fusion_ros.messages import ScalarCodec
from fuzzy_fusion_ros.parameters.errors import BagError, MessageError

PER_CHUNK = 101  # ours are written as soon as they span a second
MESSAGES = points(4 * PER_CHUNK, ["/s1", "/s2", "/s1"])


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """An MCAP file of ours with four chunks of a second each."""
    return write_bag(tmp_path_factory.mktemp("bags") / "bag", MESSAGES).read_bytes()


def read(path: Path, data: bytes) -> tuple[list[BagMessage], list[str]]:
    """Return the messages and problems of a file with some bytes."""
    path.write_bytes(data)
    with open_bag(path) as bag:
        codec = ScalarCodec(bag.types, POINT)
        messages = list(bag.messages())
        for message in messages:
            codec.sample(message.data, 0)
        return messages, bag.problems


def read_all(bag: BagReader, messages: Iterable[BagMessage]) -> None:
    """Take the number out of each message that holds one."""
    codecs: dict[str, ScalarCodec] = {}
    for message in messages:
        with contextlib.suppress(MessageError):
            if message.msgtype not in codecs:
                codecs[message.msgtype] = ScalarCodec(bag.types, message.msgtype)
            codecs[message.msgtype].sample(message.data, 0)


def test_a_file_cut_off_at_a_chunk_gives_all_chunks_before(whole: bytes, tmp_path: Path) -> None:
    ends = chunk_ends(whole)
    assert len(ends) == 4
    for count, end in enumerate(ends, 1):
        messages, problems = read(tmp_path / "cut.mcap", whole[:end])
        assert messages == MESSAGES[: PER_CHUNK * count]
        assert problems == [
            "cut.mcap: it is incomplete: the recorder was killed or the copy was cut off"
        ]


def test_a_file_cut_off_anywhere_gives_all_chunks_before(whole: bytes, tmp_path: Path) -> None:
    """And never fewer messages than mcap's own reader finds."""
    ends = chunk_ends(whole)
    edges = {end + by for end in ends for by in (-1, 0, 1, 8, 9)}
    cuts = edges | set(range(0, len(whole), 97)) | set(range(40)) | {len(whole) - 1}
    for cut in sorted(cuts):
        messages, problems = read(tmp_path / "cut.mcap", whole[:cut])
        assert messages == MESSAGES[: PER_CHUNK * sum(end <= cut for end in ends)]
        assert len(messages) >= len(salvage_by_mcap(whole[:cut]))
        assert len(problems) in {1, 2}
        assert "it is empty" in problems[0] if cut == 0 else "it is incomplete" in problems[0]


@pytest.mark.parametrize("zeros", [1, 8, 100, 4096, 10_000_000])
def test_zeros_behind_a_cut_or_a_whole_file_cost_nothing_more(
    whole: bytes, tmp_path: Path, zeros: int
) -> None:
    cut = chunk_ends(whole)[1]
    messages, problems = read(tmp_path / "zeros.mcap", whole[:cut] + bytes(zeros))
    assert messages == MESSAGES[: 2 * PER_CHUNK]
    why = "a record is truncated" if zeros < 9 else "they are not MCAP records"
    assert problems[1:] == [f"zeros.mcap: {zeros} bytes from byte {cut} on are lost: {why}"]
    messages, problems = read(tmp_path / "zeros.mcap", whole + bytes(zeros))
    assert messages == MESSAGES
    assert len(problems) == 1


@pytest.mark.parametrize("data", [b"", b"\x89MCAP0", b"\x89MCAP0\r\n", b"\x89MCAP0\r\n\x01"])
def test_a_file_with_hardly_anything_in_it_is_an_empty_bag(tmp_path: Path, data: bytes) -> None:
    messages, problems = read(tmp_path / "nothing.mcap", data)
    assert messages == []
    assert problems
    with open_bag(tmp_path / "nothing.mcap") as bag:
        assert (bag.topics, bag.start_ns, bag.end_ns) == ({}, None, None)
        with pytest.raises(BagError, match="it has no topics"):
            bag.require_topics("/s1")


@given(st.data())
def test_flipped_bits_cost_at_most_the_chunks_that_they_are_in(
    whole: bytes, tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    """The chunk with the topics' descriptions is spared where the summary is hit as well."""
    ends = chunk_ends(whole)
    places = data.draw(st.lists(st.integers(0, len(whole) - 1), min_size=1, max_size=4))
    damaged = bytearray(whole)
    for place in places:
        damaged[place] ^= 1 << data.draw(st.integers(0, 7))
    path = tmp_path_factory.mktemp("flipped") / "flipped.mcap"
    messages, problems = read(path, bytes(damaged))
    starts = [0, *ends[:-1]]
    hit = [
        any(start <= place < end for place in places)
        for start, end in zip(starts, ends, strict=True)
    ]
    untouched = [
        each
        for at, is_hit in enumerate(hit)
        if not is_hit
        for each in MESSAGES[PER_CHUNK * at : PER_CHUNK * (at + 1)]
    ]
    assert set(messages) <= set(MESSAGES)
    if any(place >= ends[-1] for place in places) and hit[0]:
        return
    assert set(untouched) <= set(messages)
    assert problems or messages == MESSAGES


def test_every_chunk_in_turn_can_be_lost(whole: bytes, tmp_path: Path) -> None:
    ends = chunk_ends(whole)
    for at, end in enumerate(ends):
        damaged = bytearray(whole)
        damaged[end - 50] ^= 0xFF
        messages, problems = read(tmp_path / "bag.mcap", bytes(damaged))
        assert messages == MESSAGES[: PER_CHUNK * at] + MESSAGES[PER_CHUNK * (at + 1) :]
        (problem,) = problems
        assert "the chunk at byte" in problem
        assert "is damaged and skipped" in problem


def test_a_chunk_that_lost_its_head_is_skipped_by_the_search(whole: bytes, tmp_path: Path) -> None:
    """No summary, and the length of the second chunk gone: the third is found all the same."""
    ends = chunk_ends(whole)
    position = ends[0]
    while whole[position] != 6:
        position += 9 + int.from_bytes(whole[position + 1 : position + 9], "little")
    damaged = bytearray(whole[: ends[-1]])
    for broken in (bytes(8), b"\xff" * 8, b"\x01" + bytes(7)):
        damaged[position + 1 : position + 9] = broken
        messages, problems = read(tmp_path / "bag.mcap", bytes(damaged))
        assert messages == MESSAGES[:PER_CHUNK] + MESSAGES[2 * PER_CHUNK :]
        assert len(problems) >= 2


def test_descriptions_that_are_lost_are_told(whole: bytes, tmp_path: Path) -> None:
    """They stand in the first chunk; without it and the summary nobody knows the topics."""
    first, *_, last = chunk_ends(whole)
    damaged = bytearray(whole[:last])
    damaged[first - 50] ^= 0xFF
    messages, problems = read(tmp_path / "bag.mcap", bytes(damaged))
    assert messages == []
    assert (
        f"{3 * PER_CHUNK} messages are lost with the descriptions of their topics" in problems[-1]
    )


def test_a_summary_that_points_elsewhere_is_no_trap(tmp_path: Path) -> None:
    """Without a checksum: offsets, counts and times are only believed if they can be true."""
    path = tmp_path / "bag.mcap"
    options = McapOptions(enable_crcs=False, chunk_size=4000)
    data = write_by_mcap(path, MESSAGES, options).read_bytes()
    begin = chunk_ends(data)[-1]
    rng = random.Random(1)
    for _ in range(300):
        damaged = bytearray(data)
        damaged[rng.randrange(begin, len(data))] ^= 1 << rng.randrange(8)
        path.write_bytes(damaged)
        with open_bag(path) as bag:
            assert {each.data for each in bag.messages()} <= {each.data for each in MESSAGES}


def test_a_chunk_that_ends_within_a_record_gives_those_before(tmp_path: Path) -> None:
    """Without compression and checksum a damaged length is found only when it is met."""
    path = tmp_path / "bag.mcap"
    options = McapOptions(enable_crcs=False, compression=CompressionType.NONE, chunk_size=1 << 20)
    data = write_by_mcap(path, MESSAGES, options).read_bytes()
    at = data.index(MESSAGES[200].data) - 22 - 8
    damaged = data[:at] + b"\xff\xff\xff" + data[at + 3 :]
    for content in (damaged, damaged[:-8]):
        messages, problems = read(path, content)
        assert messages == MESSAGES[:200]
        assert any("ends within a record" in each for each in problems)


def test_times_that_a_chunk_does_not_own_up_to_are_told(tmp_path: Path) -> None:
    path = tmp_path / "bag.mcap"
    options = McapOptions(enable_crcs=False, compression=CompressionType.NONE, chunk_size=1 << 20)
    data = write_by_mcap(path, MESSAGES, options).read_bytes()
    at = data.index(MESSAGES[200].data) - 16
    early = (5).to_bytes(8, "little")
    messages, problems = read(path, data[:at] + early + data[at + 8 :])
    assert len(messages) == len(MESSAGES)
    assert "messages may come out of order" in problems[0]


def test_a_chunk_with_earlier_messages_that_is_cut_off_has_both_said_of_it(tmp_path: Path) -> None:
    path = tmp_path / "bag.mcap"
    options = McapOptions(enable_crcs=False, compression=CompressionType.NONE, chunk_size=1 << 20)
    data = bytearray(write_by_mcap(path, MESSAGES, options).read_bytes())
    time_at = data.index(MESSAGES[100].data) - 16
    data[time_at : time_at + 8] = (5).to_bytes(8, "little")
    length_at = data.index(MESSAGES[200].data) - 22 - 8
    data[length_at : length_at + 3] = b"\xff\xff\xff"
    messages, problems = read(path, bytes(data))
    assert len(messages) == 200
    assert "messages may come out of order" in problems[0]
    assert "ends within a record" in problems[1]


def test_records_outside_chunks_end_at_a_damaged_length(tmp_path: Path) -> None:
    path = tmp_path / "bag.mcap"
    data = write_by_mcap(path, MESSAGES, McapOptions(use_chunking=False)).read_bytes()
    at = data.index(MESSAGES[200].data) - 22 - 8
    for length in (b"\xff" * 8, bytes(8)):
        messages, problems = read(path, data[:at] + length + data[at + 8 :])
        assert messages == MESSAGES[:200]
        assert any("are lost" in each for each in problems)


@pytest.mark.parametrize("place", range(8))
def test_a_file_whose_first_bytes_are_gone_is_still_read(
    whole: bytes, tmp_path: Path, place: int
) -> None:
    damaged = bytearray(whole[:-8])  # or its summary would do
    damaged[place] ^= 0xFF
    messages, problems = read(tmp_path / "bag.mcap", bytes(damaged))
    assert messages == MESSAGES
    assert "its MCAP magic is damaged, what follows is not" in problems[1]


def test_a_file_whose_begin_is_gone_is_read_from_the_first_chunk(
    whole: bytes, tmp_path: Path
) -> None:
    messages, problems = read(tmp_path / "bag.mcap", whole[20:])
    assert messages == MESSAGES
    assert any("its MCAP magic is damaged" in each for each in problems)


@pytest.mark.parametrize("swap", ["ids", "texts"])
def test_swapped_definitions_are_errors_of_messages_and_copies_stay_right(
    tmp_path: Path, swap: str
) -> None:
    """What the bag says about its types is wrong: nothing can tell which of both is right."""
    messages = [
        *points(3),
        *(BagMessage("/x", FLOAT, BEGIN_NS + 10**9 + at, float_data(at)) for at in range(3)),
    ]
    definitions = {each: Definition("ros2msg", definition_text(each)) for each in (POINT, FLOAT)}
    with BagWriter(tmp_path / "bag") as writer:
        for name, msgtype, other in (("/s1", POINT, FLOAT), ("/x", FLOAT, POINT)):
            written = other if swap == "ids" else msgtype
            writer.add_topic(name, written, definition=definitions[other])
        for message in messages:
            msgtype = {POINT: FLOAT, FLOAT: POINT}[message.msgtype]
            message = message._replace(msgtype=msgtype) if swap == "ids" else message
            writer.write(*message)
    with open_bag(tmp_path / "bag") as bag:
        found = list(bag.messages())
        assert [each.data for each in found] == [each.data for each in messages]
        for message in found:
            with pytest.raises(MessageError, match=r"a message is no|has no (default )?field"):
                ScalarCodec(bag.types, message.msgtype).sample(message.data, 0)


def test_many_problems_are_not_all_told(tmp_path: Path) -> None:
    path = tmp_path / "bag.mcap"
    data = bytearray(write_by_mcap(path, MESSAGES, McapOptions(chunk_size=500)).read_bytes())
    ends = chunk_ends(bytes(data))
    for end in ends:
        data[end - 1] ^= 0xFF
    _, problems = read(path, bytes(data))
    assert len(ends) > 40
    assert len(problems) == 21
    assert problems[-1] == "further problems are not listed"


def test_a_problem_is_told_once(whole: bytes, tmp_path: Path) -> None:
    damaged = bytearray(whole)
    damaged[chunk_ends(whole)[1] - 50] ^= 0xFF
    path = tmp_path / "bag.mcap"
    path.write_bytes(damaged)
    with open_bag(path) as bag:
        for _ in range(3):
            assert len(list(bag.messages())) == 3 * PER_CHUNK
        assert len(bag.problems) == 1


DAMAGES: dict[str, Callable[[bytes, random.Random], bytes]] = {
    "cut": lambda data, rng: data[: rng.randrange(len(data))],
    "flip": lambda data, rng: flip(data, rng, 1),
    "flips": lambda data, rng: flip(data, rng, 20),
    "zeros": lambda data, rng: overwrite(data, rng, bytes(rng.randrange(1, 2000))),
    "noise": lambda data, rng: overwrite(data, rng, rng.randbytes(rng.randrange(1, 200))),
    "insert": lambda data, rng: insert(data, rng, rng.randbytes(rng.randrange(1, 50))),
    "delete": lambda data, rng: delete(data, rng, rng.randrange(1, 50)),
    "zero tail": lambda data, rng: zero_tail(data, rng),
}


def flip(data: bytes, rng: random.Random, count: int) -> bytes:
    """Flip bits."""
    changed = bytearray(data)
    for _ in range(count):
        changed[rng.randrange(len(data))] ^= 1 << rng.randrange(8)
    return bytes(changed)


def overwrite(data: bytes, rng: random.Random, new: bytes) -> bytes:
    """Overwrite bytes in the middle."""
    at = rng.randrange(len(data))
    return data[:at] + new[: len(data) - at] + data[at + len(new) :]


def insert(data: bytes, rng: random.Random, new: bytes) -> bytes:
    """Put bytes in."""
    at = rng.randrange(len(data))
    return data[:at] + new + data[at:]


def delete(data: bytes, rng: random.Random, count: int) -> bytes:
    """Take bytes out."""
    at = rng.randrange(len(data))
    return data[:at] + data[at + count :]


def zero_tail(data: bytes, rng: random.Random) -> bytes:
    """Zero the rest of the file, as a file system does after a power cut."""
    at = rng.randrange(len(data))
    return data[:at] + bytes(len(data) - at)


FORMATS = ("ours", "rosbags", "mcap", "no chunks", "sqlite3")


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    """The same messages in all formats."""
    place = tmp_path_factory.mktemp("formats")
    unchunked = McapOptions(use_chunking=False)
    return {
        "ours": write_bag(place / "ours", MESSAGES).read_bytes(),
        "rosbags": write_by_rosbags(place / "rosbags", MESSAGES).read_bytes(),
        "mcap": write_by_mcap(place / "mcap.mcap", MESSAGES).read_bytes(),
        "no chunks": write_by_mcap(place / "flat.mcap", MESSAGES, unchunked).read_bytes(),
        "sqlite3": write_by_rosbags(
            place / "sqlite3", MESSAGES, StoragePlugin.SQLITE3
        ).read_bytes(),
    }


@pytest.mark.parametrize("damage", DAMAGES)
@pytest.mark.parametrize("kind", FORMATS)
def test_no_damage_raises_anything_else(
    files: dict[str, bytes], kind: str, damage: str, tmp_path: Path
) -> None:
    """With checksums, no message comes out that did not go in; and in order, unless told."""
    path = tmp_path / ("bag.db3" if kind == "sqlite3" else "bag.mcap")
    rng = random.Random(f"{kind} {damage}")
    for _ in range(30):
        path.write_bytes(DAMAGES[damage](files[kind], rng))
        try:
            with open_bag(path) as bag:
                messages = list(bag.messages())
                read_all(bag, messages)
                problems = bag.problems
        except BagError:
            assert kind in {"no chunks", "sqlite3"}
            continue
        times = [each.log_ns for each in messages]
        assert times == sorted(times) or problems or kind == "sqlite3"
        if kind in {"ours", "mcap"}:
            assert set(messages) <= set(MESSAGES)
            assert problems or messages == MESSAGES


def test_a_damaged_database_gives_what_stands_before(
    files: dict[str, bytes], tmp_path: Path
) -> None:
    path = tmp_path / "bag.db3"
    data = bytearray(files["sqlite3"])
    data[12 * 4096 : 13 * 4096] = bytes(4096)
    path.write_bytes(data)
    with open_bag(path) as bag:
        messages = list(bag.messages())
        assert messages == MESSAGES[: len(messages)]
        assert bag.problems


@pytest.mark.parametrize(
    ("statement", "lost"),
    [
        ("UPDATE messages SET data = NULL WHERE id = 5", 1),
        ("UPDATE messages SET data = 1000000000 WHERE id = 5", 1),
        ("UPDATE messages SET timestamp = 'soon' WHERE id = 5", 1),
        ("UPDATE messages SET topic_id = 77 WHERE id = 5", 1),
        ("UPDATE topics SET offered_qos_profiles = '- nonsense'", 0),
    ],
)
def test_rows_of_other_types_are_left_out(
    files: dict[str, bytes], tmp_path: Path, statement: str, lost: int
) -> None:
    path = tmp_path / "bag.db3"
    path.write_bytes(files["sqlite3"])
    database = sqlite3.connect(path)
    try:
        with database:
            database.execute("CREATE TABLE loose AS SELECT * FROM messages")
            database.execute("DROP TABLE messages")
            database.execute("ALTER TABLE loose RENAME TO messages")
            database.execute(statement)
    finally:
        database.close()
    with open_bag(path) as bag:
        messages = list(bag.messages())
        assert len(messages) == len(MESSAGES) - lost
        assert set(messages) <= set(MESSAGES)


def test_what_a_killed_recorder_left_in_the_log_of_a_database_is_read(
    files: dict[str, bytes], tmp_path: Path
) -> None:
    place = tmp_path / "live"
    place.mkdir()
    path = place / "bag.db3"
    path.write_bytes(files["sqlite3"])
    database = sqlite3.connect(path)
    try:
        database.execute("PRAGMA journal_mode=WAL")
        database.execute("PRAGMA wal_autocheckpoint=0")
        with database:
            database.execute(
                "INSERT INTO messages (topic_id, timestamp, data) VALUES (1, ?, ?)",
                (MESSAGES[-1].log_ns + 1, MESSAGES[0].data),
            )
        killed = tmp_path / "killed"
        killed.mkdir()
        for each in ("bag.db3", "bag.db3-wal"):
            (killed / each).write_bytes((place / each).read_bytes())
    finally:
        database.close()
    with open_bag(killed / "bag.db3") as bag:
        assert len(list(bag.messages())) == len(MESSAGES) + 1


@given(st.binary(max_size=300))
@example(b"\x89MCAP0\r\n" * 10)
def test_any_bytes_are_a_bag_or_refused(
    tmp_path_factory: pytest.TempPathFactory, data: bytes
) -> None:
    for begin in (b"", b"\x89MCAP0\r\n", b"\x89MCAP0\r\n\x06" + b"\x10" + bytes(7)):
        path = tmp_path_factory.mktemp("any") / "any.mcap"
        path.write_bytes(begin + data)
        try:
            with open_bag(path) as bag:
                list(bag.messages())
        except BagError:
            assert not begin
