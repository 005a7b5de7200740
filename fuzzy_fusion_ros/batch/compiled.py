# SPDX-License-Identifier: Apache-2.0
"""The same functions, compiled: for sweeps, fits and replays that take millions of steps.

One implementation of each equation serves all; numba, where it is installed, only runs it
faster. Results are the same to the last bit, as a test checks.
"""

from __future__ import annotations

import contextlib
import dis
import functools
import hashlib
import importlib.util
import os
import platform
import runpy
import shutil
import sys
import tempfile
import time
import types
from collections.abc import Callable, Iterator, Mapping, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any, TypeVar, cast

import numpy as np

from fuzzy_fusion_ros.core.predictor import copied

ROOMS = ("core", "batch", "simulation", "baselines", "paper", "parameters")
"""Where compiled functions, and the named tuples that they read by position, are defined."""

_PROCESSOR = ("model name", "flags", "CPU implementer", "CPU part", "Features")
"""Lines of ``/proc/cpuinfo`` that tell processors apart."""

_UNUSED_S = 30 * 86400.0
"""How long compiled code is kept after its last use, seconds."""

F = TypeVar("F", bound=Callable[..., Any])

_FOUND: set[str] = set()
"""Names of what has been found on disk: many short recordings ask again."""


def compiled(function: F, **replaced: Callable[..., Any]) -> F:
    """Return ``function`` compiled together with every function of this package that it calls.

    It releases the interpreter's lock, so threads run side by side, and is kept on disk for the
    next process. Where no directory can be written, each process compiles for itself. Without
    numba it runs interpreted.

    Args:
        function: A function over numbers, arrays and named tuples.
        replaced: Functions to call in place of the globals of these names: a loop is written
            for one method and bound to others.
    """
    twin: F = _twin(function, tuple(sorted(replaced.items())), is_called=False)
    return twin


def interpreted(function: F, **replaced: Callable[..., Any]) -> F:
    """Return ``function`` bound as by :func:`compiled`, but interpreted.

    For a run or two, which take less time than the compiler does; results are the same.

    Args:
        function: As for :func:`compiled`.
        replaced: As for :func:`compiled`.
    """
    return cast(F, _rebound(function, replaced))


def taken_by(function: Callable[..., Any], state: Any) -> Any:
    """Return a state as a function takes it.

    Args:
        function: As returned by :func:`compiled`.
        state: A named tuple; if the function is compiled, its lists or vectors become arrays.
    """
    return _with_arrays(state) if hasattr(function, "py_func") else state


def given_back(state: Any, like: Any) -> Any:
    """Return a state as other functions take it: lists or vectors where another one has them.

    Args:
        state: A named tuple that a function has returned, compiled or not.
        like: Another of its type that was not compiled by this module.
    """
    if isinstance(like, tuple):
        return type(like)(*map(given_back, state, like))
    is_other = isinstance(state, np.ndarray) and not isinstance(like, np.ndarray)
    return type(like)(state.tolist()) if is_other else state


def is_kept(function: Callable[..., Any], **replaced: Callable[..., Any]) -> bool:
    """Return whether :func:`compiled` finds on disk what another process has compiled.

    A numba that compares mtimes instead of contents compiles once more after a reinstallation.
    """
    if not can_compile():
        return False
    name = _bound_name(function, sorted(replaced.items()))
    directory = "" if name in _FOUND else _cache_directory()
    if directory and any(Path(directory).glob(f"*/*.{name}-*.nbi")):
        _FOUND.add(name)
    return name in _FOUND


def _bound_name(function: Any, replaced: Sequence[tuple[str, Any]]) -> str:
    names = (f"{value.__module__}.{name}" for name, value in replaced)
    return ".".join([function.__qualname__, *names])


def _with_arrays(state: Any) -> Any:
    if isinstance(state, tuple):
        return type(state)(*map(_with_arrays, state))
    return np.array(state) if hasattr(state, "__len__") else state


def can_compile() -> bool:
    """Return whether numba is installed."""
    return importlib.util.find_spec("numba") is not None


@functools.cache
def _twin(function: Any, replaced: tuple[tuple[str, Any], ...], *, is_called: bool) -> Any:
    """Return the compiled twin; one that only compiled functions call is not for Python.

    Without the wrappers that Python calls, compiling the whole method takes 37 s instead of 52.
    """
    jit = _jit()
    function = _readable(function)
    names = {i.argval for i in dis.get_instructions(function) if i.opname == "LOAD_GLOBAL"}
    callees = {
        name: value
        for name, value in function.__globals__.items()
        if name in names and _is_ours(value)
    }
    callees.update(replaced)
    twins = {
        name: np.copy if value is copied else _twin(value, (), is_called=True)
        for name, value in callees.items()
    }
    twin = _rebound(function, twins)
    twin.__module__ = function.__module__
    twin.__qualname__ = _bound_name(function, replaced) + is_called * ".called"
    return jit(twin, no_cpython_wrapper=is_called, no_cfunc_wrapper=is_called)


def _readable(function: Any) -> Any:
    """Return a function with code that numba can read: the source's, if an extension has it."""
    if isinstance(function, types.FunctionType):
        return function
    module = sys.modules[function.__module__]
    found = _source(module)[function.__name__]
    return types.FunctionType(found.__code__, vars(module), None, found.__defaults__)


@functools.cache
def _source(module: types.ModuleType) -> Mapping[str, Any]:
    """Run the source of an extension; only the code of its functions is of use."""
    stem = module.__name__.rpartition(".")[2]
    return runpy.run_path(str(Path(cast(str, module.__file__)).with_name(f"{stem}.py")))


def _rebound(function: Any, replaced: Mapping[str, Callable[..., Any]]) -> Any:
    return types.FunctionType(
        function.__code__,
        {**function.__globals__, **replaced},
        function.__name__,
        function.__defaults__,
    )


def _is_ours(value: Any) -> bool:
    """Return whether a value is a function of this package, of a source or of an extension."""
    return isinstance(value, types.FunctionType | types.BuiltinFunctionType) and str(
        value.__module__
    ).startswith(__name__.partition(".")[0])


@functools.cache
def _jit() -> Callable[..., Any]:
    """Return numba's compiler, set to keep its work, or the identity where it is missing."""
    if not can_compile():
        return lambda function, **_: function
    # Level 3, the default, compiles the whole method in twice the time to the same speed.
    os.environ.setdefault("NUMBA_OPT", "2")
    import numba  # costs start-up time that only long runs win back

    settings: Any = numba.config
    njit: Any = numba.njit  # its types lack the wrappers
    directory = _cache_directory()

    def jit(function: Any, **options: bool) -> Any:
        settings.CACHE_DIR = directory  # numba forgets it whenever one of its own variables changes
        # Inlined, since a call counts references to each array of a state twice, which took more
        # than half of a step: the compiler drops the counts of what stays within one function.
        kept = bool(directory)
        return njit(nogil=True, cache=kept, forceinline=True, **options)(function)

    return jit


def _cache_directory() -> str:
    """Return where compiled code is kept; empty if nothing can be written anywhere.

    Its mtime is that of the last use. A new one takes the place of those no longer used.
    """
    for directory in _directories():
        try:
            is_new = not directory.exists()
            directory.mkdir(parents=True, exist_ok=True)
            os.utime(directory)
            tempfile.TemporaryFile(dir=directory).close()
        except OSError:
            continue
        if is_new:
            _remove_unused(directory.parent)
        return str(directory)
    return ""


def _remove_unused(parent: Path) -> None:
    """Delete what no process has used for ``_UNUSED_S``; others may delete it at the same time.

    A process that takes one into use just then compiles once more.
    """
    for directory in parent.glob("[0-9a-f]" * 16):
        with contextlib.suppress(OSError):
            if time.time() - directory.stat().st_mtime > _UNUSED_S:
                shutil.rmtree(directory, ignore_errors=True)


@functools.cache
def _digest() -> str:
    """Return what changes with what compiled code depends on.

    Numba looks at the file of the function alone, and misses a change in a callee's. What another
    Python, numba, processor or copy of the package has compiled lies elsewhere: it is of no use.
    """
    package = Path(__file__).parents[1]
    depends = sys.implementation.cache_tag, version("numba"), _processor(), str(package)
    digest = hashlib.sha256("\n".join(depends).encode())
    for source in sorted(path for room in ROOMS for path in (package / room).glob("*.py")):
        digest.update(source.read_bytes())
    return digest.hexdigest()[:16]


def _processor() -> str:
    """Describe the processor: LLVM, which would name it, takes 0.14 s to import."""
    known = [platform.machine(), platform.processor()]
    with contextlib.suppress(OSError):
        lines = Path("/proc/cpuinfo").read_text(encoding="ascii", errors="replace").splitlines()
        known += sorted({each for each in lines if each.startswith(_PROCESSOR)})
    return "\n".join(known)


def _directories() -> Iterator[Path]:
    """Yield where compiled code may be kept: as the user wants, the usual place, a last resort."""
    name = _digest()
    for variable in ("NUMBA_CACHE_DIR", "XDG_CACHE_HOME"):
        if os.environ.get(variable):
            yield Path(os.environ[variable]) / "fuzzy_fusion_ros" / name
    with contextlib.suppress(RuntimeError):  # a user without a home
        yield Path.home() / ".cache" / "fuzzy_fusion_ros" / name
    if not hasattr(os, "getuid"):  # Windows: the directory for temporary files is the user's own
        yield Path(tempfile.gettempdir()) / f"fuzzy_fusion_ros-{name}"
        return
    with contextlib.suppress(OSError):
        shared = Path(tempfile.gettempdir()) / f"fuzzy_fusion_ros-{os.getuid()}-{name}"
        shared.mkdir(mode=0o700, exist_ok=True)
        if shared.lstat().st_uid == os.getuid():  # what is read from there is run
            yield shared
