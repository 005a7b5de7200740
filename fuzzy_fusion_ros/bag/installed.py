# SPDX-License-Identifier: Apache-2.0
"""Definitions of message types from installed ``.msg`` and ``.idl`` files."""

from __future__ import annotations

import contextlib
import json
import os
import re
from collections.abc import Iterable
from pathlib import Path

from fuzzy_fusion_ros.bag.topic import Definition
from fuzzy_fusion_ros.parameters.errors import BagError

SEPARATOR = "=" * 80 + "\n"
"""Stands between the types of a definition."""

_NAME = re.compile(r"\w+/msg/\w+")
_FIELD = re.compile(
    r"^\s*([A-Za-z]\w*(?:/\w+)*)(?:<=\d+)?(?:\[[^\]]*\])?\s+[A-Za-z]\w*", re.MULTILINE
)
_INCLUDE = re.compile(r"^\s*#include\s+[<\"]([\w/]+)\.idl[>\"]", re.MULTILINE)
_PRIMITIVES = frozenset(
    ["bool", "byte", "char", "float32", "float64", "string", "wstring"]
    + [f"{sign}int{bits}" for sign in ("", "u") for bits in (8, 16, 32, 64)]
)


def installed_definition(msgtype: str) -> Definition:
    """Return the definition of an installed type, followed by those of its nested types.

    Args:
        msgtype: ``package/msg/Type``; looked up below AMENT_PREFIX_PATH.

    Raises:
        BagError: The type or a nested one is not installed.
    """
    if not _NAME.fullmatch(msgtype):
        raise BagError(f"message type {msgtype!r} has no definition: expected package/msg/Type")
    texts, missing = _collect(msgtype, "msg")
    if not missing:
        text = texts.pop(msgtype)
        for name, nested in texts.items():
            text += f"\n{SEPARATOR}MSG: {name.replace('/msg/', '/')}\n{nested}"
        return Definition("ros2msg", text, _digest(msgtype))
    texts, missing_too = _collect(msgtype, "idl")
    if not missing_too:
        parts = (f"{SEPARATOR}IDL: {name}\n{text}" for name, text in texts.items())
        return Definition("ros2idl", "\n".join(parts), _digest(msgtype))
    reason = "" if missing == msgtype else f" (it contains {missing!r}, which is not installed)"
    raise BagError(
        f"message type {msgtype!r} has no definition{reason}: source the package that defines "
        f"{missing!r}"
    )


def _collect(msgtype: str, extension: str) -> tuple[dict[str, str], str]:
    """Return the files of a type and its nested ones by type, and the first that is missing."""
    texts: dict[str, str] = {}
    waiting = [msgtype]
    while waiting:
        name = waiting.pop()
        if name in texts:
            continue
        path = _find(f"{name}.{extension}")
        if path is None:
            return texts, name
        texts[name] = path.read_text(encoding="utf-8", errors="replace")
        waiting += _nested(name, texts[name], extension)
    return texts, ""


def _nested(name: str, text: str, extension: str) -> Iterable[str]:
    """Yield the types that a type's file mentions."""
    if extension == "idl":
        yield from _INCLUDE.findall(text)
        return
    package = name.split("/")[0]
    for each in _FIELD.findall(text):
        if each not in _PRIMITIVES:
            owner, slash, short = each.rpartition("/")
            yield f"{owner.split('/')[0] if slash else package}/msg/{short}"


def _digest(msgtype: str) -> str:
    path = _find(f"{msgtype}.json")
    if path is None:
        return ""
    for each in json.loads(path.read_text(encoding="utf-8"))["type_hashes"]:
        if each["type_name"] == msgtype:
            return str(each["hash_string"])
    return ""


def _find(relative: str) -> Path | None:
    for prefix in filter(None, os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep)):
        path = Path(prefix, "share", relative)
        with contextlib.suppress(OSError):  # a name too long for a file
            if path.is_file():
                return path
    return None
