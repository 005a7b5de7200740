# SPDX-License-Identifier: Apache-2.0
"""New bags: what rosbag2 expects, whole after kills and interrupts, equal bytes for equal input."""

from __future__ import annotations

import errno
import hashlib
import itertools
import os
import signal
import subprocess
import sys
import types
from pathlib import Path
from typing import Any

import pytest
import yaml
from bag.making import (
    BEGIN_NS,
    FLOAT,
    POINT,
    chunk_ends,
    definition_text,
    float_data,
    point_data,
    points,
    write_bag,
)
from hypothesis import given
from hypothesis import strategies as st
from mcap.reader import make_reader
from rosbags.highlevel import AnyReader
from rosbags.interfaces import QosTime

from fuzzy_fusion_ros.bag import (
    BagMessage,
    BagWriter,
    Definition,
    metadata,
    offered_qos,
    open_bag,
    writer,
)
from fuzzy_fusion_ros.bag.mcap import writer as mcap_writer
from fuzzy_fusion_ros.messages import FieldType
from fuzzy_fusion_ros.parameters.errors import BagError

HASH = "RIHS01_4c0296af86e01e562e9e0405d138a01537247580076c58ea38d7923ac1045897"


@given(
    st.lists(
        st.tuples(
            st.sampled_from(["/a", "/b", "/c"]),
            st.integers(0, 5_000_000_000),
            st.binary(max_size=60_000),
        ),
        max_size=30,
    )
)
def test_all_readers_read_the_same(
    tmp_path_factory: pytest.TempPathFactory, rows: list[tuple[str, int, bytes]]
) -> None:
    """Ours, rosbags' and mcap's with all checksums; any bytes as data."""
    messages = [BagMessage(topic, FLOAT, time, data) for topic, time, data in rows]
    path = write_bag(tmp_path_factory.mktemp("bags") / "bag", messages)
    expected = sorted(messages, key=lambda each: each.log_ns)
    with open_bag(path.parent) as bag:
        assert list(bag.messages()) == expected
        assert bag.problems == []
    with AnyReader([path.parent]) as reader:
        found = [(each.topic, time, data) for each, time, data in reader.messages()]
        assert found == [(each.topic, each.log_ns, each.data) for each in expected]
        assert reader.message_count == len(messages)
    with path.open("rb") as file:
        library = make_reader(file, validate_crcs=True)
        found = [
            (channel.topic, each.log_time, each.data)
            for _, channel, each in library.iter_messages()
        ]
        assert found == [(each.topic, each.log_ns, each.data) for each in expected]
        summary = library.get_summary()
        assert summary is not None
        assert summary.statistics is not None
        assert summary.statistics.message_count == len(messages)
        assert len(summary.chunk_indexes) == summary.statistics.chunk_count


def test_the_metadata_are_those_of_rosbag2(tmp_path: Path) -> None:
    qos = offered_qos(depth=5, reliability="best_effort")._replace(deadline=QosTime(1, 500_000_000))
    with BagWriter(tmp_path / "run") as bag:
        bag.add_topic("/s1", POINT, qos=[qos, offered_qos()])
        bag.add_topic("/unused", FLOAT)
        for message in points(150):
            bag.write(*message)
    (root, information), *rest = yaml.safe_load(
        (tmp_path / "run/metadata.yaml").read_text()
    ).items()
    assert (root, rest) == ("rosbag2_bagfile_information", [])
    span = {
        "duration": {"nanoseconds": 1_490_000_000},
        "starting_time": {"nanoseconds_since_epoch": BEGIN_NS},
    }
    infinite = {"sec": 9223372036, "nsec": 854775807}
    first, second = information.pop("topics_with_message_count")
    assert information == {
        "version": 9,
        "storage_identifier": "mcap",
        **span,
        "message_count": 150,
        "compression_format": "",
        "compression_mode": "",
        "relative_file_paths": ["run_0.mcap"],
        "files": [{"path": "run_0.mcap", **span, "message_count": 150}],
        "custom_data": None,
        "ros_distro": "jazzy",
    }
    offered = first["topic_metadata"].pop("offered_qos_profiles")
    assert first == {
        "topic_metadata": {
            "name": "/s1",
            "type": POINT,
            "serialization_format": "cdr",
            "type_description_hash": HASH,
        },
        "message_count": 150,
    }
    assert offered[0] == {
        "history": "keep_last",
        "depth": 5,
        "reliability": "best_effort",
        "durability": "volatile",
        "deadline": {"sec": 1, "nsec": 500_000_000},
        "lifespan": infinite,
        "liveliness": "automatic",
        "liveliness_lease_duration": infinite,
        "avoid_ros_namespace_conventions": False,
    }
    assert (offered[1]["depth"], offered[1]["reliability"]) == (10, "reliable")
    assert (second["topic_metadata"]["name"], second["message_count"]) == ("/unused", 0)
    with open_bag(tmp_path / "run") as read:
        assert read.topics["/s1"].qos == (qos, offered_qos())
        assert read.topics["/unused"].message_count == 0


def test_the_file_describes_topics_and_itself_as_rosbag2_does(tmp_path: Path) -> None:
    path = write_bag(tmp_path / "run", points(3))
    with path.open("rb") as file:
        reader = make_reader(file)
        assert reader.get_header().profile == "ros2"
        summary = reader.get_summary()
        assert summary is not None
        (schema,) = summary.schemas.values()
        (channel,) = summary.channels.values()
        (record,) = reader.iter_metadata()
    assert (schema.name, schema.encoding) == (POINT, "ros2msg")
    assert schema.data.decode() == definition_text(POINT)
    assert (channel.topic, channel.message_encoding) == ("/s1", "cdr")
    assert channel.metadata == {"offered_qos_profiles": "", "topic_type_hash": HASH}
    assert record.name == "rosbag2"
    whole = yaml.safe_load((path.parent / "metadata.yaml").read_text())
    described = yaml.safe_load(record.metadata["serialized_metadata"])
    assert whole == {"rosbag2_bagfile_information": described}


def test_equal_messages_give_equal_files(tmp_path: Path) -> None:
    digests = set()
    for place in ("one", "two"):
        path = write_bag(tmp_path / place / "run", points(500, ["/s1", "/s2"]))
        text = (path.parent / "metadata.yaml").read_bytes()
        digests.add(hashlib.sha256(path.read_bytes() + text).hexdigest())
    assert len(digests) == 1


def test_a_topic_can_be_copied_from_a_bag_with_all_that_describes_it(tmp_path: Path) -> None:
    unknown = Definition("ros2msg", "float64 a\nfloat64 b", "RIHS01_" + "0" * 64)
    message = BagMessage("/x", "secret_msgs/msg/Pair", 5, b"\0\1\0\0" + bytes(16))
    with BagWriter(tmp_path / "one") as bag:
        bag.add_topic("/x", message.msgtype, qos=[offered_qos(depth=3)], definition=unknown)
        bag.write(*message)
    with open_bag(tmp_path / "one") as source, BagWriter(tmp_path / "two") as target:
        for topic in source.topics.values():
            target.add_topic(topic.name, topic.msgtype, qos=topic.qos, definition=topic.definition)
        for each in source.messages():
            target.write(*each)
    with open_bag(tmp_path / "one") as one, open_bag(tmp_path / "two") as two:
        assert one.topics == two.topics
        assert two.topics["/x"].definition == unknown
        assert list(two.messages()) == [message]
        assert list(two.types.fields(message.msgtype)) == ["a", "b"]


def test_one_type_may_come_with_two_definitions(tmp_path: Path) -> None:
    with BagWriter(tmp_path / "bag") as bag:
        bag.add_topic("/a", FLOAT)
        bag.add_topic("/b", FLOAT, definition=Definition("ros2msg", "float64 other"))
        bag.write("/b", FLOAT, 1, float_data(2.0))
    with open_bag(tmp_path / "bag") as read:
        definitions = [topic.definition.text for topic in read.topics.values() if topic.definition]
        assert definitions == [definition_text(FLOAT), "float64 other"]
        assert read.types.fields(FLOAT) == {"data": FieldType("float64")}
        assert "std_msgs/msg/Float64 has two definitions; using the first" in read.problems[0]


def test_a_type_without_any_definition_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path))
    with (
        BagWriter(tmp_path / "bag") as bag,
        pytest.raises(
            BagError, match=r"'secret_msgs/msg/Pair' has no definition: source the package"
        ),
    ):
        bag.write("/x", "secret_msgs/msg/Pair", 1, b"")


def test_a_directory_that_holds_something_is_refused(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("keep me")
    with pytest.raises(BagError, match=r"exists: choose another directory or remove it"):
        BagWriter(tmp_path)
    assert (tmp_path / "notes.txt").read_text() == "keep me"


def test_an_empty_directory_or_a_missing_one_is_taken(tmp_path: Path) -> None:
    for path in (tmp_path, tmp_path / "x" / "y"):
        if path == tmp_path:
            path = tmp_path / "empty"
            path.mkdir()
        write_bag(path, points(1))


def test_a_place_that_cannot_be_written_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(BagError, match=r"cannot be written: (File exists|Not a directory)"):
        BagWriter(tmp_path / "file")
    with pytest.raises(BagError, match=r"cannot be written: Not a directory$"):
        BagWriter(tmp_path / "file" / "bag")


def test_a_topic_may_have_messages_of_two_types(tmp_path: Path) -> None:
    """As an MCAP file that is copied can have."""
    messages = [
        BagMessage("/x", FLOAT, 1, float_data(1.0)),
        BagMessage("/x", POINT, 2, point_data(2, 1.0)),
    ]
    path = write_bag(tmp_path / "bag", messages).parent
    with open_bag(path) as read:
        assert list(read.messages()) == messages
        assert read.topics["/x"].other_types == (POINT,)
    with AnyReader([path]) as reader:
        assert [each.msgtype for each, _, _ in reader.messages()] == [FLOAT, POINT]


@pytest.mark.parametrize(
    ("msgtype", "definition"),
    [
        ("secret_msgs/msg/Pair", Definition("unknown", "")),
        ("secret_msgs/msg/Pair", Definition("", "")),
        ("", Definition("", "")),
    ],
)
def test_other_readers_open_a_bag_with_an_undescribed_type(
    tmp_path: Path, msgtype: str, definition: Definition
) -> None:
    path = tmp_path / "bag"
    with BagWriter(path) as bag:
        bag.add_topic("/x", msgtype, definition=definition)
        bag.write("/x", msgtype, 1, b"whatever")
        bag.write("/s1", FLOAT, 2, float_data(1.0))
    with AnyReader([path]) as reader:
        assert [data for _, _, data in reader.messages()] == [b"whatever", float_data(1.0)]
    with (path / "bag_0.mcap").open("rb") as file:
        found = [each.data for _, _, each in make_reader(file).iter_messages()]
    assert found == [b"whatever", float_data(1.0)]


@pytest.mark.parametrize("log_ns", [-1, 2**63])
def test_a_log_time_out_of_range_is_refused(tmp_path: Path, log_ns: int) -> None:
    with (
        BagWriter(tmp_path / "bag") as bag,
        pytest.raises(BagError, match=rf"log time {log_ns} ns is out of range"),
    ):
        bag.write("/x", FLOAT, log_ns, b"")


def test_a_closed_bag_takes_nothing_more(tmp_path: Path) -> None:
    bag = BagWriter(tmp_path / "bag")
    bag.write("/x", FLOAT, 1, float_data(1.0))
    bag.close()
    before = {each: each.read_bytes() for each in (tmp_path / "bag").iterdir()}
    bag.close()
    with pytest.raises(BagError, match="is closed: nothing can be written to it"):
        bag.write("/x", FLOAT, 2, float_data(1.0))
    assert {each: each.read_bytes() for each in (tmp_path / "bag").iterdir()} == before


def test_an_error_of_the_caller_leaves_a_whole_bag(tmp_path: Path) -> None:
    class Oops(Exception):
        pass

    def fail() -> None:
        with BagWriter(tmp_path / "bag") as bag:
            bag.write("/x", FLOAT, 1, float_data(1.0))
            raise Oops

    with pytest.raises(Oops):
        fail()
    with open_bag(tmp_path / "bag") as read:
        assert (read.message_count, read.problems) == (1, [])


def test_metadata_are_there_from_the_start_and_keep_up(tmp_path: Path) -> None:
    """A bag whose recorder was killed counts at least half of what is there."""
    messages = points(3000)
    bag = BagWriter(tmp_path / "bag")
    for at, message in enumerate(messages, 1):
        bag.write(*message)
        if at % 101 > 1:
            continue
        text = (tmp_path / "bag/metadata.yaml").read_text()
        information = yaml.safe_load(text)["rosbag2_bagfile_information"]
        on_disk = at // 101 * 101
        assert on_disk // 2 <= information["message_count"] <= on_disk
        if on_disk:
            start = information["starting_time"]["nanoseconds_since_epoch"]
            assert start == BEGIN_NS
        if at % 303 == 0:
            with open_bag(tmp_path / "bag") as read:  # while it is being written
                assert list(read.messages()) == messages[:on_disk]
    bag.close()


def recorder(path: Path, then: str) -> list[str]:
    """Return the command of a process that records points until it is stopped."""
    program = f"""
import itertools, sys
sys.path.insert(0, {str(Path(__file__).parents[1])!r})
from bag.making import points
from fuzzy_fusion_ros.bag import BagWriter
bag = BagWriter({str(path)!r})
messages = points(100_000)
try:
    for at, message in enumerate(messages):
        bag.write(*message)
        if at == 5_000:
            print("recording", flush=True)
except KeyboardInterrupt:
    {then}
"""
    return [sys.executable, "-c", program]


def stopped_by(command: list[str], number: int) -> int:
    """Run a recorder, send it a signal while it records, return its exit status."""
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    with process:
        assert process.stdout is not None
        assert process.stdout.readline() == "recording\n"
        process.send_signal(number)
        return process.wait()


def test_after_a_kill_all_whole_chunks_are_readable(tmp_path: Path) -> None:
    path = tmp_path / "bag"
    assert stopped_by(recorder(path, "raise"), signal.SIGKILL) == -signal.SIGKILL
    messages = points(100_000)
    with open_bag(path) as bag:
        found = list(bag.messages())
        assert found == messages[: len(found)]
        assert len(found) == 101 * len(chunk_ends((path / "bag_0.mcap").read_bytes()))
        assert len(found) > 4_900
        assert "it is incomplete: the recorder was killed" in bag.problems[0]


def test_after_an_interrupt_the_bag_can_be_closed_whole(tmp_path: Path) -> None:
    path = tmp_path / "bag"
    assert stopped_by(recorder(path, "bag.close()"), signal.SIGINT) == 0
    with open_bag(path) as bag:
        found = list(bag.messages())
        assert found == points(100_000)[: len(found)]
        assert len(found) > 5_000
        assert bag.problems == []


WATCHED = {writer.__file__, mcap_writer.__file__, metadata.__file__}

# The last of these messages fills a chunk, so that all of the writer's code is executed.
CHUNK = [*points(3), points(101)[-1]]


class Interrupt:
    """Raises KeyboardInterrupt at the n-th line that the writer executes."""

    def __init__(self, line: int) -> None:
        self.left = line

    def __call__(self, frame: types.FrameType, event: str, argument: object) -> Any:
        if frame.f_code.co_filename not in WATCHED:
            return None
        if event == "line":
            self.left -= 1
            if self.left == 0:
                sys.settrace(None)
                raise KeyboardInterrupt
        return self


def interrupted(bag: BagWriter, line: int) -> bool:
    """Write the last message, interrupted at a line; return whether it came that far."""
    before = sys.gettrace()
    sys.settrace(Interrupt(line))
    try:
        bag.write(*CHUNK[-1])
    except KeyboardInterrupt:
        return True
    finally:
        sys.settrace(before)
    return False


def test_an_interrupt_at_any_line_of_a_write_loses_at_most_that_message(tmp_path: Path) -> None:
    """Ctrl-C in a replay."""
    messages = CHUNK
    for line in itertools.count(1):
        path = tmp_path / str(line) / "bag"
        with BagWriter(path) as bag:
            for message in messages[:-1]:
                bag.write(*message)
            came = interrupted(bag, line)
        with open_bag(path) as read:
            found = list(read.messages())
            assert read.problems == []
        assert found in (messages[:-1], messages)
        if not came:
            assert line > 50
            return


FULL_DISK = f"""
import resource, signal, sys
sys.path.insert(0, {str(Path(__file__).parents[1])!r})
from bag.making import points
from fuzzy_fusion_ros.bag import BagWriter
from fuzzy_fusion_ros.parameters.errors import BagError
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)  # a write past the limit fails, as on a full disk
bag = BagWriter(sys.argv[1])
soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, hard))
refusals = []
for message in points(3_000):
    try:
        bag.write(*message)
    except BagError as error:
        refusals.append(str(error))
bag.close()
resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
print(len(refusals), refusals[0])
"""


def test_a_full_disk_is_an_error_and_what_was_written_stays_readable(tmp_path: Path) -> None:
    path = tmp_path / "bag"
    done = subprocess.run(
        [sys.executable, "-c", FULL_DISK, str(path)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, "")
    count, _, refusal = done.stdout.partition(" ")
    assert "cannot be written: File too large; what was written before stays readable" in refusal
    with open_bag(path) as bag:
        found = list(bag.messages())
        assert found == points(3_000)[: len(found)]
        assert len(found) > 300
        # The message that filled the chunk and all after it were refused.
        assert len(found) + 100 + int(count) == 3_000
        # The file ends with a whole chunk: nothing torn is left behind.
        assert bag.problems[0].endswith("the recorder was killed or the copy was cut off")
        assert not any("are lost" in each for each in bag.problems)


def test_a_bag_that_cannot_be_finished_says_so_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    bag = BagWriter(tmp_path / "bag")
    for message in points(150):
        bag.write(*message)

    def full(self: object, position: int, data: bytes) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(mcap_writer.McapWriter, "_put", full)
    with pytest.raises(BagError, match="cannot be written: No space left on device"):
        bag.close()
    bag.close()
    with open_bag(tmp_path / "bag") as read:
        assert list(read.messages()) == points(101)


def test_a_disk_full_from_the_start_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*arguments: object) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    with monkeypatch.context() as patch:
        patch.setattr(writer, "write_metadata", full)
        with pytest.raises(BagError, match=r"cannot be written: No space left on device$"):
            BagWriter(tmp_path / "one")
    monkeypatch.setattr(mcap_writer.McapWriter, "_put", full)
    with pytest.raises(BagError, match="cannot be written: No space left on device"):
        BagWriter(tmp_path / "two")


def test_an_empty_bag_is_valid(tmp_path: Path) -> None:
    with BagWriter(tmp_path / "bag") as bag:
        bag.add_topic("/x", FLOAT)
    with AnyReader([tmp_path / "bag"]) as reader:
        assert list(reader.messages()) == []
    with open_bag(tmp_path / "bag") as read:
        assert (read.message_count, read.problems) == (0, [])
        assert read.topics["/x"].msgtype == FLOAT


def test_names_beyond_an_ascii_locale_are_written_and_read(tmp_path: Path) -> None:
    program = """
import sys
from fuzzy_fusion_ros.bag import BagWriter, open_bag
with BagWriter(sys.argv[1]) as writer:
    writer.add_topic("/s1", "std_msgs/msg/Float64")
    writer.write("/s1", "std_msgs/msg/Float64", 1, bytes(12))
with open_bag(sys.argv[1]) as bag:
    print(bag.message_count, bag.problems)
"""
    plain = {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}
    done = subprocess.run(
        [sys.executable, "-c", program, str(tmp_path / "\u00f6")],
        env={**os.environ, **plain},
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.stdout, done.stderr) == ("1 []\n", "")
    with open_bag(tmp_path / "\u00f6") as bag:
        assert (bag.message_count, bag.problems) == (1, [])
