# SPDX-License-Identifier: Apache-2.0
"""The fixtures of the pytest plugin, in a repository that a user would copy."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

from fuzzy_fusion_ros.testing import Harness
from fuzzy_fusion_ros.testing.domain import DOMAINS, claimed_domain

ROBOT = Path(__file__).parents[2] / "examples" / "robot"


def pytest_in(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", *arguments]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)


def test_the_example_is_copied_and_run(tmp_path: Path) -> None:
    shutil.copytree(ROBOT, tmp_path / "robot", ignore=shutil.ignore_patterns("__pycache__"))
    done = pytest_in(tmp_path / "robot")
    assert (done.returncode, "1 passed" in done.stdout) == (0, True), done.stdout
    assert len((ROBOT / "test_fusion.py").read_text().split("\n\n\n")[1].splitlines()) <= 10


def test_a_wrong_parameter_fails_the_example(tmp_path: Path) -> None:
    shutil.copytree(ROBOT, tmp_path / "robot", ignore=shutil.ignore_patterns("__pycache__"))
    file = tmp_path / "robot" / "tuned.yaml"
    file.write_text(file.read_text().replace("large", "largest"))
    done = pytest_in(tmp_path / "robot")
    assert done.returncode == 1
    assert "did you mean" in done.stdout


def test_a_test_that_asks_for_nothing_loads_no_rclpy(tmp_path: Path) -> None:
    (tmp_path / "test_it.py").write_text(
        "import sys\ndef test_it(): assert not {'rclpy', 'numpy'} & {*sys.modules}\n"
    )
    done = pytest_in(tmp_path)
    assert done.returncode == 0, done.stdout


def test_pytest_starts_where_python_lacks_what_only_unix_has(tmp_path: Path) -> None:
    (tmp_path / "test_it.py").write_text("def test_it(): pass\n")
    windows = "import sys; sys.modules['fcntl'] = None; import pytest; sys.exit(pytest.main())"
    command = [sys.executable, "-c", windows]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_a_domain_is_free_and_ours(ros_domain: int) -> None:
    assert ros_domain in DOMAINS
    assert os.environ["ROS_DOMAIN_ID"] == str(ros_domain)
    assert os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] == "LOCALHOST"
    with claimed_domain() as other:
        assert other != ros_domain


def test_the_harness_is_in_the_domain(ros_domain: int, fusion_harness: Harness) -> None:
    assert fusion_harness.domain_id == ros_domain
