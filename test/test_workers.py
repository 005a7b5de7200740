# SPDX-License-Identifier: Apache-2.0
"""How tests are spread over workers."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

TESTS = Path(__file__).parent

MODULE = """
from pathlib import Path
import pytest

@pytest.fixture(scope="module")
def costly():
    with Path({made!r}).open("a") as file:
        file.write("made\\n")

@pytest.mark.parametrize("k", range(12))
def test_it(costly, k):
    pass
"""


def test_what_the_tests_of_a_module_share_is_made_once(tmp_path: Path) -> None:
    made = tmp_path / "made.txt"
    folder = tmp_path / "test"
    folder.mkdir()
    shutil.copy(TESTS / "conftest.py", folder)
    (folder / "test_module.py").write_text(MODULE.format(made=str(made)), encoding="utf-8")
    workers = ("-n", "2", "--dist", "loadgroup", "-p", "no:cacheprovider", "-q")
    done = subprocess.run(
        [sys.executable, "-m", "pytest", *workers, "--rootdir", tmp_path, folder],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(TESTS)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert "12 passed" in done.stdout, done.stdout + done.stderr
    assert made.read_text(encoding="utf-8") == "made\n"
