# SPDX-License-Identifier: Apache-2.0
"""Whole bags, of our own writer and of others', are read in order and by spans."""

from __future__ import annotations

import gc
import itertools
import random
import shutil
import tracemalloc
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import pytest
import yaml
import zstandard
from bag.making import (
    BEGIN_NS,
    FLOAT,
    POINT,
    STEP_NS,
    McapOptions,
    decoded,
    float_data,
    points,
    write_bag,
    write_by_mcap,
    write_by_rosbags,
)
from hypothesis import given
from hypothesis import strategies as st
from mcap.writer import CompressionType, IndexType
from rosbags.rosbag2 import CompressionMode, StoragePlugin

from fuzzy_fusion_ros.bag import BagMessage, BagWriter, open_bag
from fuzzy_fusion_ros.bag.block import BLOCK_BYTES, Block, gathered, one_by_one, together
from fuzzy_fusion_ros.bag.mcap import file
from fuzzy_fusion_ros.parameters.errors import BagError

Write = Callable[[Path, list[BagMessage]], Path]


def by_mcap(**options: Any) -> Write:
    """Return a maker of bare MCAP files with some of mcap's options."""
    return lambda path, messages: write_by_mcap(
        path.with_suffix(".mcap"), messages, McapOptions(**options)
    )


def by_rosbags(storage: StoragePlugin, mode: CompressionMode = CompressionMode.NONE) -> Write:
    """Return a maker of bags of rosbags."""

    def write(path: Path, messages: list[BagMessage]) -> Path:
        write_by_rosbags(path, messages, storage, mode)
        return path

    return write


WRITERS: dict[str, Write] = {
    "our directory": lambda path, messages: write_bag(path, messages).parent,
    "our file": write_bag,
    "rosbags, mcap": by_rosbags(StoragePlugin.MCAP),
    "rosbags, mcap, chunks compressed": by_rosbags(StoragePlugin.MCAP, CompressionMode.STORAGE),
    "rosbags, mcap, messages compressed": by_rosbags(StoragePlugin.MCAP, CompressionMode.MESSAGE),
    "rosbags, mcap, file compressed": by_rosbags(StoragePlugin.MCAP, CompressionMode.FILE),
    "rosbags, sqlite3": by_rosbags(StoragePlugin.SQLITE3),
    "rosbags, sqlite3, messages compressed": by_rosbags(
        StoragePlugin.SQLITE3, CompressionMode.MESSAGE
    ),
    "rosbags, sqlite3, file compressed": by_rosbags(StoragePlugin.SQLITE3, CompressionMode.FILE),
    "mcap": by_mcap(),
    "mcap, lz4": by_mcap(compression=CompressionType.LZ4),
    "mcap, uncompressed": by_mcap(compression=CompressionType.NONE),
    "mcap, no checksums": by_mcap(enable_crcs=False),
    "mcap, no chunks": by_mcap(use_chunking=False),
    "mcap, no statistics": by_mcap(use_statistics=False),
    "mcap, no topics in the summary": by_mcap(repeat_channels=False),
    "mcap, no types in the summary": by_mcap(repeat_schemas=False),
    "mcap, no chunk index": by_mcap(index_types=IndexType.NONE),
    "mcap, no message index": by_mcap(index_types=IndexType.CHUNK),
    "mcap, no summary": by_mcap(
        use_statistics=False,
        use_summary_offsets=False,
        repeat_channels=False,
        repeat_schemas=False,
        index_types=IndexType.NONE,
    ),
}


@pytest.fixture(params=WRITERS)
def write(request: pytest.FixtureRequest) -> Write:
    return WRITERS[request.param]


def test_what_was_written_is_read(write: Write, tmp_path: Path) -> None:
    messages = points(100, ["/s1", "/s2", "/s1"])
    with open_bag(write(tmp_path / "bag", messages)) as bag:
        assert list(bag.messages()) == messages
        assert {name: topic.msgtype for name, topic in bag.topics.items()} == {
            "/s1": POINT,
            "/s2": POINT,
        }
        counts = [topic.message_count for topic in bag.topics.values()]
        assert counts in ([67, 33], [None, None])
        assert bag.message_count in {100, None}
        assert (bag.start_ns, bag.end_ns) == (messages[0].log_ns, messages[-1].log_ns)
        assert bag.problems == []
        values = [decoded(message).point.x for message in bag.messages()]
        assert values == [0.5 + at for at in range(100)]


def test_it_can_be_read_again_and_twice_at_once(write: Write, tmp_path: Path) -> None:
    messages = points(50)
    with open_bag(write(tmp_path / "bag", messages)) as bag:
        pairs = zip(bag.messages(), bag.messages(), strict=True)
        assert all(one == other for one, other in pairs)
        assert list(bag.messages()) == messages


@pytest.mark.parametrize(
    ("start_s", "end_s", "expected"),
    [
        (None, None, range(100)),
        (0.0, None, range(100)),
        (None, 0.0, range(0)),
        (0.5, None, range(50, 100)),
        (None, 0.5, range(50)),
        (0.2, 0.3, range(20, 30)),
        (0.2 + 1e-9, 0.3 + 1e-9, range(21, 31)),
        (0.2 - 1e-9, 0.3 - 1e-9, range(20, 30)),
        (0.3, 0.2, range(0)),
        (-5.0, 0.1, range(10)),
        (0.99, 1e9, range(99, 100)),
        (1.0, None, range(0)),
        (-1e300, 1e300, range(100)),
    ],
)
def test_a_span_is_half_open_from_the_first_message_of_the_bag(
    write: Write, tmp_path: Path, start_s: float | None, end_s: float | None, expected: range
) -> None:
    messages = points(100, ["/s1", "/s2"])
    with open_bag(write(tmp_path / "bag", messages)) as bag:
        assert list(bag.messages(None, start_s, end_s)) == [messages[at] for at in expected]
        some = list(bag.messages(["/s2"], start_s, end_s))  # the span is still the bag's
        assert some == [messages[at] for at in expected if at % 2]


def test_a_span_covers_a_share_of_the_bag(tmp_path: Path) -> None:
    with open_bag(write_bag(tmp_path / "bag", points(401))) as bag:
        shares = [bag.share(*span) for span in [(None, None), (1, 2), (3, 9), (-1, 1), (5, 6)]]
    assert shares == [1.0, 0.25, 0.25, 0.25, 0.0]
    with open_bag(write_bag(tmp_path / "single", points(1))) as bag:
        assert bag.share(None, None) == 1.0


@pytest.mark.parametrize("limit", [float("nan"), float("inf")])
def test_a_limit_that_is_not_finite_is_refused(tmp_path: Path, limit: float) -> None:
    with open_bag(write_bag(tmp_path / "bag", points(1))) as bag:
        with pytest.raises(BagError, match="expected finite seconds"):
            bag.messages(start_s=limit)
        with pytest.raises(BagError, match="expected finite seconds"):
            bag.messages(end_s=limit)


def test_topics_that_are_not_there_yield_nothing(write: Write, tmp_path: Path) -> None:
    with open_bag(write(tmp_path / "bag", points(10))) as bag:
        assert list(bag.messages(["/other"])) == []
        assert list(bag.messages([])) == []


def test_required_topics_that_are_missing_bring_those_that_are_there(
    write: Write, tmp_path: Path
) -> None:
    with open_bag(write(tmp_path / "bag", points(10, ["/a", "/b"]))) as bag:
        bag.require_topics("/a", "/b")
        with pytest.raises(
            BagError, match=rf"has no topic '/s1', '/s2'; it has /a \({POINT}\), /b \({POINT}\)"
        ):
            bag.require_topics("/s1", "/a", "/s2")


def test_a_bag_without_messages_is_a_bag(write: Write, tmp_path: Path) -> None:
    with open_bag(write(tmp_path / "bag", [])) as bag:
        assert list(bag.messages()) == []
        assert (bag.start_ns, bag.end_ns, bag.message_count or 0) == (None, None, 0)
        with pytest.raises(BagError, match=r"has no topic '/s1'; it has no topics"):
            bag.require_topics("/s1")


@given(
    st.lists(st.integers(0, 40), max_size=120), st.sampled_from(["our file", "rosbags, sqlite3"])
)
def test_log_times_come_in_order_and_equal_ones_as_stored(
    tmp_path_factory: pytest.TempPathFactory, times: list[int], writer: str
) -> None:
    """Half a second apart, so that our chunks, of one second, overlap in every way."""
    messages = [
        BagMessage("/x", FLOAT, BEGIN_NS + time * 500_000_000, float_data(at))
        for at, time in enumerate(times)
    ]
    path = WRITERS[writer](tmp_path_factory.mktemp("bags") / "bag", messages)
    with open_bag(path) as bag:
        assert list(bag.messages()) == sorted(messages, key=lambda each: each.log_ns)
        low, high = 5.0, 12.0
        first = min((each.log_ns for each in messages), default=0)
        expected = [
            each
            for each in sorted(messages, key=lambda each: each.log_ns)
            if first + low * 1e9 <= each.log_ns < first + high * 1e9
        ]
        assert list(bag.messages(None, low, high)) == expected
        assert bag.problems == []


def test_order_holds_in_files_that_are_read_through(tmp_path: Path) -> None:
    messages = points(400)
    random.Random(1).shuffle(messages)
    for options in (McapOptions(use_chunking=False), McapOptions(chunk_size=700)):
        path = write_by_mcap(tmp_path / "bag.mcap", messages, options)
        path.write_bytes(path.read_bytes()[:-8])
        with open_bag(path) as bag:
            found = list(bag.messages())
            assert len(found) == 400
            assert found == sorted(messages, key=lambda each: each.log_ns)


def split(tmp_path: Path, parts: list[list[BagMessage]]) -> Path:
    """Return a bag of several files without metadata, as a killed recorder leaves it."""
    directory = tmp_path / "split"
    directory.mkdir()
    for at, part in enumerate(parts):
        write_by_mcap(directory / f"split_{at}.mcap", part)
    return directory


def test_files_are_read_one_after_the_other_in_natural_order(tmp_path: Path) -> None:
    messages = points(24, ["/s1", "/s2"])
    parts = [messages[2 * at : 2 * at + 2] for at in range(12)]
    with open_bag(split(tmp_path, parts)) as bag:
        assert list(bag.messages()) == messages
        assert [topic.message_count for topic in bag.topics.values()] == [12, 12]
        assert bag.problems == ["metadata.yaml: it is missing: the recorder did not close the bag"]


def test_files_that_overlap_are_merged(tmp_path: Path) -> None:
    messages = points(30, ["/s1", "/s2"])
    parts = [messages[::2], [], messages[1::2]]
    with open_bag(split(tmp_path, parts)) as bag:
        assert list(bag.messages()) == messages
        assert list(bag.messages(["/s2"], 0.1, 0.2)) == messages[11:20:2]


def test_equal_times_in_two_files_come_in_the_order_of_the_files(tmp_path: Path) -> None:
    one = [BagMessage("/x", FLOAT, BEGIN_NS + at, float_data(at)) for at in (0, 5)]
    two = [BagMessage("/x", FLOAT, BEGIN_NS + at, float_data(10 + at)) for at in (5, 6)]
    with open_bag(split(tmp_path, [one, two])) as bag:
        assert list(bag.messages()) == one + two
    shutil.rmtree(tmp_path / "split")
    with open_bag(split(tmp_path, [two, one])) as bag:
        assert list(bag.messages()) == [one[0], two[0], one[1], two[1]]


def test_a_topic_of_two_types_is_told_and_read(tmp_path: Path) -> None:
    messages = [*points(2), BagMessage("/s1", FLOAT, BEGIN_NS + 10**9, float_data(1.0))]
    with open_bag(split(tmp_path, [messages[:2], messages[2:]])) as bag:
        assert list(bag.messages()) == messages
        assert f"/s1: it has messages of types {POINT} and {FLOAT}" in bag.problems[-1]


def test_a_topic_that_is_no_cdr_is_told(tmp_path: Path) -> None:
    path = write_by_mcap(tmp_path / "bag.mcap", points(3))
    data = path.read_bytes()  # an uncompressed copy of the channel is in the summary
    assert data.count(b"\x03\0\0\0cdr") == 1
    path.write_bytes(data.replace(b"\x03\0\0\0cdr", b"\x03\0\0\0xml"))
    with open_bag(path) as bag:
        assert "its summary is damaged" in bag.problems[0]
    options = McapOptions(enable_crcs=False)
    path.write_bytes(
        write_by_mcap(path, points(3), options)
        .read_bytes()
        .replace(b"\x03\0\0\0cdr", b"\x03\0\0\0xml")
    )
    with open_bag(path) as bag:
        assert bag.problems == ["/s1: it is serialised as 'xml', not as 'cdr'"]


def test_a_bag_that_does_not_exist_is_refused(tmp_path: Path) -> None:
    with pytest.raises(BagError, match=r"nothing' does not exist: give a rosbag2 directory or"):
        open_bag(tmp_path / "nothing")


def test_a_directory_that_is_no_bag_is_refused(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("hello")
    with pytest.raises(BagError, match=r"holds no \.mcap or \.db3 file: it is not a rosbag2"):
        open_bag(tmp_path)


@pytest.mark.parametrize(
    ("name", "content", "problem"),
    [
        ("notes.txt", b"hello", "is not a bag: expected a rosbag2 directory, an .mcap or a .db3"),
        ("notes.mcap", b"hello, world", "is not an MCAP file: it begins with b'hello, wo'"),
        ("notes.db3", b"hello" * 999, "is not a readable sqlite3 bag: file is not a database"),
        ("empty.db3", b"", "is not a readable sqlite3 bag: no such table: topics"),
        ("notes.mcap.zstd", b"hello, world", "notes.mcap"),
    ],
)
def test_a_file_that_is_no_bag_is_refused(
    tmp_path: Path, name: str, content: bytes, problem: str
) -> None:
    path = tmp_path / name
    path.write_bytes(content)
    if name.endswith(".zstd"):
        with open_bag(path) as bag:
            assert "it decompresses only in part" in bag.problems[0]
        return
    with pytest.raises(BagError) as refusal:
        open_bag(path)
    assert problem in str(refusal.value)


def test_a_closed_bag_says_so(tmp_path: Path) -> None:
    bag = open_bag(write_bag(tmp_path / "bag", points(1)))
    bag.close()
    bag.close()
    with pytest.raises(BagError, match="is closed: open it again"):
        bag.messages()


@pytest.mark.parametrize("writer", ["our file", "rosbags, sqlite3"])
def test_a_bag_that_is_closed_while_it_is_read_says_so(tmp_path: Path, writer: str) -> None:
    bag = open_bag(WRITERS[writer](tmp_path / "bag", points(20_000)))
    messages = bag.messages()
    next(messages)
    bag.close()
    with pytest.raises(BagError, match="was closed while it was being read"):
        list(messages)


@pytest.mark.parametrize("name", ["x" * 5000, "a\0b"])
def test_a_name_that_no_file_can_have_is_refused(tmp_path: Path, name: str) -> None:
    with pytest.raises(BagError, match=r"cannot be read|does not exist"):
        open_bag(tmp_path / name)
    with pytest.raises(BagError, match="cannot be written"):
        BagWriter(tmp_path / name)


def test_a_device_is_no_bag() -> None:
    with pytest.raises(BagError, match=r"'/dev/null' cannot be read: .*Not a directory"):
        open_bag("/dev/null")


@pytest.mark.parametrize("name", ["metadata.yaml", "bag_0.mcap"])
def test_a_bag_that_may_not_be_read_is_refused_or_told(tmp_path: Path, name: str) -> None:
    """As root everything may be read: a directory in the file's place stands in for that."""
    path = write_bag(tmp_path / "bag", points(3)).parent / name
    path.unlink()
    path.mkdir()
    if name == "metadata.yaml":
        with open_bag(path.parent) as bag:
            assert "cannot be read" in bag.problems[0]
            assert len(list(bag.messages())) == 3
    else:
        with pytest.raises(BagError, match="cannot be read"):
            open_bag(path.parent)


def change(path: Path, **values: object) -> None:
    """Change entries of a metadata.yaml."""
    metadata = yaml.safe_load(path.read_text())
    metadata["rosbag2_bagfile_information"].update(values)
    path.write_text(yaml.safe_dump(metadata))


@pytest.mark.parametrize(
    ("values", "problem"),
    [
        ({"message_count": 12}, "metadata.yaml: it counts 12 messages, there are 10"),
        ({"message_count": "many"}, "is not valid rosbag2 metadata"),
        (
            {"relative_file_paths": ["a.mcap"]},
            "it is missing; reading bag_0.mcap instead",
        ),
        ({"relative_file_paths": None}, "is not valid rosbag2 metadata"),
        ({"compression_mode": "sometimes"}, "compression_mode 'sometimes': expected file or"),
    ],
)
def test_wrong_metadata_are_told_and_the_files_are_read(
    tmp_path: Path, values: dict[str, object], problem: str
) -> None:
    messages = points(10)
    directory = write_bag(tmp_path / "bag", messages).parent
    change(directory / "metadata.yaml", **values)
    with open_bag(directory) as bag:
        assert list(bag.messages()) == messages
        assert any(problem in each for each in bag.problems)


@pytest.mark.parametrize("text", ["", "{", "- a", "a: b", "\0", "rosbag2_bagfile_information: 3"])
def test_a_metadata_file_that_is_none_is_told(tmp_path: Path, text: str) -> None:
    messages = points(10)
    directory = write_bag(tmp_path / "bag", messages).parent
    (directory / "metadata.yaml").write_text(text)
    with open_bag(directory) as bag:
        assert list(bag.messages()) == messages
        assert "is not valid rosbag2 metadata" in bag.problems[0]


def test_metadata_that_are_no_text_are_told(tmp_path: Path) -> None:
    directory = write_bag(tmp_path / "bag", points(10)).parent
    (directory / "metadata.yaml").write_bytes(b"\xff\xfe\x00")
    with open_bag(directory) as bag:
        assert "is not valid rosbag2 metadata" in bag.problems[0]


def test_a_file_beside_the_listed_ones_is_told_and_left_out(tmp_path: Path) -> None:
    messages = points(10)
    directory = write_bag(tmp_path / "bag", messages).parent
    shutil.copy(directory / "bag_0.mcap", directory / "other.mcap")
    with open_bag(directory) as bag:
        assert list(bag.messages()) == messages
        assert bag.problems == ["other.mcap: metadata.yaml does not list this file: left out"]


def test_one_unreadable_file_of_several_is_told(tmp_path: Path) -> None:
    messages = points(10)
    directory = split(tmp_path, [messages])
    (directory / "split_1.mcap").write_bytes(b"nothing of the kind")
    with open_bag(directory) as bag:
        assert list(bag.messages()) == messages
        assert any("is not an MCAP file" in each for each in bag.problems)


def test_messages_that_do_not_decompress_are_told(tmp_path: Path) -> None:
    """Metadata that claim a compression: all messages fail; or only some do."""
    messages = points(4)
    compressed = [
        each._replace(data=zstandard.compress(each.data)) if at % 2 else each
        for at, each in enumerate(messages)
    ]
    directory = write_bag(tmp_path / "bag", compressed).parent
    change(directory / "metadata.yaml", compression_mode="MESSAGE", compression_format="zstd")
    with open_bag(directory) as bag:
        assert list(bag.messages()) == messages[1::2]
        (problem,) = bag.problems
        assert problem.startswith("/s1: messages do not decompress")


def test_what_was_read_before_makes_no_difference(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Chunks of 1 kB with some of the topics, of which the first ones are kept."""
    messages = points(120, ["/s1"]) + [
        each._replace(log_ns=each.log_ns + 120 * STEP_NS) for each in points(240, ["/s2", "/s1"])
    ]
    path = write_by_mcap(tmp_path / "bag.mcap", messages, McapOptions(chunk_size=1 << 10))
    monkeypatch.setattr(file, "BLOCK_BYTES", 1 << 13)
    rng = random.Random(1)
    with open_bag(path) as bag:
        for _ in range(100):
            topics = rng.choice([None, ["/s1"], ["/s2"], []])
            start_s, end_s = sorted(rng.choice([rng.uniform(0.0, 4.0), 0.0, 4.0]) for _ in "ab")
            begin_ns, end_ns = (BEGIN_NS + round(each * 1e9) for each in (start_s, end_s))
            most = rng.choice([1, None])
            found = list(itertools.islice(bag.messages(topics, start_s, end_s), most))
            wanted = [
                each
                for each in messages
                if begin_ns <= each.log_ns < end_ns and (topics is None or each.topic in topics)
            ]
            assert found == wanted[:most]


def test_memory_is_flat_in_the_length_of_a_bag(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of 20,000 messages, those of two blocks are alive at a time, and the first one."""
    path = write_bag(tmp_path / "bag", points(20_000, ["/s1", "/s2"]))
    gc.collect()
    monkeypatch.setattr(file, "BLOCK_BYTES", 1 << 16)
    with open_bag(path) as bag:
        tracemalloc.start()
        before = tracemalloc.get_traced_memory()[0]
        count = sum(1 for _ in bag.messages())
        peak = tracemalloc.get_traced_memory()[1] - before
        tracemalloc.stop()
    assert count == 20_000
    assert peak < 1_100_000


def test_memory_is_flat_with_blocks_as_shipped(tmp_path: Path) -> None:
    """Of 16 MB in messages, at most 7 are alive at a time: one is kept, to be read again."""
    large = [BagMessage("/cam", FLOAT, BEGIN_NS + at, bytes(40_000)) for at in range(400)]
    path = write_bag(tmp_path / "bag", large)
    with open_bag(path) as bag:
        tracemalloc.start()
        count = sum(1 for _ in bag.messages())
        _, peak = tracemalloc.get_traced_memory()
        tracemalloc.stop()
    assert count == len(large)
    assert BLOCK_BYTES <= peak < 7 * BLOCK_BYTES


def test_chunks_that_overlap_are_copied_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each of 50 chunks spans half the bag, so nothing is final before half of them are read."""
    copied = 0

    def counted(blocks: Sequence[Block]) -> Block:
        nonlocal copied
        copied += sum(len(each.data) for each in blocks)
        return together(blocks)

    monkeypatch.setattr(file, "together", counted)
    monkeypatch.setattr(file, "BLOCK_BYTES", 1 << 10)
    ordered = points(1000)
    messages = [each for pair in zip(ordered[:500], ordered[500:], strict=True) for each in pair]
    path = write_by_mcap(tmp_path / "bag.mcap", messages, McapOptions(chunk_size=1 << 10))
    with open_bag(path) as bag:
        assert list(bag.messages()) == ordered
    assert 0 < copied <= 2 * sum(len(each.data) for each in messages)


def test_messages_that_wait_keep_no_other_bytes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Small messages beside large ones, in chunks that overlap: 8 MB, of which 10 kB are read."""
    small = [
        BagMessage("/s", FLOAT, BEGIN_NS + (at + 100) % 200 * STEP_NS, float_data(at))
        for at in range(200)
    ]
    large = [BagMessage("/cam", FLOAT, each.log_ns, bytes(40_000)) for each in small]
    messages = [each for pair in zip(small, large, strict=True) for each in pair]
    path = write_by_mcap(tmp_path / "bag.mcap", messages, McapOptions(chunk_size=1 << 16))
    monkeypatch.setattr(file, "BLOCK_BYTES", 1 << 16)
    with open_bag(path) as bag:
        tracemalloc.start()
        found = list(bag.messages(["/s"]))
        _, peak = tracemalloc.get_traced_memory()
        tracemalloc.stop()
    assert found == sorted(small, key=lambda each: each.log_ns)
    assert peak < 1_000_000


def test_a_block_of_large_messages_ends_at_its_bytes() -> None:
    messages = [BagMessage("/cam", FLOAT, at, bytes([at % 251]) * 400_000) for at in range(7)]
    blocks = list(gathered(messages))
    assert [each.at.size for each in blocks] == [3, 3, 1]
    assert list(one_by_one(blocks)) == messages
    assert [each.at.size for each in gathered(points(5000))] == [4096, 904]
    assert list(gathered([])) == []


assert STEP_NS * 100 == 10**9  # what the spans above are written for
