# SPDX-License-Identifier: Apache-2.0
"""Message type names, and the classes that they name."""

from __future__ import annotations

import difflib
import importlib
import os
import re
from pathlib import Path
from typing import Any

from fuzzy_fusion_ros.parameters.errors import MessageError

_NAME = re.compile(r"([a-z]\w*)/(?:msg/)?([A-Z]\w*)")


def normalise_type_name(text: str) -> str:
    """Return a message type name in its full form ``package/msg/Type``.

    Args:
        text: ``package/msg/Type``, or the short form ``package/Type``.

    Raises:
        MessageError: The text is neither.
    """
    match = _NAME.fullmatch(text.strip())
    if match is None:
        raise MessageError(
            f"message type {text!r} is malformed: give package/msg/Type, "
            "for example 'geometry_msgs/msg/PointStamped'"
        )
    return f"{match[1]}/msg/{match[2]}"


def load_message_class(type_name: str) -> Any:
    """Return the installed rclpy class of a message type.

    Args:
        type_name: As :func:`normalise_type_name` takes it.

    Raises:
        MessageError: The name is malformed or no such type is installed; the error lists
            installed types with similar names.
    """
    name = normalise_type_name(type_name)
    package, _, short = name.split("/")
    try:
        found = getattr(importlib.import_module(f"{package}.msg"), short, None)
    except ImportError as error:
        if not _is_absence(error, package):
            raise MessageError(
                f"message package {package!r} cannot be imported: {error}"
            ) from error
        found = None
    if not hasattr(found, "get_fields_and_field_types"):
        raise MessageError(_not_installed(name))
    return found


def installed_type_names() -> list[str]:
    """Return the sorted names of all message types in the ament index; empty without one."""
    prefixes = os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep)
    names: set[str] = set()
    for prefix in filter(None, prefixes):
        index = Path(prefix, "share/ament_index/resource_index/rosidl_interfaces")
        for marker in index.glob("*"):
            lines = marker.read_text(encoding="utf-8", errors="replace").splitlines()
            names.update(
                f"{marker.name}/{line[:-4]}"
                for line in lines
                if line.startswith("msg/") and line.endswith(".msg")
            )
    return sorted(names)


def _is_absence(error: ImportError, package: str) -> bool:
    return isinstance(error, ModuleNotFoundError) and error.name in {package, f"{package}.msg"}


def _not_installed(name: str) -> str:
    package, _, short = name.split("/")
    by_short: dict[str, list[str]] = {}
    for each in installed_type_names():
        by_short.setdefault(each.rsplit("/", 1)[1], []).append(each)
    close = difflib.get_close_matches(short, by_short, n=5, cutoff=0.7)
    similar = [each for match in close for each in by_short[match]]
    similar.sort(key=lambda each: not each.startswith(f"{package}/"))  # stable: own package first
    hint = ", ".join(similar[:5])
    advice = f"did you mean {hint}?" if hint else "install its package and source the workspace"
    return f"message type {name!r} is not installed: {advice}"
