# SPDX-License-Identifier: Apache-2.0
"""Programs in places that lack something: ROS, a home, a directory that can be written."""

from __future__ import annotations

import os
import subprocess
import sys
from importlib.metadata import distributions
from pathlib import Path

import pytest
from building import copied, inherited_environment, run

ROOT = Path(__file__).resolve().parents[1]
NOMINAL = ROOT / "bags" / "nominal"

pytestmark = [
    pytest.mark.xdist_group("package"),
    pytest.mark.slow("another way to install the same"),
]


@pytest.fixture(scope="module")
def prefix(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An environment with the package as pip installs it, its libraries, and nothing of ROS."""
    folder = tmp_path_factory.mktemp("places")
    made = folder / "venv"
    run(sys.executable, "-m", "venv", "--without-pip", made, cwd=folder)
    python = made / "bin" / "python"
    ask = "import sysconfig; print(sysconfig.get_path('purelib'))"
    libraries = Path(run(python, "-c", ask, cwd=folder).stdout.strip())
    for path in borrowed():
        (libraries / path.name).symlink_to(path)
    build = ("--no-deps", "--no-build-isolation", "--no-cache-dir", "--wheel-dir", folder)
    pip = (sys.executable, "-m", "pip", "--quiet")
    run(*pip, "wheel", *build, copied(folder), cwd=folder)
    (wheel,) = folder.glob("*.whl")
    run(*pip, "--python", python, "install", "--no-deps", wheel, cwd=folder)
    return made


def borrowed() -> set[Path]:
    """Return what other packages have installed, apart from ROS and this one."""
    found: set[Path] = set()
    ours: set[Path] = set()
    for distribution in distributions():
        name = distribution.metadata["Name"].lower()
        tops = {file.parts[0] for file in distribution.files or () if file.parts[0] != ".."}
        paths = {Path(str(distribution.locate_file(top))) for top in tops - {"__pycache__"}}
        (ours if name.startswith(("ros-", "fuzzy")) else found).update(paths)
    return found - ours


def environment(**changes: str) -> dict[str, str]:
    """Return the variables of a shell in which no ROS is sourced."""
    own = ("PYTHON", "AMENT", "ROS", "RMW", "COLCON", "XDG", "NUMBA", "LD_LIBRARY")
    kept = {
        name: value for name, value in inherited_environment().items() if not name.startswith(own)
    }
    return {**kept, **changes}


def test_without_ros_all_but_the_nodes_work(prefix: Path, tmp_path: Path) -> None:
    given = ("--params", f"{NOMINAL}.yaml")
    for verb, *arguments in (
        ("replay", NOMINAL, *given, "--output", "new"),
        ("score", "new", *given),
        ("check", "new"),
        ("explain", "new", *given, "--at", "2"),
        ("tune", NOMINAL, "--end", "5", "--output", "tuned.yaml"),
    ):
        run(
            prefix / "bin" / "fuzzy-fusion",
            verb,
            *arguments,
            cwd=tmp_path,
            environment=environment(),
        )
    refused = subprocess.run(
        [prefix / "bin" / "fuzzy-fusion", "fusion_node"],
        env=environment(),
        capture_output=True,
        text=True,
        check=False,
    )
    assert refused.returncode == 2
    assert "needs ROS 2" in refused.stderr
    assert "Traceback" not in refused.stderr


def test_where_neither_installation_nor_home_can_be_written(prefix: Path, tmp_path: Path) -> None:
    home, work = tmp_path / "home", tmp_path / "work"
    home.mkdir()
    work.mkdir()
    locked = [home, prefix, *(each for each in prefix.rglob("*") if not each.is_symlink())]
    modes = {path: path.stat().st_mode for path in locked}
    # Root may write everywhere unless it gives that up.
    obeying = ("setpriv", "--bounding-set=-dac_override") if os.geteuid() == 0 else ()
    try:
        for path in locked:
            path.chmod(modes[path] & ~0o222)
        for verb, *arguments in (
            ("score", NOMINAL, "--params", f"{NOMINAL}.yaml"),
            ("tune", NOMINAL, "--end", "5", "--output", "tuned.yaml"),
            ("reproduce", "--figures", "6", "--seeds", "2", "--output", "figures"),
        ):
            command = (*obeying, prefix / "bin" / "fuzzy-fusion", verb, *arguments)
            run(*command, cwd=work, environment=environment(HOME=str(home)))
        assert list(home.iterdir()) == []
    finally:
        for path, mode in modes.items():
            path.chmod(mode)
