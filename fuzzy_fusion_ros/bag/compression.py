# SPDX-License-Identifier: Apache-2.0
"""Decompression within bounds: a few kilobytes can claim to be, or become, gigabytes."""

from __future__ import annotations

from pathlib import Path

import lz4.frame
import zstandard

LARGEST = 128 << 20
"""Bytes of a chunk or a message, decompressed; what is larger is taken for damaged."""

FILE_AT_LEAST = 256 << 20
FILE_RATIO = 100
"""A file may become as large as the former in bytes, or as the latter times its own size."""

_BLOCK = 1 << 20
_ZSTD = zstandard.ZstdDecompressor()


def decompress(compression: str, data: bytes, size: int = LARGEST) -> bytes:
    """Return a chunk or a message decompressed.

    Args:
        compression: ``zstd``, ``lz4`` or nothing.
        data: What is compressed.
        size: The most that it may become, bytes; at most ``LARGEST``.

    Raises:
        ValueError: It would become larger, or the compression is unknown.
        ZstdError: It is damaged.
        RuntimeError: It is damaged.
    """
    if size > LARGEST:
        raise ValueError(f"it claims {size} bytes, at most {LARGEST} are read")
    if not compression:
        return data
    if compression == "zstd":
        claimed = zstandard.frame_content_size(data)  # negative where the frame does not say
        if claimed > size:
            raise ValueError(f"it claims {claimed} bytes, at most {size} are expected")
        return _ZSTD.decompress(data, max_output_size=size)
    if compression == "lz4":
        plain: bytes = lz4.frame.LZ4FrameDecompressor().decompress(data, max_length=size + 1)
        if len(plain) > size:
            raise ValueError(f"it decompresses to more than {size} bytes")
        return plain
    raise ValueError(f"unknown compression {compression!r}")


def decompress_file(path: Path, target: Path) -> None:
    """Decompress a zstd file into another one, as far as it is whole.

    Raises:
        ValueError: It would become too large.
        ZstdError: It is damaged; what stands before is in the other file.
        OSError: It cannot be read, or the other file not be written.
    """
    limit = max(FILE_AT_LEAST, FILE_RATIO * path.stat().st_size)
    with path.open("rb") as compressed, target.open("wb") as plain:
        reader = zstandard.ZstdDecompressor().stream_reader(compressed, read_across_frames=True)
        while block := reader.read(_BLOCK):
            limit -= plain.write(block)
            if limit < 0:
                raise ValueError(
                    f"it decompresses to more than {FILE_RATIO} times its size: "
                    "decompress it yourself"
                )
