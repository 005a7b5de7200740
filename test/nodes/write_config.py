# SPDX-License-Identifier: Apache-2.0
"""Rewrites config/fusion_node.yaml after a change of the defaults."""

from __future__ import annotations

from pathlib import Path

from fuzzy_fusion_ros.parameters.file import dump
from fuzzy_fusion_ros.parameters.fusion import Parameters

PATH = Path(__file__).parents[2] / "config" / "fusion_node.yaml"
COMMENTS = (
    "SPDX-License-Identifier: Apache-2.0",
    "All parameters of fusion_node, at their defaults.",
    "fuzzy-fusion fusion_node --params config/fusion_node.yaml",
)

if __name__ == "__main__":
    dump(Parameters(), PATH, COMMENTS)
