# SPDX-License-Identifier: Apache-2.0
"""Pictures small enough for a repository."""

from __future__ import annotations

from pathlib import Path

from PIL import Image


def shrink(source: Path, target: Path) -> None:
    """Write a picture at half its size, in few colours.

    Args:
        source: A picture drawn at twice the size at which it is shown.
        target: The file to write.
    """
    target.parent.mkdir(exist_ok=True)
    with Image.open(source) as picture:
        small = picture.convert("RGB").resize((picture.width // 2, picture.height // 2))
        small.quantize(64).save(target, optimize=True)
