# SPDX-License-Identifier: Apache-2.0
"""The compiler: with numba and without."""

from __future__ import annotations

import functools
import importlib.util
import os
import shutil
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

import numba
import pytest

from fuzzy_fusion_ros.batch import compiled as module
from fuzzy_fusion_ros.batch.compiled import compiled
from fuzzy_fusion_ros.core.aggregator import aggregate, blend, sign
from fuzzy_fusion_ros.core.gate import NO_PREDICTION, combine
from fuzzy_fusion_ros.core.numerics import lag_gain
from fuzzy_fusion_ros.parameters.fusion import AggregatorParameters
from fuzzy_fusion_ros.parameters.group import numbers


@pytest.fixture
def fresh(monkeypatch: pytest.MonkeyPatch) -> None:
    """Forget what was compiled, for the time of a test."""
    for name in ("_twin", "_jit"):
        plain = getattr(module, name).__wrapped__
        monkeypatch.setattr(module, name, functools.cache(plain))
    monkeypatch.setattr(module, "_FOUND", set())


@pytest.fixture
def without_numba(monkeypatch: pytest.MonkeyPatch, fresh: None) -> None:
    """Let numba not be installed."""
    find_spec = importlib.util.find_spec

    def find(name: str, package: str | None = None) -> Any:
        return None if name == "numba" else find_spec(name, package)

    monkeypatch.setattr(importlib.util, "find_spec", find)


def is_compiled(function: Any) -> bool:
    """Tell whether numba has a hand in a function."""
    return hasattr(function, "py_func")


def test_a_compiled_function_gives_the_same_numbers() -> None:
    fast = compiled(lag_gain)
    assert is_compiled(fast)
    for dt in (0.0, 1e-9, 0.01, 3.0, 1e9):
        assert fast(dt, 0.2) == lag_gain(dt, 0.2)


def test_a_function_is_compiled_once() -> None:
    assert compiled(lag_gain) is compiled(lag_gain)
    assert compiled(sign) is not compiled(lag_gain)


def test_without_numba_the_functions_run_interpreted(without_numba: None) -> None:
    slow = compiled(lag_gain)
    assert not is_compiled(slow)
    assert slow(0.01, 0.2) == lag_gain(0.01, 0.2)


def test_without_numba_what_is_replaced_is_called_all_the_same(without_numba: None) -> None:
    """``aggregate`` calls ``blend`` and ``sign``; only the one that is named changes."""

    def other(weight: float, s1: float, s2: float) -> float:
        return 100.0

    parameters = AggregatorParameters()
    bound = compiled(aggregate, blend=other)
    assert bound(parameters, 1.0, 2.0, 0.0).value == 100.0
    assert compiled(aggregate)(parameters, 1.0, 1.0, 0.0).value == 1.0
    assert aggregate(parameters, 1.0, 1.0, 0.0).value == 1.0  # the original is left as it was
    assert bound.__qualname__ == f"aggregate.{other.__module__}.blend"


def test_twins_keep_their_names(without_numba: None) -> None:
    twin = compiled(combine)
    assert (twin.__module__, twin.__name__) == (combine.__module__, "combine")
    assert twin(NO_PREDICTION, 3.0, False) == 3.0


def test_defaults_are_kept(without_numba: None) -> None:
    def add(a: int, b: int = 5) -> int:
        return a + b

    assert compiled(add)(1) == 6


def test_compiled_functions_do_not_hold_the_interpreter() -> None:
    fast: Any = compiled(blend)
    found: list[float] = []
    threads = [threading.Thread(target=lambda: found.append(fast(0.5, 1.0, 2.0))) for _ in "ab"]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert found == [1.5, 1.5]
    assert fast.targetoptions["nogil"] is True


def test_work_is_kept_where_the_user_keeps_caches(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert Path(module._cache_directory()).parent == tmp_path / "fuzzy_fusion_ros"
    monkeypatch.delenv("XDG_CACHE_HOME")
    monkeypatch.setenv("HOME", str(tmp_path))
    assert Path(module._cache_directory()).parent == tmp_path / ".cache" / "fuzzy_fusion_ros"


def test_without_a_home_work_is_kept_with_temporary_files(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    for variable in ("NUMBA_CACHE_DIR", "XDG_CACHE_HOME", "HOME"):
        monkeypatch.setenv(variable, "/proc/none")
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    directory = Path(module._cache_directory())
    assert directory.parent == tmp_path
    assert directory.stat().st_mode & 0o777 == 0o700
    monkeypatch.setattr("os.getuid", lambda: 12345)  # what another user has put there is not run
    assert module._cache_directory() == ""


def test_work_is_kept_by_the_sources_that_went_in(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Also if a file has changed whose functions are only called, or that makes named tuples."""
    rooms = ("core", "batch", "simulation", "baselines", "paper", "parameters")
    for room in rooms:
        (tmp_path / room).mkdir()
        (tmp_path / room / "part.py").write_text("x = 1\n")
    monkeypatch.setattr(module, "__file__", str(tmp_path / "core" / "compiled.py"))
    monkeypatch.setattr(module, "_digest", module._digest.__wrapped__)  # each is another process
    directories = {module._cache_directory(), module._cache_directory()}
    for room in rooms:
        (tmp_path / room / "part.py").write_text("x = 2\n")
        directories.add(module._cache_directory())
    assert len(directories) == 1 + len(rooms)


def test_compiled_code_that_is_no_longer_used_is_deleted(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """After 30 days, when a new directory is made; nothing else that lies there."""
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    parent = tmp_path / "fuzzy_fusion_ros"
    days = {f"{0:016x}": 31, f"{1:016x}": 31, f"{2:016x}": 29, "another": 31}

    def directory(name: str) -> Path:
        monkeypatch.setattr(module, "_digest", lambda: name)
        return Path(module._cache_directory())

    for name in days:
        (directory(name) / "core").mkdir()
    for name, age in days.items():
        os.utime(parent / name, (time.time() - age * 86400,) * 2)
    directory(f"{1:016x}")  # in use again
    assert {each.name for each in parent.iterdir()} == set(days)
    directory(f"{3:016x}")
    assert {each.name for each in parent.iterdir()} == {*days, f"{3:016x}"} - {f"{0:016x}"}


def test_a_process_goes_on_when_another_deletes_what_it_has_compiled(
    monkeypatch: pytest.MonkeyPatch, fresh: None, tmp_path: Path
) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    assert compiled(sign)(-2.0) == -1.0
    shutil.rmtree(tmp_path)
    assert compiled(sign)(-2) == -1.0  # another signature
    assert compiled(lag_gain)(0.1, 0.2) == lag_gain(0.1, 0.2)
    assert {each.name.partition("-")[0] for each in tmp_path.rglob("*.nbi")} == {
        "aggregator.sign",
        "numerics.lag_gain",
    }


ELSE = {
    "Python": lambda patch: patch.setattr(sys.implementation, "cache_tag", "cpython-399"),
    "numba": lambda patch: patch.setattr(module, "version", lambda _: "99.0"),
    "processor": lambda patch: patch.setattr(module, "_processor", lambda: "another"),
    "copy of the package": lambda patch: patch.setattr(module, "__file__", "/else/batch/c.py"),
}


@pytest.mark.parametrize("variable", ["NUMBA_CACHE_DIR", "XDG_CACHE_HOME"])
@pytest.mark.parametrize("other", ELSE)
def test_what_another_has_compiled_is_not_taken_for_kept(
    variable: str, other: str, monkeypatch: pytest.MonkeyPatch, fresh: None, tmp_path: Path
) -> None:
    """It would be compiled after all, for the sake of a run that takes a second interpreted."""
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    monkeypatch.setenv(variable, str(tmp_path))
    monkeypatch.setattr(module, "_digest", module._digest.__wrapped__)
    assert not module.is_kept(sign)
    compiled(sign)(1.0)
    with monkeypatch.context() as elsewhere:
        ELSE[other](elsewhere)
        assert not module.is_kept(sign)
    assert module.is_kept(sign)


def test_what_was_compiled_is_kept_when_the_same_source_is_installed_again(
    monkeypatch: pytest.MonkeyPatch, fresh: None, tmp_path: Path
) -> None:
    """A checkout or a build gives equal sources a newer mtime; the directory is of their text."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    compiled(sign)(1.0)
    (found,) = tmp_path.rglob("*.nbi")
    os.utime(found, (0.0, 0.0))
    assert module.is_kept(sign)


def test_where_nothing_can_be_written_nothing_is_kept(
    monkeypatch: pytest.MonkeyPatch, fresh: None
) -> None:
    monkeypatch.setattr(module, "_cache_directory", lambda: "")
    assert not module.is_kept(sign)


def test_what_compiled_functions_call_is_compiled_for_them_alone(fresh: None) -> None:
    """Python calls a twin of its own, also where the other one is on disk already."""
    assert compiled(aggregate)(numbers(AggregatorParameters()), 1.0, 1.0, 0.0).value == 1.0
    assert compiled(blend)(0.5, 1.0, 2.0) == blend(0.5, 1.0, 2.0)


def test_a_cache_directory_of_the_users_choice_stands(
    monkeypatch: pytest.MonkeyPatch, fresh: None, tmp_path: Path
) -> None:
    monkeypatch.setattr(numba.config, "CACHE_DIR", "")
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    module._jit()(sign)
    assert Path(numba.config.CACHE_DIR).parent == tmp_path / "fuzzy_fusion_ros"


def test_a_cache_directory_is_set_where_there_was_none(
    monkeypatch: pytest.MonkeyPatch, fresh: None
) -> None:
    monkeypatch.setattr(numba.config, "CACHE_DIR", "")
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    module._jit()(sign)
    assert module._cache_directory() == numba.config.CACHE_DIR


ELSEWHERE = """
import numba
import os
from fuzzy_fusion_ros.batch.compiled import compiled
from fuzzy_fusion_ros.core.aggregator import blend
from fuzzy_fusion_ros.core.numerics import lag_gain
compiled(lag_gain)(0.1, 0.2)
os.environ["NUMBA_NUM_THREADS"] = "1"
compiled(lag_gain)(0.1, 2)
print(compiled(blend)(0.5, 1.0, 2.0), compiled(blend).stats.cache_path)
"""


def test_work_stays_there_when_numba_reads_its_variables_again(tmp_path: Path) -> None:
    """Else it lies beside the sources, where numba takes old code for new after an upgrade."""
    done = subprocess.run(
        [sys.executable, "-c", ELSEWHERE],
        env={"XDG_CACHE_HOME": str(tmp_path), "PYTHONPATH": str(Path(module.__file__).parents[2])},
        capture_output=True,
        text=True,
        check=True,
    )
    value, directory = done.stdout.split()
    assert float(value) == 1.5
    assert Path(directory).is_relative_to(tmp_path / "fuzzy_fusion_ros")
