# SPDX-License-Identifier: Apache-2.0
"""Files that mean harm end with status 2 and one line, within seconds and a gigabyte."""

from __future__ import annotations

import json
import subprocess
import sys

import pytest

from faults import limited
from faults.hostile import CASES, ESCAPES, Case, made

QUICK = 30.0
"""Seconds of CPU time: on a machine at rest the longest case takes three."""


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> dict[str, tuple[Case, list[object]]]:
    """What became of each case."""
    folder = tmp_path_factory.mktemp("hostile")
    cases = made(folder)
    listed = folder / "cases.json"
    listed.write_text(json.dumps({name: list(each.arguments) for name, each in cases.items()}))
    done = subprocess.run(
        [sys.executable, limited.__file__, str(listed)],
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=600,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, "")
    found = json.loads(done.stdout)
    return {name: (cases[name], found[name]) for name in cases}


@pytest.mark.parametrize("name", CASES)
def test_a_file_that_means_harm_does_none(
    results: dict[str, tuple[Case, list[object]]], name: str
) -> None:
    case, (status, out, err, seconds) = results[name]
    assert isinstance(out, str)
    assert isinstance(err, str)
    assert isinstance(seconds, float)
    assert status == case.status, err
    assert case.says in err
    assert seconds < QUICK
    assert len(err) < 3000
    if status == 2:
        assert out == ""
        assert err.count("\n") == 1
    assert all(each.isprintable() for each in (out + err).splitlines())
    assert not set(ESCAPES) & set(out + err) - set("]0;owned[2J31m")
