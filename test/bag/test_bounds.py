# SPDX-License-Identifier: Apache-2.0
"""What is read of a bag is bounded: values at the bounds."""

from __future__ import annotations

import struct
import tracemalloc
from pathlib import Path

import lz4.frame
import pytest
import zstandard
from bag.making import (
    BEGIN_NS,
    FLOAT,
    POINT,
    Channel,
    McapOptions,
    definition_text,
    float_data,
    points,
    write_by_mcap,
    write_channels,
)
from mcap.writer import CompressionType

from fuzzy_fusion_ros.bag import BagTypes, Definition, Topic, compression, definitions, open_bag
from fuzzy_fusion_ros.bag.compression import decompress, decompress_file
from fuzzy_fusion_ros.bag.mcap import records
from fuzzy_fusion_ros.bag.mcap.records import find_messages, split_records
from fuzzy_fusion_ros.messages import ScalarCodec, default_message
from fuzzy_fusion_ros.messages.cdr import LARGEST, CdrWriter
from fuzzy_fusion_ros.parameters.errors import BagError, MessageError

PAIR = "odd_msgs/msg/Pair"
DATA = bytes(range(256)) * 40
UNKNOWN_SIZE = zstandard.ZstdCompressor(write_content_size=False).compress(DATA)


@pytest.mark.parametrize(
    ("kind", "data"),
    [
        ("", DATA),
        ("zstd", zstandard.compress(DATA)),
        ("zstd", UNKNOWN_SIZE),
        ("lz4", lz4.frame.compress(DATA)),
    ],
)
def test_what_fits_is_decompressed(kind: str, data: bytes) -> None:
    assert decompress(kind, data) == DATA
    assert decompress(kind, data, len(DATA)) == DATA
    if kind:
        with pytest.raises((ValueError, zstandard.ZstdError)):
            decompress(kind, data, len(DATA) - 1)
        with pytest.raises(ValueError, match="at most 134217728 are read"):
            decompress(kind, data, compression.LARGEST + 1)


def test_an_unknown_compression_is_refused() -> None:
    with pytest.raises(ValueError, match="unknown compression 'br'"):
        decompress("br", DATA)


def test_a_file_may_become_a_hundred_times_as_large(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(compression, "FILE_AT_LEAST", 1000)
    path, target = tmp_path / "some.zstd", tmp_path / "some"
    path.write_bytes(zstandard.compress(DATA))
    ratio = len(DATA) // path.stat().st_size + 1
    monkeypatch.setattr(compression, "FILE_RATIO", ratio)
    decompress_file(path, target)
    assert target.read_bytes() == DATA
    monkeypatch.setattr(compression, "FILE_RATIO", ratio - 1)
    with pytest.raises(ValueError, match=f"more than {ratio - 1} times its size"):
        decompress_file(path, target)


def test_a_run_of_records_ends_at_a_number(monkeypatch: pytest.MonkeyPatch) -> None:
    record = struct.pack("<BQHIQQ", 5, 22, 1, 0, 7, 7)
    monkeypatch.setattr(records, "MOST_RECORDS", 5)
    for count in (1, 4, 5):
        run = split_records(count * record)
        assert (len(run.places), run.is_whole) == (count, True)
    run = split_records(6 * record)
    assert (len(run.places), run.is_whole) == (5, False)


def test_records_that_nobody_needs_take_no_memory() -> None:
    run = split_records(10 * struct.pack("<BQ", 200, 0) + struct.pack("<BQB", 3, 1, 0))
    assert (run.others, run.is_whole) == ([(3, b"\0")], True)


@pytest.mark.parametrize("begins", [b"", struct.pack("<BQHIQQ", 5, 22, 1, 0, 7, 7)])
def test_bytes_that_all_look_like_messages_take_little_memory(begins: bytes) -> None:
    run = begins + bytes([5]) * (1 << 20)
    tracemalloc.start()
    data, places, whole = find_messages([run])
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert (data, places.tolist(), whole) == (run, [0] if begins else [], [False])
    assert peak < len(run)


def test_what_looks_like_chunks_is_not_read_for_ever(tmp_path: Path) -> None:
    """Each of 20,000 heads claims the rest of the file."""
    path = tmp_path / "bag.mcap"
    whole = write_by_mcap(path, points(5), McapOptions(compression=CompressionType.NONE))
    data = whole.read_bytes()[:8]
    count, rest = 20_000, 50 * 20_000
    for k in range(count):
        length = rest - 50 * k - 9
        data += struct.pack("<BQQQQII", 6, length, 1, 1, 1, 1, 0) + struct.pack("<Q", length - 40)
    path.write_bytes(data + bytes(rest))
    with open_bag(path) as bag:
        assert list(bag.messages()) == []
        assert any("too much of it is damaged" in each for each in bag.problems)


def test_a_file_of_very_many_topics_is_refused(tmp_path: Path) -> None:
    text = definition_text(FLOAT)
    channels = [
        Channel(f"/x{k}", [(BEGIN_NS + k, float_data(1.0))], "cdr", FLOAT, "ros2msg", text)
        for k in range(10_001)
    ]
    path = write_channels(tmp_path / "bag.mcap", channels)
    with pytest.raises(BagError, match="more than 10000 topics"):
        open_bag(path)
    with open_bag(write_channels(path, channels[1:])) as bag:
        assert len(bag.topics) == 10_000


def types(text: str, encoding: str = "ros2msg") -> BagTypes:
    """Return the types of a bag that describes one."""
    return BagTypes([Topic("/x", PAIR, definition=Definition(encoding, text))])


def test_comments_and_blank_lines_do_not_count(monkeypatch: pytest.MonkeyPatch) -> None:
    text = "# comment\n\n  \n" * 1000 + "float64 value # here\n"
    monkeypatch.setattr(definitions, "LARGEST", 100)
    assert list(types(text).fields(PAIR)) == ["value"]
    with pytest.raises(MessageError, match="has 1410 characters, at most 100 are read"):
        types("float64 valuea\n" * 94).fields(PAIR)


@pytest.mark.parametrize(
    "text",
    [
        'module odd_msgs { module msg { @verbatim (language="comment", text="(((") struct Pair '
        '{ @unit(value="m") double value; }; }; };',
        '// ((((\n/* << ((( */ module odd_msgs { module msg { const string A = "((<<"; '
        "struct Pair { double value; }; }; };",
        "module odd_msgs { module msg { typedef double T[3]; const long N = -3; "
        "struct Pair { sequence<string<5>, 3> names; double value; }; }; };",
    ],
)
def test_idl_that_people_write_is_read(text: str) -> None:
    assert "value" in types(text, "ros2idl").fields(PAIR)


def with_constants(count: int) -> BagTypes:
    """Return the types of a bag whose IDL has constants."""
    constants = " ".join(f"const long A{k} = {k};" for k in range(count))
    struct = "struct Pair { double value; };"
    return types(f"module odd_msgs {{ module msg {{ {constants} {struct} }}; }};", "ros2idl")


@pytest.mark.parametrize("most", [50, pytest.param(1000, marks=pytest.mark.slow("as with 50"))])
def test_constants_are_read_up_to_a_number(most: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(definitions, "MOST_CONSTANTS", most)
    assert with_constants(most).fields(PAIR)


def test_more_than_a_thousand_constants_are_refused() -> None:
    with pytest.raises(MessageError, match="more than 1000 constants"):
        with_constants(1001).fields(PAIR)


def test_a_message_that_is_made_is_bounded() -> None:
    fits = LARGEST // 8 - 8
    assert len(default_message(types(f"float64[{fits}] a"), PAIR)) == 4 + 8 * fits
    with pytest.raises(MessageError, match="too large to be sent"):
        default_message(types(f"float64[{LARGEST}] a"), PAIR)
    assert CdrWriter().numbers("float64", 1.0, 0).done() == CdrWriter().done()


def test_a_sequence_is_walked_past_up_to_a_million_elements() -> None:
    codec = ScalarCodec(types("string[] names\nfloat64 value"), PAIR, "value")
    for count in (0, 1, 1000):
        data = struct.pack("<4sI", b"\0\1\0\0", count) + count * struct.pack("<I", 0)
        data += bytes(-(len(data) - 4) % 8) + struct.pack("<d", 0.5)
        assert codec.sample(data, 0).value == 0.5
    many = struct.pack("<4sI", b"\0\1\0\0", 1_000_001) + bytes(5_000_000)
    with pytest.raises(MessageError, match="do not fit"):
        codec.sample(many, 0)


def test_names_that_are_no_utf8_cost_no_other_topic(tmp_path: Path) -> None:
    messages = points(6, ["/s1", "/##", "/s2"])
    options = McapOptions(enable_crcs=False, compression=CompressionType.NONE)
    path = write_by_mcap(tmp_path / "bag.mcap", messages, options)
    path.write_bytes(path.read_bytes().replace(b"/##", b"/\xff\xc3"))
    with open_bag(path) as bag:
        assert sorted(bag.topics) == ["/s1", "/s2", "/\ufffd\ufffd"]
        assert [each.data for each in bag.messages()] == [each.data for each in messages]
        assert {each.msgtype for each in bag.topics.values()} == {POINT}
        assert bag.problems == []
