# SPDX-License-Identifier: Apache-2.0
"""Who may import whom, and that importing does nothing: the arrows of the code base."""

from __future__ import annotations

import ast
import functools
import graphlib
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

PACKAGE = "fuzzy_fusion_ros"
ROOT = Path(__file__).resolve().parents[1]
SOURCES = sorted((ROOT / PACKAGE).rglob("*.py"))

# A room is a folder right below the package; it may import itself and these, all above it here.
MAY_IMPORT = {
    "text": set[str](),
    "parameters": {"text"},
    "core": {"parameters"},
    "self_tuning": {"parameters", "core"},
    "online": {"parameters", "core", "self_tuning"},
    "batch": {"parameters", "core", "self_tuning"},
    "simulation": {"parameters", "core", "batch"},
    "baselines": {"parameters", "core", "batch"},
    "tuning": {"text", "parameters", "core", "self_tuning", "batch", "baselines"},
    "paper": {"text", "parameters", "core", "batch", "simulation", "baselines"},
    "messages": {"parameters", "core", "online"},
    "checking": {"text", "parameters", "core", "online", "batch", "messages"},
    "bag": {"parameters", "core", "messages"},
    "offline": {"parameters", "core", "online", "batch", "messages", "checking", "bag"},
    "scoring": {
        "text",
        "parameters",
        "core",
        "online",
        "batch",
        "baselines",
        "messages",
        "checking",
        "bag",
        "offline",
    },
    "plots": {
        "text",
        "parameters",
        "core",
        "batch",
        "simulation",
        "baselines",
        "tuning",
        "paper",
        "messages",
        "bag",
        "offline",
        "scoring",
    },
    "reports": {
        "text",
        "parameters",
        "core",
        "online",
        "batch",
        "baselines",
        "tuning",
        "messages",
        "offline",
        "scoring",
        "plots",
    },
    "ros": {"parameters", "core", "online", "messages", "bag"},
    "nodes": {
        "parameters",
        "core",
        "self_tuning",
        "online",
        "messages",
        "checking",
        "bag",
        "simulation",
        "ros",
    },
    "testing": {"parameters", "core", "online", "messages", "simulation", "bag", "ros", "nodes"},
    "jobs": {
        "text",
        "parameters",
        "core",
        "online",
        "batch",
        "simulation",
        "baselines",
        "tuning",
        "paper",
        "messages",
        "checking",
        "bag",
        "offline",
        "scoring",
        "plots",
        "reports",
        "ros",
        "nodes",
        "testing",
    },
    "cli": {
        "text",
        "parameters",
        "core",
        "online",
        "batch",
        "simulation",
        "baselines",
        "tuning",
        "paper",
        "messages",
        "checking",
        "bag",
        "offline",
        "scoring",
        "plots",
        "reports",
        "ros",
        "nodes",
        "testing",
        "jobs",
    },
}

# The only places that may import a library: a room, or one file.
ONLY_IN = {
    "rclpy": ("ros", "nodes", "testing"),
    "rosbags": ("bag",),
    "mcap": ("bag",),
    "matplotlib": ("plots",),
    "numba": ("batch/compiled.py",),
    "distributed": ("jobs/fleet.py",),
}

# Costs start-up time, or is not there on every machine that uses the method alone.
NOT_FOR_THE_METHOD = {"numba", "scipy", "rclpy", "matplotlib", "rosbags", "mcap", "yaml", "tqdm"}


def place(path: Path) -> str:
    """Name a source file as seen from the package."""
    return path.relative_to(ROOT / PACKAGE).as_posix()


def module_name(path: Path) -> str:
    """Name the module in a source file."""
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def room_of(module: str) -> str:
    """Name the room of a module of the package, empty for the package itself."""
    return module.split(".")[1] if "." in module else ""


def imports(source: str) -> Iterator[str]:
    """Name what a source imports, wherever in it, as dotted as it can be told."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"line {node.lineno}: relative import, write it in full"
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


@functools.cache
def all_imports() -> list[tuple[Path, str]]:
    """Pair every source file with everything that it imports."""
    return [(path, name) for path in SOURCES for name in imports(path.read_text(encoding="utf-8"))]


def test_imports_are_found_wherever_they_stand() -> None:
    source = """
import a, b.c as d
from e.f import g as h, i
if TYPE_CHECKING:
    import j
def late():
    from k import l
"""
    assert sorted(imports(source)) == ["a", "b.c", "e.f.g", "e.f.i", "j", "k.l"]


def test_every_room_is_on_the_plan() -> None:
    rooms = {room_of(module_name(path)) for path in SOURCES}
    assert rooms - {""} <= set(MAY_IMPORT)


def test_the_plan_has_no_cycle() -> None:
    order = list(MAY_IMPORT)
    for room, others in MAY_IMPORT.items():
        assert others <= set(order[: order.index(room)])


def test_rooms_import_only_along_the_arrows() -> None:
    wrong = []
    for path, name in all_imports():
        if name.partition(".")[0] != PACKAGE:
            continue
        here, there = room_of(module_name(path)), room_of(name)
        if here and here != there and there not in MAY_IMPORT.get(here, set()):  # "" is the door
            wrong.append(f"{place(path)} imports {name}")
    assert wrong == []


def test_modules_do_not_import_in_a_circle() -> None:
    names = {module_name(path) for path in SOURCES}
    needs: dict[str, set[str]] = {name: set() for name in names}
    for path, name in all_imports():
        whole = name if name in names else name.rpartition(".")[0]
        needs[module_name(path)] |= {whole} & names - {module_name(path)}
    sorter = graphlib.TopologicalSorter(needs)
    sorter.prepare()


def test_nodes_record_bags_but_read_none() -> None:
    wrong = [
        f"{place(path)} imports {name}"
        for path, name in all_imports()
        if room_of(module_name(path)) == "nodes"
        and room_of(name) == "bag"
        and ("reader" in name.lower() or name.endswith("open_bag"))
    ]
    assert wrong == []


@pytest.mark.parametrize("library", ONLY_IN)
def test_a_library_is_imported_in_its_place_only(library: str) -> None:
    wrong = [
        place(path)
        for path, name in all_imports()
        if name.partition(".")[0] == library
        and not place(path).startswith(tuple(where.rstrip("/") for where in ONLY_IN[library]))
    ]
    assert wrong == []


def test_the_package_imports_no_test() -> None:
    tests = {path.stem for path in (ROOT / "test").rglob("*.py")} | {"test", "reference"}
    unwanted = tests | {"pytest", "hypothesis"}
    wrong = [f"{place(path)}: {name}" for path, name in all_imports() if name in unwanted]
    wrong += [
        f"{place(path)}: {name}"
        for path, name in all_imports()
        if name.partition(".")[0] in {"test", "reference", "pytest", "hypothesis"}
    ]
    # Only pytest loads the plugin.
    assert set(wrong) == {"testing/plugin.py: pytest"}


def python(program: str) -> str:
    """Run a program in a fresh interpreter; it must succeed and say nothing on stderr."""
    done = subprocess.run(
        [sys.executable, "-c", program],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, ""), done.stderr
    return done.stdout


@pytest.mark.parametrize("room", ["core", "online", "simulation"])
def test_the_method_costs_no_heavy_import(room: str) -> None:
    modules = [module_name(path) for path in SOURCES if room_of(module_name(path)) == room]
    loaded = python(
        f"""
import importlib, sys
for name in {modules!r}:
    importlib.import_module(name)
print(*sys.modules)
"""
    )
    assert set(loaded.split()) & NOT_FOR_THE_METHOD == set()


def test_a_node_that_records_nothing_loads_no_bag_library() -> None:
    loaded = python(
        """
import sys
import fuzzy_fusion_ros.bag
import fuzzy_fusion_ros.nodes.fusion_node
import fuzzy_fusion_ros.nodes.pendulum_node
import fuzzy_fusion_ros.nodes.sensor_subscriber
print(*{name.partition(".")[0] for name in sys.modules})
"""
    )
    assert "rclpy" in loaded.split()
    assert set(loaded.split()) & {"rosbags", "mcap", "zstandard", "lz4"} == set()


def test_importing_has_no_effects() -> None:
    """Every module is imported in one process, after the libraries that it stands on."""
    libraries = sorted(
        {
            name.rpartition(".")[0] or name
            for _, name in all_imports()
            if name.partition(".")[0] not in {PACKAGE, "numba", "__future__"}
        }
    )
    said = python(
        f"""
import importlib, logging, os, random, signal, sys, threading, warnings
import numpy as np

for name in {libraries!r}:
    importlib.import_module(name)
import matplotlib.pyplot

def world():
    return {{
        "arguments": list(sys.argv),
        "directory": os.getcwd(),
        "environment": dict(os.environ),
        "figures": matplotlib.pyplot.get_fignums(),
        "floating-point errors": np.geterr(),
        "handlers": [repr(h) for h in logging.getLogger().handlers],
        "numpy's random state": repr(np.random.get_state()),
        "plot settings": dict(matplotlib.rcParams),
        "random state": random.getstate(),
        "signals": [signal.getsignal(s) for s in (signal.SIGINT, signal.SIGTERM)],
        "threads": threading.active_count(),
        "warnings": list(warnings.filters),
    }}

before = world()
for name in {[module_name(path) for path in SOURCES]!r}:
    importlib.import_module(name)
after = world()
print(*(what for what in before if before[what] != after[what]))
"""
    )
    assert said == "\n"
