# SPDX-License-Identifier: Apache-2.0
"""Finds and opens the storage files of a bag."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterator, Sequence
from pathlib import Path
from typing import Protocol

import zstandard

from fuzzy_fusion_ros.bag.block import Block
from fuzzy_fusion_ros.bag.compression import decompress_file
from fuzzy_fusion_ros.bag.mcap.file import McapFile
from fuzzy_fusion_ros.bag.metadata import METADATA_NAME, Metadata, MetadataError, read_metadata
from fuzzy_fusion_ros.bag.problems import Problems
from fuzzy_fusion_ros.bag.sqlite_file import SqliteFile
from fuzzy_fusion_ros.bag.topic import BagMessage, Topic
from fuzzy_fusion_ros.parameters.errors import BagError

_KINDS: dict[str, type[McapFile] | type[SqliteFile]] = {".mcap": McapFile, ".db3": SqliteFile}
_COMPRESSED = ".zstd"
_ROS1_MAGIC = b"#ROSBAG V"


class Storage(Protocol):
    """One storage file.

    Attributes:
        topics: What the file holds.
        start_ns: The earliest log time, ns; None without messages.
        end_ns: The latest log time, ns; None without messages.
    """

    topics: list[Topic]
    start_ns: int | None
    end_ns: int | None

    def messages(
        self, names: Collection[str] | None, start_ns: int, stop_ns: int
    ) -> Iterator[BagMessage]:
        """Yield messages of some topics, or of all, within a half-open span of log times."""
        ...

    def blocks(self, names: Collection[str] | None, start_ns: int, stop_ns: int) -> Iterator[Block]:
        """Yield the same messages side by side."""
        ...

    def close(self) -> None:
        """Close the file."""
        ...


def find_files(path: Path, problems: Problems) -> tuple[list[Path], Metadata | None]:
    """Return the storage files of a bag in their order, and its metadata if they are good.

    Args:
        path: A rosbag2 directory or a storage file.
        problems: Told of what is not whole.

    Raises:
        BagError: There is no storage file, or the metadata are made to exhaust memory.
    """
    try:
        if path.is_file():
            return [path], None
        present = sorted(filter(_is_storage, path.iterdir()), key=_natural)
    except FileNotFoundError:
        raise BagError(
            f"bag {str(path)!r} does not exist: give a rosbag2 directory or an .mcap file"
        ) from None
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else error
        raise BagError(f"bag {str(path)!r} cannot be read: {reason}") from error
    metadata = None
    try:
        metadata = read_metadata(path)
    except MetadataError as error:
        problems.note(METADATA_NAME, str(error))
    listed = [path / name for name in metadata.files] if metadata else []
    files = [each for each in listed if each.exists()]
    missing = [each.name for each in listed if not each.exists()]
    others = [each.name for each in present if each not in files]
    if not (files or present):
        raise BagError(_without_storage(path, missing))
    instead = f"; reading {', '.join(others)} instead" if others and not files else ""
    for name in missing:
        problems.note(name, f"metadata.yaml lists this file, but it is missing{instead}")
    for name in others if files else ():
        problems.note(name, "metadata.yaml does not list this file: left out")
    return files or present, metadata


def _without_storage(path: Path, missing: Sequence[str]) -> str:
    """Say why a directory without storage files is not a bag."""
    old = next(path.glob("*.bag"), None)
    if old is not None:
        return _ros1(old)
    if missing:
        return (
            f"bag {str(path)!r}: metadata.yaml lists {', '.join(missing)}, but there is no .mcap "
            "or .db3 file: put it back"
        )
    return f"bag {str(path)!r} holds no .mcap or .db3 file: it is not a rosbag2 directory"


def _ros1(path: Path) -> str:
    """Say how to make a ROS 1 bag readable."""
    target = path.with_suffix("")
    return (
        f"{str(path)!r} is a ROS 1 bag: convert it with "
        f"'rosbags-convert --src {path} --dst {target}' and give {target} instead"
    )


def is_compressed(path: Path) -> bool:
    """Return whether a storage file is compressed as a whole."""
    return path.suffix == _COMPRESSED


def open_file(path: Path, scratch: Path | None, note: Callable[[str], None]) -> Storage:
    """Open a storage file, decompressed first if it is compressed as a whole.

    Args:
        path: The file.
        scratch: A directory to decompress it into; needed if it is compressed.
        note: Told of all that is not whole.

    Raises:
        BagError: It cannot be read or is of no kind that is known.
    """
    if is_compressed(path) and scratch is not None:
        path = _decompress(path, scratch, note)
    kind = _KINDS.get(path.suffix)
    if kind is None:
        if _begins_with(path, _ROS1_MAGIC):
            raise BagError(_ros1(path))
        raise BagError(
            f"{str(path)!r} is not a bag: expected a rosbag2 directory, an .mcap or a .db3 file"
        )
    return kind(path, note)


def _begins_with(path: Path, magic: bytes) -> bool:
    try:
        with path.open("rb") as file:
            return file.read(len(magic)) == magic
    except OSError:
        return False


def _decompress(path: Path, scratch: Path, note: Callable[[str], None]) -> Path:
    target = scratch / path.stem
    try:
        decompress_file(path, target)
    except zstandard.ZstdError as error:
        note(f"it decompresses only in part ({error})")
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else error
        raise BagError(f"{str(path)!r} cannot be decompressed: {reason}") from error
    return target


def _is_storage(path: Path) -> bool:
    name = path.name.removesuffix(_COMPRESSED)
    return path.is_file() and Path(name).suffix in _KINDS


def _natural(path: Path) -> list[tuple[int, str]]:
    """Sort key: bag_2 before bag_10."""
    return [(int(part), "") if part.isdigit() else (-1, part) for part in _parts(path.name)]


def _parts(name: str) -> list[str]:
    return re.split(r"(\d+)", name)
