# SPDX-License-Identifier: Apache-2.0
"""What colcon and pip make of the package, and whether its metadata agree."""

from __future__ import annotations

import ast
import importlib
import inspect
import os
import re
import shutil
import sys
import sysconfig
from collections.abc import Iterator
from email.message import Message
from email.parser import Parser
from pathlib import Path
from typing import NamedTuple

import pytest
from building import PACKAGE, ROOT, colcon, copied, inherited_environment, run, sourced, spaces
from catkin_pkg.changelog import get_changelog_from_path
from catkin_pkg.package import Package, parse_package

from fuzzy_fusion_ros.cli import COMMANDS

pytestmark = pytest.mark.xdist_group("package")


# The names of one dependency: in an import, in rosdep, on PyPI.
DEPENDENCIES = {
    "lz4": ("mcap-ros2-support", "lz4"),  # no key of its own
    "argcomplete": ("python3-argcomplete", "argcomplete"),
    "matplotlib": ("python3-matplotlib", "matplotlib"),
    "mcap": ("mcap-ros2-support", "mcap"),
    "numpy": ("python3-numpy", "numpy"),
    "rosbags": ("python3-rosbags-pip", "rosbags"),
    "scipy": ("python3-scipy", "scipy"),
    "tqdm": ("python3-tqdm", "tqdm"),
    "yaml": ("python3-yaml", "PyYAML"),
    "zstandard": ("mcap-ros2-support", "zstandard"),  # no key of its own
}

OPTIONAL = {"distributed", "numba"}
"""Imported where asked for only, and without a rosdep key: an extra on PyPI brings them."""

COMPILED = {"librt"}
"""Imported by what is compiled only, whose wheel requires it; see test_extensions.py."""


class Install(NamedTuple):
    """An installation away from the sources.

    Attributes:
        prefix: The ament prefix; executables are in its lib/, data in its share/.
        python: The interpreter to import it with.
        environment: The environment variables to use it with.
    """

    prefix: Path
    python: Path
    environment: dict[str, str]


@pytest.fixture(scope="module")
def source(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of what is packaged."""
    return copied(tmp_path_factory.mktemp("source"))


def colcon_build(source: Path, workspace: Path, *options: str) -> Install:
    """Build with colcon and take the environment that its setup.bash makes."""
    colcon("build", workspace, *spaces(source, workspace), *options)
    prefix = workspace / "install" / PACKAGE
    return Install(prefix, Path(sys.executable), sourced(workspace))


def pip_install(source: Path, workspace: Path) -> Install:
    """Make an sdist, of it a wheel, and install that where this environment's libraries are.

    An environment of its own borrows them.
    """
    prefix = workspace / "venv"
    run(sys.executable, "-m", "venv", "--without-pip", prefix, cwd=workspace)
    python = prefix / "bin" / "python"
    site_packages = run(
        python, "-c", "import sysconfig; print(sysconfig.get_path('purelib'))", cwd=workspace
    ).stdout.strip()
    borrowed = {path for path in (*sys.path, sysconfig.get_path("purelib")) if "-packages" in path}
    Path(site_packages, "borrowed.pth").write_text("\n".join(sorted(borrowed)))
    run(sys.executable, "setup.py", "--quiet", "sdist", "--dist-dir", workspace, cwd=source)
    (sdist,) = workspace.glob("*.tar.gz")
    pip = (sys.executable, "-m", "pip", "--quiet")
    run(*pip, "wheel", "--no-deps", "--no-build-isolation", sdist, cwd=workspace)
    (wheel,) = workspace.glob("*.whl")
    run(
        *pip, "--python", python, "install", "--no-deps", "--ignore-installed", wheel, cwd=workspace
    )
    environment = {**inherited_environment(), "AMENT_PREFIX_PATH": str(prefix)}
    environment["PATH"] = f"{prefix / 'bin'}{os.pathsep}{environment['PATH']}"
    return Install(prefix, python, environment)


OTHER_WAY = pytest.mark.slow("another way to install the same")


@pytest.fixture(
    scope="module",
    params=[
        "colcon",
        pytest.param("colcon --symlink-install", marks=OTHER_WAY),
        pytest.param("pip", marks=OTHER_WAY),
    ],
)
def install(
    request: pytest.FixtureRequest, source: Path, tmp_path_factory: pytest.TempPathFactory
) -> Install:
    """Every way to install."""
    workspace = tmp_path_factory.mktemp("workspace")
    tool, *options = request.param.split()
    if tool == "colcon":
        return colcon_build(source, workspace, *options)
    return pip_install(source, workspace)


@pytest.fixture
def elsewhere(tmp_path: Path) -> Path:
    """A working directory without sources in it."""
    return tmp_path


@pytest.fixture(scope="module")
def manifest() -> Package:
    """package.xml, as ROS tools read it."""
    return parse_package(str(ROOT / "package.xml"))


@pytest.fixture(scope="module")
def egg_info(source: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What setup.py says of the package."""
    base = tmp_path_factory.mktemp("egg_info")
    run(sys.executable, "setup.py", "--quiet", "egg_info", "--egg-base", base, cwd=source)
    return base / f"{PACKAGE}.egg-info"


@pytest.fixture(scope="module")
def metadata(egg_info: Path) -> Message:
    """setup.py's metadata as they go into an installation."""
    return Parser().parsestr((egg_info / "PKG-INFO").read_text())


def test_the_ament_index_knows_the_package(install: Install, elsewhere: Path) -> None:
    ask = (
        "from ament_index_python import get_package_prefix, get_package_share_directory as share;"
        f"print(get_package_prefix('{PACKAGE}'), share('{PACKAGE}'))"
    )
    answer = run(install.python, "-c", ask, cwd=elsewhere, environment=install.environment)
    assert answer.stdout.split() == [
        str(install.prefix),
        str(install.prefix / "share" / PACKAGE),
    ]


@pytest.mark.parametrize("executable", COMMANDS)
def test_every_executable_runs_from_where_ros2_run_looks(
    install: Install, executable: str, elsewhere: Path
) -> None:
    path = install.prefix / "lib" / PACKAGE / executable
    assert os.access(path, os.X_OK)
    done = run(path, "--help", cwd=elsewhere, environment=install.environment)
    assert "usage:" in done.stdout
    assert "Traceback" not in done.stderr


def test_nothing_else_lies_where_ros2_run_looks(install: Install) -> None:
    found = sorted(path.name for path in (install.prefix / "lib" / PACKAGE).iterdir())
    assert found == sorted(COMMANDS)


def test_the_installation_does_not_lean_on_the_repository(
    install: Install, source: Path, elsewhere: Path
) -> None:
    ask = f"import pathlib, {PACKAGE}; print(pathlib.Path({PACKAGE}.__file__).resolve().parent)"
    answer = run(install.python, "-c", ask, cwd=elsewhere, environment=install.environment)
    package = Path(answer.stdout.strip())
    assert package == source / PACKAGE or package.is_relative_to(install.prefix)
    assert (package / "py.typed").is_file()


def test_data_files_are_installed_where_they_are_looked_up(install: Install, source: Path) -> None:
    share = install.prefix / "share"
    assert (share / "ament_index" / "resource_index" / "packages" / PACKAGE).is_file()
    data = [source / "package.xml"]
    for folder in ("config", "launch", "bags"):
        data += [path for path in (source / folder).rglob("*") if path.is_file()]
    for path in data:
        installed = share / PACKAGE / path.relative_to(source)
        assert installed.read_bytes() == path.read_bytes()


def test_one_program_is_on_the_path(install: Install, elsewhere: Path) -> None:
    found = shutil.which("fuzzy-fusion", path=install.environment["PATH"])
    assert found == str(install.prefix / "bin" / "fuzzy-fusion")
    done = run(found, "replay", "--help", cwd=elsewhere, environment=install.environment)
    assert done.stdout.startswith("usage: fuzzy-fusion replay")
    names = {path.name for path in (install.prefix / "bin").iterdir()}
    assert {n for n in names if not n.lower().startswith(("activate", "python"))} == {
        "fuzzy-fusion"
    }


@pytest.mark.slow("another build by colcon")
def test_colcon_test_runs_the_tests(source: Path, tmp_path: Path) -> None:
    colcon_build(source, tmp_path)
    one_test = f"test/test_package.py::{test_package_xml_is_valid.__name__}"
    options = ("--return-code-on-test-failure", "--pytest-args", one_test)
    colcon("test", tmp_path, *spaces(source, tmp_path), *options)
    results = colcon("test-result", tmp_path, "--test-result-base", tmp_path / "build")
    assert "Summary: 1 test, 0 errors, 0 failures, 0 skipped" in results


def test_package_xml_is_valid() -> None:
    warnings: list[str] = []
    manifest = parse_package(str(ROOT / "package.xml"), warnings=warnings)
    assert warnings == []
    assert manifest.package_format == 3
    assert manifest.get_build_type() == "ament_python"


def test_setup_py_says_what_package_xml_says(manifest: Package, metadata: Message) -> None:
    (maintainer,) = manifest.maintainers
    (website,) = [each.url for each in manifest.urls if each.type == "website"]
    assert (
        metadata["Name"].replace("-", "_"),  # setuptools before 67 writes it with hyphens
        metadata["Version"],
        metadata["Summary"],
        metadata["License"],
        metadata["Maintainer"],
        metadata["Maintainer-email"],
        metadata["Home-page"],
    ) == (
        manifest.name,
        manifest.version,
        manifest.description,
        " AND ".join(manifest.licenses),
        maintainer.name,
        maintainer.email,
        website,
    )


@pytest.mark.filterwarnings("ignore:nodes.Node.traverse:DeprecationWarning")  # of catkin_pkg
def test_the_changelog_leads_up_to_this_version(manifest: Package) -> None:
    changelog = get_changelog_from_path(str(ROOT), package_name=PACKAGE)
    versions = [str(version) for version, *_ in changelog.foreach_version()]
    released = [version for version in versions if version != "Forthcoming"]
    assert "Forthcoming" not in versions[1:]
    assert released[:1] in ([], [manifest.version])


@pytest.mark.parametrize("executable", COMMANDS)
def test_every_executable_has_a_main_that_returns_its_status(executable: str) -> None:
    main = importlib.import_module(f"{PACKAGE}.cli.{executable}").main
    signature = inspect.signature(main, eval_str=True)
    assert signature.return_annotation is int
    signature.bind()


def imported_packages() -> Iterator[str]:
    """Name the top-level packages that the package imports and Python does not bring."""
    for path in (ROOT / PACKAGE).rglob("*.py"):
        if path.name == "plugin.py":  # only pytest loads it
            continue
        for node in ast.walk(ast.parse(path.read_text(), str(path))):
            if isinstance(node, ast.Import):
                names = [alias.name for alias in node.names]
            elif isinstance(node, ast.ImportFrom) and node.level == 0:
                names = [str(node.module)]
            else:
                continue
            tops = {name.partition(".")[0] for name in names}
            yield from tops - sys.stdlib_module_names - {PACKAGE}


def test_every_import_is_a_declared_dependency(manifest: Package, egg_info: Path) -> None:
    keys = {dependency.name for dependency in manifest.exec_depends}
    projects = set(re.findall(r"^[\w.-]+", (egg_info / "requires.txt").read_text(), re.MULTILINE))
    ros_packages = {key for key in keys if key.isidentifier()}
    undeclared = set()
    for name in imported_packages():
        key, project = DEPENDENCIES.get(name, (name, name))
        if name in OPTIONAL and project in projects:
            continue
        if key not in keys or (key not in ros_packages and project not in projects):
            undeclared.add(name)
    assert undeclared == COMPILED
