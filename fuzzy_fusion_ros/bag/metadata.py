# SPDX-License-Identifier: Apache-2.0
"""The ``metadata.yaml`` of a rosbag2 directory, and the QoS profiles of its topics.

Read here instead of by rosbags because a bag whose metadata are missing or wrong is read all the
same (measured by test/bag/test_reader.py). QoS profiles are rosbags'.
"""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import yaml
from rosbags.interfaces import (
    Qos,
    QosDurability,
    QosHistory,
    QosLiveliness,
    QosReliability,
    QosTime,
)

from fuzzy_fusion_ros.bag.topic import Topic
from fuzzy_fusion_ros.parameters.errors import BagError
from fuzzy_fusion_ros.parameters.yaml_text import YamlLimitError, checked_yaml, read_yaml_text

METADATA_NAME = "metadata.yaml"
VERSION = 9

_DUMPER = getattr(yaml, "CSafeDumper", yaml.SafeDumper)  # ten times faster, where libyaml is
_ROOT = "rosbag2_bagfile_information"
_TEXTS: Any = getattr(yaml, "CBaseLoader", yaml.BaseLoader)
_LONGEST_NAME = 255
_LONGEST_QOS = 64 * 1024
_INFINITE = QosTime(9_223_372_036, 854_775_807)  # 2^63 - 1 ns, as rosbag2 writes it


class MetadataError(BagError):
    """Metadata are missing or damaged; the messages can be read without them."""


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
        MetadataError: They are missing, unreadable or not rosbag2's.
        BagError: They are made to exhaust memory.
    """
    path = directory / METADATA_NAME
    try:
        text = checked_yaml(read_yaml_text(path))
        information = yaml.load(text, Loader=_TEXTS)[_ROOT]
        mode = str(information.get("compression_mode") or "").lower()
        if mode not in {"", "none", "file", "message", "storage"}:
            raise MetadataError(f"it has compression_mode {mode!r}: expected file or message")
        paths = information["relative_file_paths"]
        if not isinstance(paths, list):
            raise TypeError(f"relative_file_paths is {paths!r}, expected a list")
        return Metadata(
            files=tuple(map(_file_name, paths)),
            compression_mode=mode if mode in {"file", "message"} else "",
            message_count=int(information["message_count"]),
        )
    except FileNotFoundError:
        raise MetadataError("it is missing: the recorder did not close the bag") from None
    except OSError as error:
        raise MetadataError(f"it cannot be read: {error.strerror}") from error
    except YamlLimitError as error:
        raise BagError(f"{path} is refused: {error}") from error
    except (yaml.YAMLError, LookupError, TypeError, ValueError, AttributeError) as error:
        reason = " ".join(str(error).split())
        raise MetadataError(f"it is not valid rosbag2 metadata: {reason[:200]}") from error


def _file_name(path: str) -> str:
    name = Path(path).name.encode()
    if not name or len(name) > _LONGEST_NAME or b"\0" in name:
        raise ValueError(f"{name[:80]!r} is not a file name")
    return os.fsdecode(name)


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


def offered_qos(
    depth: int = 10, reliability: str = "reliable", durability: str = "volatile"
) -> Qos:
    """Return a profile that a publisher may offer; the other policies are ROS' defaults.

    Args:
        depth: Messages kept.
        reliability: ``reliable`` or ``best_effort``.
        durability: ``volatile`` or ``transient_local``.
    """
    return Qos(
        history=QosHistory.KEEP_LAST,
        depth=depth,
        reliability=QosReliability[reliability.upper()],
        durability=QosDurability[durability.upper()],
        deadline=_INFINITE,
        lifespan=_INFINITE,
        liveliness=QosLiveliness.AUTOMATIC,
        liveliness_lease_duration=_INFINITE,
        avoid_ros_namespace_conventions=False,
    )


@lru_cache(maxsize=256)
def qos_to_text(profiles: tuple[Qos, ...]) -> str:
    """Return profiles as the YAML text that an MCAP channel holds."""
    described = _described(profiles)
    return yaml.safe_dump(described, sort_keys=False).strip() if described else ""


@lru_cache(maxsize=256)
def qos_from_text(text: str) -> tuple[Qos, ...]:
    """Return the profiles that a storage file describes, of any version of rosbag2.

    Args:
        text: YAML; empty for no profiles.

    Raises:
        MetadataError: The text describes no profiles.
        BagError: It is made to exhaust memory.
    """
    if not text:
        return ()
    from rosbags.rosbag2.metadata import parse_qos  # 0.1 s that bags without profiles save

    try:
        described = yaml.safe_load(checked_yaml(text, largest=_LONGEST_QOS)) or []
        if not isinstance(described, list):
            raise TypeError("they are not a list")
        profiles = tuple(parse_qos(described))
        if not all(isinstance(each, int) for profile in profiles for each in _numbers(profile)):
            raise TypeError("a depth or a duration is not an integer")
    except YamlLimitError as error:
        raise BagError(f"its offered QoS profiles are refused: {error}") from error
    except (yaml.YAMLError, LookupError, TypeError, ValueError, AttributeError) as error:
        reason = " ".join(str(error).split())
        raise MetadataError(f"its offered QoS profiles are not valid: {reason[:200]}") from error
    return profiles


def _numbers(profile: Qos) -> tuple[object, ...]:
    durations = (profile.deadline, profile.lifespan, profile.liveliness_lease_duration)
    return (profile.depth, *(part for duration in durations for part in duration))


def _described(profiles: Sequence[Qos]) -> list[Any]:
    if not profiles:
        return []
    from rosbags.rosbag2.metadata import dump_qos_v9  # 0.1 s that bags without profiles save

    return list(dump_qos_v9(list(profiles)))


def _describe_topic(topic: Topic) -> dict[str, Any]:
    return {
        "topic_metadata": {
            "name": topic.name,
            "type": topic.msgtype,
            "serialization_format": topic.encoding,
            "offered_qos_profiles": _described(topic.qos),
            "type_description_hash": topic.definition.digest if topic.definition else "",
        },
        "message_count": topic.message_count or 0,
    }
