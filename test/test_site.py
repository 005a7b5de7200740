# SPDX-License-Identifier: Apache-2.0
"""The documentation as a website: it builds without a warning, and every page can be reached."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import pytest
import yaml

ROOT = Path(__file__).resolve().parents[1]
DOCS = ROOT / "docs"


def build(pages: Path, site: Path) -> None:
    """Build a site; a warning is an error."""
    command = [sys.executable, "-m", "sphinx", "-W", "--keep-going", "-q", "-b", "html"]
    done = subprocess.run([*command, pages, site], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.slow("builds every page")
def test_the_site_builds_without_warnings(tmp_path: Path) -> None:
    build(DOCS, tmp_path)
    for page in DOCS.glob("*.md"):
        assert (tmp_path / f"{page.stem}.html").exists()


@pytest.mark.slow("builds every page")
@pytest.mark.parametrize("place", [".", "standard_docs/original"], ids=["0.2.2", "0.2.1"])
def test_rosdoc2_finds_the_pages_the_pictures_and_the_quality_declaration(
    place: str, tmp_path: Path
) -> None:
    """In a project as rosdoc2 makes it: a copy of the pages, beside its own."""
    manifest = ElementTree.parse(ROOT / "package.xml")
    settings, configuration = yaml.safe_load_all(
        (ROOT / str(manifest.findtext("export/rosdoc2"))).read_text()
    )
    assert settings == {"type": "rosdoc2 config", "version": 1}
    pages, site = tmp_path / "pages", tmp_path / "site"
    shutil.copytree(ROOT / configuration["builders"][0]["sphinx"]["sphinx_sourcedir"], pages)
    (pages / place).mkdir(parents=True, exist_ok=True)
    for path in ("index", "__standards", "__README"):
        (pages / f"{path}.rst").write_text("page\n====\n")
    for name in ("README.md", "CONTRIBUTING.md", "QUALITY_DECLARATION.md", "CHANGELOG.rst"):
        shutil.copy(ROOT / name, pages / place)
    build(pages, site)
    index = (site / "index.html").read_text()
    assert "What do you want to do?" in index
    assert f'href="{Path(place, "QUALITY_DECLARATION.html")}"' in index
    declaration = (site / place / "QUALITY_DECLARATION.html").read_text()
    up = "" if place == "." else "../../"
    assert f'href="{up}tuning.html"' in declaration
    assert f'src="{up}_images/fig18.png"' in (site / place / "README.html").read_text()


def test_every_page_is_in_the_contents() -> None:
    index = (DOCS / "index.md").read_text()
    pages = {page.stem for page in DOCS.glob("*.md")} - {"index"}
    assert pages <= set(index[index.index("```{toctree}") :].split())
