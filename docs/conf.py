# SPDX-License-Identifier: Apache-2.0
"""How Sphinx builds these pages: ``make site``, or rosdoc2.

rosdoc2 makes a project of its own: a copy of this folder, with README and its likes beside the
pages, up to version 0.2.1 below ``standard_docs/original/``.
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
# Of what rosdoc2 adds: its start page, pages that only include others, and a second changelog.
exclude_patterns = ["__pycache__", "index.rst", "standards.rst", "__*.rst", "standard_docs/*.rst"]
exclude_patterns += ["CHANGELOG.rst", "standard_docs/original/CHANGELOG.rst"]
myst_heading_anchors = 4
html_theme = "furo"
html_title = project
html_static_path = ["_static"]
html_css_files = ["pages.css"]


STANDARD_DOCUMENTS = ("README", "CONTRIBUTING", "QUALITY_DECLARATION")


def adapt(app, docname, source):
    """Add what rosdoc2 added to the contents, and point its links to where it has the pages."""
    page, root = Path(docname), Path(app.srcdir)
    folder = root / page.parent

    def link(found):
        text, target = found.groups()
        path = target.partition("#")[0]
        return f"[{text}]({target})" if ":" in path or (folder / path).exists() else text

    if page.name in STANDARD_DOCUMENTS:
        top = "../" * len(page.parts[:-1])
        text = source[0].replace("](docs/", f"]({top}")
        text = text.replace("](CHANGELOG", f"]({top}changes")
        source[0] = re.sub(r"(?<!!)\[([^]\[]+)\]\(([^)\s]+)\)", link, text)
    elif docname == "index":
        added = sorted(root.rglob("*.md"))
        names = [str(path.relative_to(root)) for path in added if path.stem in STANDARD_DOCUMENTS]
        source[0] += "\n".join(["", "```{toctree}", ":hidden:", *names, "```", ""])


def setup(app):
    """Have Sphinx adapt the sources it reads."""
    app.connect("source-read", adapt)
