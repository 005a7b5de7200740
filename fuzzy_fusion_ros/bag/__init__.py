# SPDX-License-Identifier: Apache-2.0
"""Bags: reads intact or damaged ones, writes new ones. The only user of rosbags and mcap.

Importing it imports neither: names are imported when they are first used.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from fuzzy_fusion_ros.bag.metadata import offered_qos
    from fuzzy_fusion_ros.bag.reader import BagReader, open_bag
    from fuzzy_fusion_ros.bag.topic import BagMessage, Definition, Topic
    from fuzzy_fusion_ros.bag.typestore import BagTypes, jazzy_types
    from fuzzy_fusion_ros.bag.writer import BagWriter

__all__ = [
    "BagMessage",
    "BagReader",
    "BagTypes",
    "BagWriter",
    "Definition",
    "Topic",
    "jazzy_types",
    "offered_qos",
    "open_bag",
]

_MODULES = {
    "metadata": ("offered_qos",),
    "reader": ("BagReader", "open_bag"),
    "topic": ("BagMessage", "Definition", "Topic"),
    "typestore": ("BagTypes", "jazzy_types"),
    "writer": ("BagWriter",),
}
_HOMES = {name: module for module, names in _MODULES.items() for name in names}


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f"{__name__}.{_HOMES[name]}"), name)
