# SPDX-License-Identifier: Apache-2.0
"""Changes one operator, number or statement at a time and says which changes no test notices.

    make mutants ARGS="core online --sample 50"

Instead of mutmut or cosmic-ray because those mutate the working tree, or an installed package, and
know nothing of loops that numba compiles and caches: a mutant of those would run as it was before.
"""

from __future__ import annotations

import argparse
import ast
import copy
import os
import random
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

PACKAGE = "fuzzy_fusion_ros"
ROOT = Path(__file__).resolve().parents[1]
ROOMS = ("core", "online", "scoring", "tuning")

COMPILED = ("core",)
"""Rooms whose mutants run interpreted: to compile each would take longer than its tests."""

PATIENCE = 900
"""Seconds after which a mutant loops for ever, and so is noticed."""

SWAPPED: dict[type[ast.AST], type[ast.AST]] = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Div,
    ast.Div: ast.Mult,
    ast.FloorDiv: ast.Mult,
    ast.Mod: ast.Mult,
    ast.Pow: ast.Mult,
    ast.Lt: ast.LtE,
    ast.LtE: ast.Lt,
    ast.Gt: ast.GtE,
    ast.GtE: ast.Gt,
    ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq,
    ast.Is: ast.IsNot,
    ast.IsNot: ast.Is,
    ast.In: ast.NotIn,
    ast.NotIn: ast.In,
    ast.And: ast.Or,
    ast.Or: ast.And,
}


class Mutant(NamedTuple):
    """A source file with one change.

    Attributes:
        path: The file, relative to the repository.
        line: Where the change is.
        before: What is changed.
        after: What it is changed to.
        source: The whole file after the change.
    """

    path: str
    line: int
    before: str
    after: str
    source: str


def mutants(path: Path) -> Iterator[Mutant]:
    """Yield every mutant of a file."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    for node in places(tree):
        for changed in changes(node):
            kept = dict(vars(node)), type(node)
            before = ast.unparse(node)
            become(node, changed)
            yield Mutant(
                str(path.relative_to(ROOT)),
                int(getattr(node, "lineno", 0)),
                before.splitlines()[0],
                ast.unparse(node).splitlines()[0],
                ast.unparse(tree),
            )
            become(node, kept[1](**kept[0]))


def become(node: ast.AST, other: ast.AST) -> None:
    """Turn a node of a tree into another one, in its place."""
    node.__class__ = other.__class__
    vars(node).clear()
    vars(node).update(vars(other))


def places(node: ast.AST) -> Iterator[ast.AST]:
    """Yield what may be changed; not annotations, docstrings, errors' texts and overloads."""
    if isinstance(node, ast.Raise | ast.Import | ast.ImportFrom | ast.JoinedStr):
        return
    yield node
    for field, value in ast.iter_fields(node):
        if field in ("annotation", "returns", "decorator_list", "bases"):
            continue
        for child in value if isinstance(value, list) else [value]:
            if isinstance(child, ast.AST) and not is_text(child):
                yield from places(child)


def is_text(node: ast.AST) -> bool:
    """Return whether a statement is a docstring."""
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)


def changes(node: ast.AST) -> Iterator[ast.AST]:
    """Yield what a node may be changed to."""
    where: Any = {"lineno": getattr(node, "lineno", 0), "col_offset": 0}
    if isinstance(node, ast.BinOp | ast.BoolOp | ast.AugAssign) and type(node.op) in SWAPPED:
        yield type(node)(**{**vars(node), "op": SWAPPED[type(node.op)]()})
    if isinstance(node, ast.Compare):
        for k, op in enumerate(node.ops):
            ops = [*node.ops[:k], SWAPPED[type(op)](), *node.ops[k + 1 :]]
            yield ast.Compare(**{**vars(node), "ops": ops})
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub | ast.Not):
        yield copy.copy(node.operand)
    if isinstance(node, ast.Constant):
        if isinstance(node.value, bool):
            yield ast.Constant(value=not node.value, **where)
        elif isinstance(node.value, int | float):
            yield ast.Constant(value=node.value + 1, **where)
    if isinstance(node, ast.If | ast.IfExp | ast.While):
        test = ast.UnaryOp(op=ast.Not(), operand=node.test, **where)
        yield type(node)(**{**vars(node), "test": test})
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
        if node.func.id in ("min", "max", "abs", "bounded", "clamped") and node.args:
            yield copy.copy(node.args[0])
        if node.func.id in ("min", "max"):
            other = ast.Name(id={"min": "max", "max": "min"}[node.func.id], ctx=ast.Load(), **where)
            yield ast.Call(**{**vars(node), "func": other})
    if isinstance(node, ast.AugAssign | ast.Delete | ast.Continue | ast.Break) or (
        isinstance(node, ast.Expr) and isinstance(node.value, ast.Call)
    ):
        yield ast.Pass(**where)


def tests_of(path: str) -> list[str]:
    """Return the tests of a file's room, the file's own first."""
    room, stem = Path(path).parts[1], Path(path).stem
    found = sorted(str(each.relative_to(ROOT)) for each in (ROOT / "test" / room).glob("test_*.py"))
    return sorted(found, key=lambda each: not Path(each).stem.startswith(f"test_{stem}"))


def copied(folder: Path) -> Path:
    """Copy what the tests of a room need, so that changes are made in the copy."""
    ignored = shutil.ignore_patterns("__pycache__")
    for name in (PACKAGE, "test"):
        shutil.copytree(ROOT / name, folder / name, ignore=ignored)
    for name in ("setup.cfg", "bags", "config"):
        (folder / name).symlink_to(ROOT / name)
    return folder


def passes(folder: Path, path: str) -> bool:
    """Run the tests of a file's room in a copy, up to the first that fails; whether all pass."""
    environment = {
        **os.environ,
        "NUMBA_DISABLE_JIT": str(int(Path(path).parts[1] in COMPILED)),
        "PYTHONDONTWRITEBYTECODE": "1",  # two changes of a file within a second look the same
        "PYTHONPATH": str(folder),
    }
    # The plugin would import the package before pytest knows of the copy.
    options = ("-q", "-x", "-m", "not slow", "-p", "no:cacheprovider", "-p", "no:fuzzy_fusion_ros")
    try:
        done = subprocess.run(
            [sys.executable, "-m", "pytest", *options, *tests_of(path)],
            cwd=folder,
            env=environment,
            capture_output=True,
            check=False,
            timeout=PATIENCE,
        )
    except subprocess.TimeoutExpired:
        return False
    return done.returncode == 0


def judge(some: list[Mutant], folder: Path) -> Iterator[tuple[Mutant, bool]]:
    """Yield each mutant, and whether all tests pass with it."""
    for each in some:
        path = folder / each.path
        whole = path.read_text(encoding="utf-8")
        path.write_text(each.source, encoding="utf-8")
        yield each, passes(folder, each.path)
        path.write_text(whole, encoding="utf-8")


def main() -> int:
    """Try mutants, print those that no test notices; return 1 if there are any."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("rooms", nargs="*", default=ROOMS, help="rooms, or files in them")
    parser.add_argument("--sample", type=int, metavar="N", help="how many to try, default all")
    parser.add_argument("--seed", type=int, default=0, help="seed of the sample")
    arguments = parser.parse_args()

    given = [ROOT / PACKAGE / each for each in arguments.rooms]
    files = [file for each in given for file in sorted(each.glob("*.py")) or [each]]
    every = [mutant for file in files for mutant in mutants(file)]
    some = every
    if arguments.sample is not None and arguments.sample < len(every):
        some = random.Random(arguments.seed).sample(every, arguments.sample)
    survivors = 0
    with tempfile.TemporaryDirectory() as scratch:
        folder = copied(Path(scratch))
        for room in sorted({Path(each.path).parts[1] for each in some}):
            unchanged = f"{PACKAGE}/{room}/__init__.py"
            if not passes(folder, unchanged):
                parser.error(f"tests of {room} fail without any change")
        for done, (mutant, survives) in enumerate(judge(some, folder), start=1):
            survivors += survives
            if survives:
                place = f"{mutant.path}:{mutant.line}"
                print(f"{place}: {mutant.before}  ->  {mutant.after}", flush=True)
            if sys.stderr.isatty():
                print(f"{done}/{len(some)}", end="\r", file=sys.stderr)
    print(f"{len(some)} of {len(every)} mutants tried, {survivors} not noticed")
    return int(survivors > 0)


if __name__ == "__main__":
    sys.exit(main())
