# SPDX-License-Identifier: Apache-2.0
"""Docstrings are there, and name what is there."""

from __future__ import annotations

import ast
import builtins
import importlib
import re
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import NamedTuple

import pytest

from fuzzy_fusion_ros.parameters import errors

PACKAGE = "fuzzy_fusion_ros"
ROOT = Path(__file__).resolve().parents[1]
SOURCES = sorted((ROOT / PACKAGE).rglob("*.py"))

Function = ast.FunctionDef | ast.AsyncFunctionDef

TITLES = ("Args", "Attributes", "Raises", "Returns", "Yields")
"""Sections that a docstring may have."""


class Documented(NamedTuple):
    """A public module, class or function.

    Attributes:
        name: Its dotted name, as seen from the package.
        module: The importable name of its module.
        node: Its syntax tree.
        docstring: What its docstring says, ``""`` without one.
    """

    name: str
    module: str
    node: ast.Module | ast.ClassDef | Function
    docstring: str


def documented() -> Iterator[Documented]:
    """Yield everything public in the package."""
    for path in SOURCES:
        parts = path.relative_to(ROOT).with_suffix("").parts
        module = ".".join(parts[:-1] if parts[-1] == "__init__" else parts)
        yield from inside(ast.parse(path.read_text(encoding="utf-8")), module, module)


def inside(
    node: ast.Module | ast.ClassDef | Function, name: str, module: str
) -> Iterator[Documented]:
    """Yield a node and everything public in it."""
    yield Documented(name, module, node, ast.get_docstring(node) or "")
    if isinstance(node, ast.Module | ast.ClassDef):
        for child in node.body:
            if isinstance(child, ast.ClassDef | Function) and is_public(child):
                yield from inside(child, f"{name}.{child.name}", module)


def is_public(node: ast.ClassDef | Function) -> bool:
    """Tell whether a class or function is for readers: a setter has its getter's docstring."""
    decorators = [ast.unparse(decorator) for decorator in node.decorator_list]
    spoken_for = (".setter", ".deleter", "overload")
    return not node.name.startswith("_") and not any(d.endswith(spoken_for) for d in decorators)


def section(docstring: str, title: str) -> list[str] | None:
    """Return the names that a Google-style section explains, ``None`` without that section."""
    lines = docstring.splitlines()
    if f"{title}:" not in lines:
        return None
    names: list[str] = []
    for line in lines[lines.index(f"{title}:") + 1 :]:
        if line and not line.startswith(" "):
            break
        if entry := re.match(
            r"    (\*{0,2}[\w.]+(?:, \*{0,2}[\w.]+)*)(?: \([^)]*\))?:(?: |$)", line
        ):
            names += entry[1].split(", ")
    return names


def misplaced(docstring: str) -> list[str]:
    """Return the lines of a docstring that no section would be read from.

    A title is one of ``TITLES`` and not indented; below it, entries are indented by 4 and what
    goes on by 8.
    """
    wrong, inside_section = [], False
    for line in docstring.splitlines():
        indent = len(line) - len(line.lstrip())
        if re.fullmatch(r" *[A-Z][a-z]+:", line):
            inside_section = indent == 0 and line[:-1] in TITLES
            if not inside_section:
                wrong.append(line)
        elif line and indent == 0:
            inside_section = False
        elif line and inside_section and indent not in (4, 8):
            wrong.append(line)
    return wrong


def arguments(node: ast.ClassDef | Function) -> list[str]:
    """Name the arguments of a function, or those of a class's constructor."""
    if isinstance(node, ast.ClassDef):
        constructors = [n for n in node.body if isinstance(n, Function) and n.name == "__init__"]
        return arguments(constructors[0]) if constructors else fields(node)
    given = node.args
    names = [a.arg for a in (*given.posonlyargs, *given.args)]
    if given.vararg:
        names.append(given.vararg.arg)
    names += [a.arg for a in given.kwonlyargs]
    if given.kwarg:
        names.append(given.kwarg.arg)
    return [name for name in names if name not in {"self", "cls"}]


def fields(node: ast.ClassDef) -> list[str]:
    """Name the fields of a dataclass or named tuple."""
    return [
        child.target.id
        for child in node.body
        if isinstance(child, ast.AnnAssign)
        and isinstance(child.target, ast.Name)
        and not child.target.id.startswith("_")
        and "ClassVar" not in ast.unparse(child.annotation)
    ]


def is_record(node: ast.ClassDef) -> bool:
    """Tell whether a class is a dataclass or a named tuple, whose fields are all it has."""
    decorators = [ast.unparse(decorator) for decorator in node.decorator_list]
    return any("dataclass" in name for name in decorators) or any(
        ast.unparse(base).endswith("NamedTuple") for base in node.bases
    )


def attributes(node: ast.ClassDef) -> set[str]:
    """Name what an instance of a class can be asked for: fields, properties and assignments."""
    names = set(fields(node))
    names |= {
        child.name
        for child in node.body
        if isinstance(child, Function)
        and any("property" in ast.unparse(decorator) for decorator in child.decorator_list)
    }
    names |= {
        child.attr
        for child in ast.walk(node)
        if isinstance(child, ast.Attribute)
        and isinstance(child.ctx, ast.Store)
        and isinstance(child.value, ast.Name)
        and child.value.id == "self"
    }
    return names | {
        target.id
        for child in node.body
        if isinstance(child, ast.Assign)
        for target in child.targets
        if isinstance(target, ast.Name)
    }


def test_a_section_is_read_as_written() -> None:
    docstring = """Do.

    Args:
        x: A number,
            in detail: twice.
        a, b: Two.
        *rest: More.
        kind (str): Old style.

    Returns:
        y: not an argument.
    """
    lines = ast.get_docstring(ast.parse(f'"""{docstring}"""')) or ""
    assert section(lines, "Args") == ["x", "a", "b", "*rest", "kind"]
    assert section(lines, "Raises") is None


@pytest.mark.parametrize(
    ("docstring", "problems"),
    [
        ("Do.\n\nArgs:\n    x: A number,\n        in detail.\n\nReturns:\n    It.", []),
        ("Do.\n\n    Attributes:\n        x: A number.", ["    Attributes:"]),
        ("Do.\n\nArgs:\n  x: A number.", ["  x: A number."]),
        ("Do.\n\nArgs:\n    x: A number,\n      in detail.", ["      in detail."]),
        ("Do.\n\nArguments:\n    x: A number.", ["Arguments:"]),
        ("Do.\n\nThese Args:\n\n    >>> 1\n    1", []),
    ],
)
def test_what_is_out_of_place_is_found(docstring: str, problems: list[str]) -> None:
    assert misplaced(docstring) == problems


def test_sections_stand_where_they_are_read() -> None:
    assert [(d.name, wrong) for d in documented() if (wrong := misplaced(d.docstring))] == []


def test_everything_public_has_a_docstring() -> None:
    assert [d.name for d in documented() if not d.docstring] == []


def test_arguments_are_explained_by_their_names() -> None:
    wrong = []
    for d in documented():
        explained = section(d.docstring, "Args")
        if explained is None or isinstance(d.node, ast.Module):
            continue
        if [name.lstrip("*") for name in explained] != arguments(d.node):
            wrong.append((d.name, explained, arguments(d.node)))
    assert wrong == []


def test_attributes_are_explained_by_their_names() -> None:
    wrong = []
    for d in documented():
        explained = section(d.docstring, "Attributes")
        if explained is None or not isinstance(d.node, ast.ClassDef):
            continue
        if is_record(d.node) and explained != fields(d.node):
            wrong.append((d.name, explained, fields(d.node)))
        elif not set(explained) <= attributes(d.node):
            wrong.append((d.name, explained, sorted(attributes(d.node))))
    assert wrong == []


def test_errors_are_explained_by_their_names() -> None:
    """An error is known where it is raised, there by its module, or it is ours or Python's."""
    wrong = []
    for d in documented():
        for error in section(d.docstring, "Raises") or ():
            here = importlib.import_module(d.module)
            modules = [x for x in vars(here).values() if isinstance(x, ModuleType)]
            places = (here, *modules, errors, builtins)
            found = next((getattr(p, error) for p in places if hasattr(p, error)), None)
            if not (isinstance(found, type) and issubclass(found, BaseException)):
                wrong.append((d.name, error))
    assert wrong == []
