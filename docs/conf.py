# SPDX-License-Identifier: Apache-2.0
"""How Sphinx builds these pages: ``make site``, or rosdoc2."""

import re
from pathlib import Path

project = "fuzzy_fusion_ros"
author = "fuzzy_fusion_ros developers"
copyright = author  # noqa: A001  # its name in Sphinx
_manifest = (Path(__file__).parents[1] / "package.xml").read_text(encoding="utf-8")
version = release = re.findall("<version>(.*)</version>", _manifest)[0]

extensions = ["myst_parser"]
myst_enable_extensions = ["dollarmath"]
source_suffix = {".md": "markdown", ".rst": "restructuredtext"}
exclude_patterns = ["__pycache__"]
myst_heading_anchors = 4
html_theme = "furo"
html_title = project
