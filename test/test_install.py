# SPDX-License-Identifier: Apache-2.0
"""install.sh: a workspace on a system whose Python belongs to its package manager."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path
from typing import NamedTuple

import pytest
from building import inherited_environment, run, sourced

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = "fuzzy_fusion_ros"
FOR_PIP = ("mcap-ros2-support", "python3-rosbags-pip")

pytestmark = [
    pytest.mark.xdist_group("package"),
    pytest.mark.slow("another way to install the same"),
]


class System(NamedTuple):
    """A computer with ROS, as far as a script can tell.

    Attributes:
        python: Its Python.
        environment: The environment variables of a shell on it.
    """

    python: Path
    environment: dict[str, str]


@pytest.fixture
def system(tmp_path: Path) -> System:
    """An externally managed Python, with ROS, colcon and the real rosdep, which simulates."""
    prefix = tmp_path / "usr"
    base = Path(sysconfig.get_path("stdlib"))
    library = prefix / "lib" / base.name
    library.mkdir(parents=True)
    for path in base.iterdir():
        if path.name not in ("site-packages", "dist-packages"):
            (library / path.name).symlink_to(path)
    (library / "EXTERNALLY-MANAGED").write_text("[externally-managed]\nError=it is apt's\n")
    (library / "site-packages").mkdir()
    borrowed = {path for path in (*sys.path, sysconfig.get_path("purelib")) if "-packages" in path}
    (library / "site-packages" / "borrowed.pth").write_text("\n".join(sorted(borrowed)))
    programs = prefix / "bin"
    programs.mkdir()
    python = programs / "python3"
    shutil.copy2(os.path.realpath(sys.executable), python)
    scripts = {
        "rosdep": "import sys; from rosdep2.main import rosdep_main as main; sys.argv[2:2] = "
        "['--simulate', '--os=ubuntu:noble']; sys.exit(main())",
        "colcon": "import sys; from colcon_core.command import main; sys.exit(main())",
    }
    for name, text in scripts.items():
        (programs / name).write_text(f"#!{python}\n{text}\n")
        (programs / name).chmod(0o755)
    environment = inherited_environment()
    path = [each for each in environment["PATH"].split(os.pathsep) if sys.prefix not in each]
    environment |= {"PATH": os.pathsep.join([str(programs), *path]), "ROS_DISTRO": "jazzy"}
    return System(python, environment | rosdep_rules(tmp_path / "rosdep", python, environment))


def rosdep_rules(folder: Path, python: Path, environment: dict[str, str]) -> dict[str, str]:
    """Write rules for our keys, as rosdistro has them; return the variables that point there."""
    sources = folder / "sources"
    sources.mkdir(parents=True)
    keys = re.findall(r"_depend[^>]*>([\w-]+)<", (ROOT / "package.xml").read_text())
    rules = "".join(
        f"{key}: {{ubuntu: {{pip: {{packages: [{key}]}}}}}}\n"
        if key in FOR_PIP
        else f"{key}: {{ubuntu: [{key}]}}\n"
        for key in keys
    )
    (folder / "rules.yaml").write_text(rules)
    (sources / "10-rules.list").write_text(f"yaml file://{folder / 'rules.yaml'}\n")
    (folder / "index.yaml").write_text(
        "%YAML 1.1\n---\ndistributions: {}\ntype: index\nversion: 4\n"
    )
    variables = {
        "ROSDEP_SOURCE_PATH": str(sources),
        "ROS_HOME": str(folder / "home"),
        "ROSDISTRO_INDEX_URL": f"file://{folder / 'index.yaml'}",
        "ROS_PYTHON_VERSION": "3",
    }
    update = "from rosdep2.main import rosdep_main as main; main(['update'])"
    run(python, "-c", update, cwd=folder, environment=environment | variables)
    return variables


@pytest.fixture
def workspace(tmp_path: Path) -> Path:
    """A workspace with the package in it."""
    source = tmp_path / "ws" / "src" / PACKAGE
    source.mkdir(parents=True)
    for name in ("package.xml", "setup.py", "setup.cfg", "install.sh"):
        shutil.copy2(ROOT / name, source)
    for name in (PACKAGE, "resource", "config", "launch"):
        shutil.copytree(ROOT / name, source / name, ignore=shutil.ignore_patterns("__pycache__"))
    return tmp_path / "ws"


def test_it_works_where_pip_may_not_touch_the_system(system: System, workspace: Path) -> None:
    refused = subprocess.run(
        [system.python, "-m", "pip", "install", "mcap"],
        env=system.environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert "externally-managed-environment" in refused.stderr
    script = workspace / "src" / PACKAGE / "install.sh"
    said = run(script, cwd=workspace, environment=system.environment).stdout
    assert "pip3 install" not in said
    assert (workspace / "venv" / "COLCON_IGNORE").exists()
    program = workspace / "install" / PACKAGE / "bin" / "fuzzy-fusion"
    assert program.read_text().startswith(f"#!{workspace / 'venv' / 'bin' / 'python'}")
    found = run("fuzzy-fusion", "score", "--help", cwd=workspace, environment=sourced(workspace))
    assert found.stdout.startswith("usage: fuzzy-fusion score")


def test_rosdep_asks_pip_only_where_it_may(system: System, workspace: Path) -> None:
    install = ("rosdep", "install", "--from-paths", "src", "--ignore-src", "-y")
    allowed = system.environment | {"PIP_BREAK_SYSTEM_PACKAGES": "1"}
    shell = ("sh", "-c", " ".join(install))
    assert "pip3 install" not in run(*shell, cwd=workspace, environment=system.environment).stdout
    said = run(*shell, cwd=workspace, environment=allowed).stdout
    assert all(re.search(f"pip3? install.* {key}", said) for key in FOR_PIP)


PIN = r'"((?:mcap|mypy|rosbags)[=>][^"]+)"'


def test_its_pins_are_those_of_the_package() -> None:
    pinned = set(re.findall(PIN, (ROOT / "install.sh").read_text()))
    assert pinned == set(re.findall(PIN, (ROOT / "setup.py").read_text()))
