# SPDX-License-Identifier: Apache-2.0
"""Makes docs/api.md from the docstrings of the Python interface: ``make docs``.

Instead of a generator of whole sites because this is one page, which readers meet on a forge.
"""

from __future__ import annotations

import ast
import inspect
import re
import textwrap
from collections.abc import Iterator
from pathlib import Path
from types import FunctionType, ModuleType

import fuzzy_fusion_ros
from fuzzy_fusion_ros import testing
from fuzzy_fusion_ros.bag import BagMessage, BagReader
from fuzzy_fusion_ros.checking.check import Check
from fuzzy_fusion_ros.checking.finding import Finding
from fuzzy_fusion_ros.jobs.check import CheckResult
from fuzzy_fusion_ros.jobs.fuse import FusedArrays
from fuzzy_fusion_ros.jobs.progress import Progress
from fuzzy_fusion_ros.jobs.tune import TuneResult
from fuzzy_fusion_ros.offline.replay import Replayed
from fuzzy_fusion_ros.online.verdict import Fused, Verdict
from fuzzy_fusion_ros.scoring.score import Score

PAGE = Path(__file__).with_name("api.md")
HEAD = """\
# Python interface

<!-- made by docs/make_api.py -->

These names are public; everything else may change without notice. The first part needs no ROS, and
`import fuzzy_fusion_ros` imports nothing else until a name is used. Programs that use it are
`examples/fuse_arrays.py` and the others in that directory;
[fusion_node](fusion_node.md#parameters) lists the parameters.
"""
TYPES = (
    CheckResult,
    Check,
    Finding,
    FusedArrays,
    Verdict,
    Fused,
    BagReader,
    BagMessage,
    Replayed,
    Score,
    TuneResult,
    Progress,
)
SECTIONS = {"Args:", "Attributes:", "Raises:"}
WIDTH = 80


def page() -> str:
    """Return the page."""
    parts = [HEAD, "## `fuzzy_fusion_ros`\n", *_members(fuzzy_fusion_ros)]
    parts += ["## What they take and return\n", *(_class(each.__name__, each) for each in TYPES)]
    parts += ["## `fuzzy_fusion_ros.testing`\n", _markdown(testing), *_members(testing)]
    return "\n".join(parts)


def _members(module: ModuleType) -> Iterator[str]:
    for name in module.__all__:
        value = getattr(module, name)
        yield _class(name, value) if inspect.isclass(value) else _function("###", name, value)


def _class(name: str, kind: type) -> str:
    parts = [f"### `{name}`\n"]
    constructor = vars(kind).get("__init__")
    if isinstance(constructor, FunctionType) and not hasattr(kind, "__dataclass_fields__"):
        parts.append(_signature(name, constructor))
    parts.append(_markdown(kind))
    if (
        constructor is not None
        and constructor.__doc__
        and constructor.__module__ == kind.__module__
    ):
        parts.append(_markdown(constructor))
    for base in reversed(kind.__mro__):
        if base.__module__.startswith("fuzzy_fusion_ros.parameters"):
            continue  # parameters have methods for their own use only
        for member, value in vars(base).items():
            if isinstance(value, property) and not member.startswith("_"):
                parts += [f"#### `{member}`\n", _markdown(value)]
            elif isinstance(value, FunctionType) and _is_public(member, value):
                shown = name.lower() if member == "__call__" else member
                parts.append(_function("####", shown, value))
    return "\n".join(parts)


def _is_public(name: str, value: FunctionType) -> bool:
    """Tell what a class offers from what its kind brings along."""
    ours = value.__module__.startswith("fuzzy_fusion_ros") and value.__doc__ is not None
    return ours and (name == "__call__" or not name.startswith("_"))


def _function(level: str, name: str, function: FunctionType) -> str:
    return "\n".join([f"{level} `{name}`\n", _signature(name, function), _markdown(function)])


def _signature(name: str, function: FunctionType) -> str:
    """Return a signature as it stands in the source, one argument a line if it is long."""
    source = textwrap.dedent(inspect.getsource(inspect.unwrap(function)))
    node = ast.parse(source).body[0]
    assert isinstance(node, ast.FunctionDef)
    if node.args.args and node.args.args[0].arg == "self":
        del node.args.args[0]
    arguments = re.sub(r"(?<=[\w\]])=(?=\S)", " = ", ast.unparse(node.args))
    constructor = function.__name__ == "__init__"
    returned = "" if constructor or node.returns is None else f" -> {ast.unparse(node.returns)}"
    text = f"{name}({arguments}){returned}"
    if len(text) > WIDTH:
        lines = ",\n    ".join(_at_outer_commas(arguments))
        text = f"{name}(\n    {lines},\n){returned}"
    return f"```python\n{text}\n```\n"


def _at_outer_commas(arguments: str) -> list[str]:
    depth, parts = 0, [""]
    for character in arguments:
        depth += (character in "[({") - (character in "])}")
        if character == "," and depth == 0:
            parts.append("")
        else:
            parts[-1] += character
    return [part.strip() for part in parts]


def _markdown(documented: object) -> str:
    """Return a docstring in Markdown: sections as lists, literals and roles as code."""
    lines: list[str] = []
    for paragraph in (inspect.getdoc(documented) or "").split("\n\n"):
        title, _, body = paragraph.partition("\n")
        if title in SECTIONS:
            entries = re.sub(r"^(\S[^:\n]*): ", r"- `\1`: ", textwrap.dedent(body), flags=re.M)
            lines.append(f"**{title}**\n\n{re.sub('^    ', '  ', entries, flags=re.M)}")
        elif title == "Returns:":
            lines.append(f"**{title}** {textwrap.dedent(body)}")
        elif paragraph.startswith(">>> "):
            lines.append(f"```python\n{paragraph}\n\n```")
        else:
            lines.append(paragraph)
    text = re.sub(r"``([^`\n]+)``", r"`\1`", "\n\n".join(lines) + "\n")
    return re.sub(r":\w+:`~?(?:[\w.]*\.)?(\w+)`", r"`\1`", text)


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
