"""Definitions of message types from the installed ``.msg`` files."""

from __future__ import annotations

import json
import os
import re
from pathlib import Path

from fuzzy_fusion_ros.bag.topic import Definition
from fuzzy_fusion_ros.parameters.errors import BagError

_SEPARATOR = "=" * 80
_FIELD = re.compile(
    r"^\s*([A-Za-z]\w*(?:/\w+)*)(?:<=\d+)?(?:\[[^\]]*\])?\s+[A-Za-z]\w*", re.MULTILINE
)
_PRIMITIVES = frozenset(
    ["bool", "byte", "char", "float32", "float64", "string", "wstring"]
    + [f"{sign}int{bits}" for sign in ("", "u") for bits in (8, 16, 32, 64)]
)


def installed_definition(msgtype: str) -> Definition:
    """Return the definition of an installed type with those of its nested types behind it.

    Args:
        msgtype: ``package/msg/Type``; looked up below AMENT_PREFIX_PATH.

    Raises:
        BagError: The type or a nested one is not installed.
    """
    texts: dict[str, str] = {}
    _collect(msgtype, msgtype, texts)
    text = texts.pop(msgtype)
    for name, nested in texts.items():
        text += f"\n{_SEPARATOR}\nMSG: {name.replace('/msg/', '/')}\n{nested}"
    return Definition("ros2msg", text, _digest(msgtype))


def _collect(name: str, outermost: str, texts: dict[str, str]) -> None:
    path = _find(f"{name}.msg")
    if path is None:
        reason = "" if name == outermost else f" (it contains {name!r}, which is not installed)"
        raise BagError(
            f"message type {outermost!r} has no definition{reason}: give the one of the bag that "
            "it comes from, or install its package and source the workspace"
        )
    texts[name] = path.read_text(encoding="utf-8")
    package = name.split("/")[0]
    for nested in _FIELD.findall(texts[name]):
        full = _full_name(nested, package)
        if full and full not in texts:
            _collect(full, outermost, texts)


def _full_name(nested: str, package: str) -> str:
    """Return the full name of a field's type, or nothing if it is primitive."""
    if nested in _PRIMITIVES:
        return ""
    parts = nested.split("/")
    return f"{parts[0] if len(parts) > 1 else package}/msg/{parts[-1]}"


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
        if path.is_file():
            return path
    return None
