# SPDX-License-Identifier: Apache-2.0
"""How Sphinx builds these pages: ``make site``, or rosdoc2.

rosdoc2 makes a project of its own: this folder copied to the top of it, README and its likes below
``standard_docs/``.
"""

import re
from pathlib import Path

project = "fuzzy_fusion_ros"
author = "fuzzy_fusion_ros developers"
copyright = author  # noqa: A001  # its name in Sphinx
version = release = "0.2.0"

extensions = ["myst_parser"]
myst_enable_extensions = ["dollarmath"]
source_suffix = {".md": "markdown", ".rst": "restructuredtext"}
# Of what rosdoc2 adds: its start page, and pages that only include the standard documents.
exclude_patterns = ["__pycache__", "index.rst", "__readme_include.rst", "standards.rst"]
exclude_patterns += ["standard_docs/*.rst", "standard_docs/original/CHANGELOG.rst"]
myst_heading_anchors = 4
html_theme = "furo"
html_title = project
html_static_path = ["_static"]
html_css_files = ["pages.css"]


STANDARD_DOCUMENTS = """
```{toctree}
:hidden:
:glob:
standard_docs/original/*
```
"""


def adapt(app, docname, source):
    """Add what rosdoc2 added to the contents, and point its links to where it has the pages."""
    folder = app.srcdir / Path(docname).parent

    def link(found):
        text, target = found.groups()
        path = target.partition("#")[0]
        return f"[{text}]({target})" if ":" in path or (folder / path).exists() else text

    if folder != app.srcdir:
        text = source[0].replace("](docs/", "](../../").replace("](CHANGELOG", "](../../changes")
        source[0] = re.sub(r"(?<!!)\[([^]\[]+)\]\(([^)\s]+)\)", link, text)
    elif docname == "index" and (folder / "standard_docs").exists():
        source[0] += STANDARD_DOCUMENTS


def setup(app):
    """Have Sphinx adapt the sources it reads."""
    app.connect("source-read", adapt)
