# SPDX-License-Identifier: Apache-2.0
"""YAML from untrusted sources: checked before it is read into memory.

A hundred bytes of it can recurse forever, or expand to terabytes.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import yaml

LARGEST = 4 << 20
"""Bytes of a file."""

DEEPEST = 50
"""Collections within each other."""

MOST_VALUES = 200_000
"""Scalars and collections, those that aliases stand for counted each time."""

LOADER: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
"""Safe, and ten times faster where libyaml is."""


class YamlLimitError(yaml.YAMLError):
    """YAML that is too large, too deep or recursive."""


def read_yaml_text(path: Path) -> str:
    """Return the text of a file.

    Raises:
        OSError: The file cannot be read.
        UnicodeDecodeError: It is not UTF-8.
        YamlLimitError: It is too large.
    """
    with path.open("rb") as file:
        data = file.read(LARGEST + 1)
    if len(data) > LARGEST:
        raise YamlLimitError(f"it is larger than {LARGEST} bytes")
    return data.decode("utf-8")


def checked_yaml(text: str, *, largest: int = LARGEST, aliases: bool = True) -> str:
    """Return a text that can be composed within bounds of memory and time.

    Args:
        text: YAML.
        largest: Characters that it may have.
        aliases: Whether there may be aliases.

    Raises:
        YAMLError: It is not valid YAML; a :class:`YamlLimitError` if it is too large, too deep, or
            an alias contains itself.
    """
    if len(text) > largest:
        raise YamlLimitError(f"it is longer than {largest} characters")
    anchors: dict[str, int] = {}
    open_: list[tuple[str | None, int]] = [(None, 0)]  # anchor and values of each collection
    for event in _events(text):
        anchor: str | None = getattr(event, "anchor", None)
        count = 1
        if isinstance(event, yaml.CollectionStartEvent):
            if len(open_) > DEEPEST:
                raise YamlLimitError(f"it nests more than {DEEPEST} levels deep")
            open_.append((anchor, 1))
            continue
        if isinstance(event, yaml.CollectionEndEvent):
            anchor, count = open_.pop()
        elif isinstance(event, yaml.AliasEvent):
            if not aliases:
                raise YamlLimitError(f"it has an alias, {anchor!r}; ROS supports none")
            if anchor in (owner for owner, _ in open_):
                raise YamlLimitError(f"alias {anchor!r} contains itself")
            count = anchors.get(anchor or "", 1)  # the loader refuses an unknown one
            anchor = None
        elif not isinstance(event, yaml.ScalarEvent):
            continue
        if anchor is not None:
            anchors[anchor] = count
        owner, total = open_.pop()
        open_.append((owner, total + count))
        if total + count > MOST_VALUES:
            raise YamlLimitError(f"it holds more than {MOST_VALUES} values")
    return text


def _events(text: str) -> Iterator[Any]:
    try:
        yield from yaml.parse(text, Loader=LOADER)
    except yaml.YAMLError as error:
        if "nesting depth" in str(error):  # of libyaml, which reads ahead
            raise YamlLimitError(f"it nests more than {DEEPEST} levels deep") from None
        raise
