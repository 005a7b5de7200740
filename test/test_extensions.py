# SPDX-License-Identifier: Apache-2.0
"""The method compiled ahead of time: built where it is asked for, with the same bits as its source.

Tests that compile the whole method are slow, since that takes a minute.
"""

from __future__ import annotations

import os
import sys
import zipfile
from pathlib import Path

import pytest
from building import inherited_environment, run

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = "fuzzy_fusion_ros"

pytestmark = pytest.mark.xdist_group("extensions")

compiles = pytest.mark.slow("compiles the method to C")


def make_wheel(folder: Path, asked: str) -> Path:
    """Make a wheel with the switch set to ``asked``."""
    run(
        *(sys.executable, "setup.py", "--quiet", "egg_info", "--egg-base", folder),
        *("build", "--build-base", folder / "build"),
        *("bdist_wheel", "--bdist-dir", folder / "bdist", "--dist-dir", folder),
        cwd=ROOT,
        environment={**inherited_environment(), "FUZZY_FUSION_COMPILE": asked},
    )
    (wheel,) = folder.glob("*.whl")
    return wheel


@pytest.fixture(scope="module")
def extensions(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An unpacked wheel with the method compiled."""
    folder = tmp_path_factory.mktemp("wheel")
    with zipfile.ZipFile(make_wheel(folder, "1")) as archive:
        archive.extractall(folder / "unpacked")
    return folder / "unpacked"


def say(folder: Path, *command: str | Path) -> str:
    """Run Python with the package in ``folder`` and return what it prints."""
    path = os.pathsep.join([str(folder), str(ROOT / "test")])
    environment = {**inherited_environment(), "PYTHONPATH": path}
    return run(sys.executable, *command, cwd=folder, environment=environment).stdout


@compiles
def test_the_whole_method_is_compiled_and_its_source_is_beside_it(extensions: Path) -> None:
    core = extensions / PACKAGE / "core"
    sources = {path.stem for path in core.glob("[a-z]*.py")}
    assert {path.name.partition(".")[0] for path in core.glob("*.so")} == sources
    place = f"from {PACKAGE}.core import estimator; print(estimator.__file__)"
    assert say(extensions, "-c", place).startswith(str(core))


@compiles
def test_what_compiled_code_imports_is_required(extensions: Path) -> None:
    (metadata,) = extensions.glob("*.dist-info/METADATA")
    assert "Requires-Dist: librt" in metadata.read_text()


@compiles
def test_compiled_it_says_the_same_to_the_last_bit(extensions: Path) -> None:
    walks = ROOT / "test" / "core" / "random_walks.py"
    compiled = say(extensions, walks).splitlines()
    assert compiled == say(ROOT, walks).splitlines()
    assert len(compiled) > 2000
    assert sum(line.startswith("ZeroDivisionError") for line in compiled) > 0


TWINS = """
from fuzzy_fusion_ros.batch.compiled import compiled
from fuzzy_fusion_ros.core.aggregator import aggregate
from fuzzy_fusion_ros.parameters.fusion import AggregatorParameters
from fuzzy_fusion_ros.parameters.group import numbers

fast, taken = compiled(aggregate), numbers(AggregatorParameters())
print(hasattr(fast, "py_func"), hasattr(aggregate, "__code__"))
for k in range(100):
    samples = (0.01 * k, 0.5, 0.03 * k - 1.0)
    assert fast(taken, *samples) == aggregate(taken, *samples)
    assert type(fast(taken, *samples)) is type(aggregate(taken, *samples))
"""


@compiles
def test_numba_compiles_from_the_sources(extensions: Path) -> None:
    assert say(extensions, "-c", TWINS) == "True False\n"


LEARNING = """
from math import sin
from fuzzy_fusion_ros.batch.compiled import compiled, given_back, taken_by
from fuzzy_fusion_ros.core.predictor import learn, untrained
from fuzzy_fusion_ros.parameters.fusion import PredictorParameters
from fuzzy_fusion_ros.parameters.group import numbers, replace

taken = numbers(replace(PredictorParameters(), {"enabled": True, "samples": 5, "rules": 3}))
fast = compiled(learn)
state = untrained(taken.samples, taken.rules)
print(type(state.history).__name__)
for k in range(30):
    before = repr(state)
    new = learn(taken, state, k * 10_000_000, sin(0.1 * k))
    assert repr(state) == before
    found = given_back(fast(taken, taken_by(fast, state), k * 10_000_000, sin(0.1 * k)), state)
    assert found == new
    assert repr(found.rules) == repr(new.rules)
    state = new
assert state.ready
"""


@compiles
def test_compiled_it_learns_from_vectors_and_numba_from_arrays(extensions: Path) -> None:
    assert say(extensions, "-c", LEARNING) == "vec[float]\n"


def test_interpreted_it_learns_from_lists_and_numba_from_arrays() -> None:
    assert say(ROOT, "-c", LEARNING) == "list\n"


LOOP = """
import numpy as np
from fuzzy_fusion_ros.batch.compiled import interpreted
from fuzzy_fusion_ros.batch.series import fusion
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import replace
from fuzzy_fusion_ros.simulation.closed_loop import simulate
from fuzzy_fusion_ros.simulation.scenario import Scenario

scenario = replace(Scenario(), {"duration": 2.0})
run = simulate(fusion(Parameters()), scenario, np.random.default_rng(0), bind=interpreted)
print(run.survived, run.truth.tolist())
"""


@compiles
def test_a_loop_over_arrays_takes_it(extensions: Path) -> None:
    assert say(extensions, "-c", LOOP) == say(ROOT, "-c", LOOP)


def test_a_build_without_it_does_not_leave_an_earlier_one_in_place(tmp_path: Path) -> None:
    """An extension that was left behind would hide the sources that come with the new build."""
    stale = tmp_path / "lib" / PACKAGE / "core" / "estimator.cpython-311-x86_64-linux-gnu.so"
    stale.parent.mkdir(parents=True)
    stale.touch()
    run(
        *(sys.executable, "setup.py", "--quiet", "build", "--build-base", tmp_path / "build"),
        *("install_lib", "--install-dir", tmp_path / "lib"),
        cwd=ROOT,
        environment={**inherited_environment(), "FUZZY_FUSION_COMPILE": ""},
    )
    assert stale.with_name("estimator.py").exists()
    assert not stale.exists()


def test_without_being_asked_a_wheel_is_pure(tmp_path: Path) -> None:
    wheel = make_wheel(tmp_path, "")
    assert wheel.name.endswith("-py3-none-any.whl")
    assert not [name for name in zipfile.ZipFile(wheel).namelist() if name.endswith(".so")]


def test_where_sources_are_edited_nothing_is_compiled(tmp_path: Path) -> None:
    """An extension beside a source would hide each change of it."""
    environment = {**inherited_environment(), "FUZZY_FUSION_COMPILE": "1"}
    command = (sys.executable, "setup.py", "--quiet", "editable_wheel", "--dist-dir", tmp_path)
    run(*command, cwd=ROOT, environment=environment)
    assert not list((ROOT / PACKAGE).rglob("*.so"))
