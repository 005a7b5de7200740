"""The ``metadata.yaml`` of a rosbag2 directory."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import yaml

from fuzzy_fusion_ros.bag.topic import Topic
from fuzzy_fusion_ros.parameters.errors import BagError

METADATA_NAME = "metadata.yaml"
VERSION = 9

_DUMPER = getattr(yaml, "CSafeDumper", yaml.SafeDumper)  # ten times as fast, where it is there
_ROOT = "rosbag2_bagfile_information"


class Metadata(NamedTuple):
    """What is read from a ``metadata.yaml``; the rest is in the storage files themselves.

    Attributes:
        files: The names of the storage files in their order.
        compression_mode: ``""``, ``"file"`` or ``"message"``.
        message_count: Messages in all files, as the recorder counted them.
    """

    files: tuple[str, ...]
    compression_mode: str
    message_count: int


def read_metadata(directory: Path) -> Metadata:
    """Return the metadata of a bag directory.

    Raises:
        BagError: It is missing, unreadable or not rosbag2's.
    """
    path = directory / METADATA_NAME
    try:
        information = yaml.safe_load(path.read_text(encoding="utf-8"))[_ROOT]
        mode = str(information.get("compression_mode") or "").lower()
        if mode not in {"", "none", "file", "message", "storage"}:
            raise BagError(f"{path} has compression_mode {mode!r}: expected file or message")
        return Metadata(
            files=tuple(Path(each).name for each in information["relative_file_paths"]),
            compression_mode=mode if mode in {"file", "message"} else "",
            message_count=int(information["message_count"]),
        )
    except FileNotFoundError:
        raise BagError(f"{path} is missing: the recorder did not close the bag") from None
    except OSError as error:
        raise BagError(f"{path} cannot be read: {error.strerror}") from error
    except (yaml.YAMLError, LookupError, TypeError, ValueError, AttributeError) as error:
        text = " ".join(str(error).split())
        raise BagError(f"{path} is not rosbag2's: {text}") from error


def describe_bag(file_name: str, topics: Sequence[Topic], start_ns: int, end_ns: int) -> str:
    """Return the metadata of a bag of one MCAP file, as rosbag2 of Jazzy writes it.

    Args:
        file_name: The storage file's name.
        topics: The topics with their message counts.
        start_ns: The earliest log time, ns.
        end_ns: The latest log time, ns.

    Returns:
        YAML text without the root key, as an MCAP file of rosbag2 holds it.
    """
    span = {
        "duration": {"nanoseconds": end_ns - start_ns},
        "starting_time": {"nanoseconds_since_epoch": start_ns},
    }
    count = sum(topic.message_count or 0 for topic in topics)
    information = {
        "version": VERSION,
        "storage_identifier": "mcap",
        **span,
        "message_count": count,
        "topics_with_message_count": [_describe_topic(topic) for topic in topics],
        "compression_format": "",
        "compression_mode": "",
        "relative_file_paths": [file_name],
        "files": [{"path": file_name, **span, "message_count": count}],
        "custom_data": None,
        "ros_distro": "jazzy",
    }
    plain = json.loads(json.dumps(information))  # repeated parts as such, not as YAML's anchors
    return yaml.dump(plain, Dumper=_DUMPER, sort_keys=False)


def write_metadata(directory: Path, information: str) -> None:
    """Write ``metadata.yaml`` so that it is the old or the new one at any time, never half.

    Args:
        directory: The bag.
        information: As :func:`describe_bag` returns it.

    Raises:
        OSError: It cannot be written.
    """
    lines = "".join(f"  {line}\n" for line in information.splitlines())
    draft = directory / f".{METADATA_NAME}.tmp"
    draft.write_text(f"{_ROOT}:\n{lines}", encoding="utf-8")
    os.replace(draft, directory / METADATA_NAME)


def _describe_topic(topic: Topic) -> dict[str, Any]:
    return {
        "topic_metadata": {
            "name": topic.name,
            "type": topic.msgtype,
            "serialization_format": topic.encoding,
            "offered_qos_profiles": [profile.to_rosbag2() for profile in topic.qos],
            "type_description_hash": topic.definition.digest if topic.definition else "",
        },
        "message_count": topic.message_count or 0,
    }
