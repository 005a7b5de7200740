# SPDX-License-Identifier: Apache-2.0
"""ROS parameter files, read as ROS reads them but without ROS, and written.

A node gets its files from rclpy; the tools that work offline read the same files here. Scalars
are resolved by rcl's rules, which differ from YAML's own: ``1e5`` is a number, ``y`` is true.
"""

from __future__ import annotations

import difflib
import json
import re
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from functools import lru_cache
from pathlib import Path
from typing import Any

import yaml

from fuzzy_fusion_ros.parameters.errors import ParameterError
from fuzzy_fusion_ros.parameters.fusion import BUILTIN, Parameters
from fuzzy_fusion_ros.parameters.group import (
    Descriptor,
    Group,
    Value,
    described,
    flatten,
    replace,
    shaped,
)
from fuzzy_fusion_ros.parameters.writing import writing
from fuzzy_fusion_ros.parameters.yaml_text import LOADER, checked_yaml, read_yaml_text
from fuzzy_fusion_ros.text.visible import visible

KEY = "ros__parameters"

NARROW = "a node of any name; for one only, put its name here, such as /robot/fusion_node"

_TRUE = {"y", "Y", "yes", "Yes", "YES", "true", "True", "TRUE", "on", "On", "ON"}
_FALSE = {"n", "N", "no", "No", "NO", "false", "False", "FALSE", "off", "Off", "OFF"}
_SPECIAL = re.compile(r"([-+]?)\.(nan|NaN|NAN|inf|Inf|INF)")


class ParameterFileError(ParameterError):
    """A parameter file cannot be used."""

    def __init__(self, path: str | Path, problem: str) -> None:
        Exception.__init__(self, f"parameter file {str(path)!r}: {problem}")
        self.name = ""
        self.problem = problem


def load(path: str | Path, node_name: str = "fusion_node") -> dict[str, Any]:
    """Return the parameters that a file holds for a node, by dotted name, later ones winning.

    Args:
        path: The file.
        node_name: The node; ``/ns/name`` is met by what ROS would give that node, a bare name by
            what it would give a node of that name in any namespace.

    Raises:
        ParameterFileError: The file is missing, is not a parameter file, or holds nothing for the
            node.
    """
    return dict(_for_node(str(path), read_text(path), node_name))


@lru_cache(maxsize=4)  # many bags take the same file
def _for_node(path: str, text: str, node_name: str) -> Mapping[str, Any]:
    found: dict[str, Any] = {}
    others: list[str] = []
    for owner, values in _sections(path, text):
        if applies(owner, node_name):
            found.update(values)
        else:
            others.append(owner)
    if not found:
        names = ", ".join(others) or "no node"
        raise ParameterFileError(
            path, f"it has no entry for {node_name}, only for {names}: rename the entry"
        )
    return found


def owners(path: str | Path) -> list[str]:
    """Return the names of the nodes that a file has something for.

    Raises:
        ParameterFileError: The file is missing or is not a parameter file.
    """
    return [owner for owner, _ in _sections(path, read_text(path))]


def parameters_from(path: str | Path, node_name: str = "fusion_node") -> Parameters:
    """Return the fusion's parameters: the defaults, overridden by those in a file.

    Raises:
        ParameterError: As :func:`load`; a name is unknown, or a value or combination not allowed.
    """
    return _parameters(str(path), read_text(path), node_name)


@lru_cache(maxsize=4)  # many bags take the same file
def _parameters(path: str, text: str, node_name: str) -> Parameters:
    values = _for_node(path, text, node_name)
    own = {name: value for name, value in values.items() if not is_builtin(name)}
    try:
        if "channels" in own:  # they decide which names are known
            refuse("channels", own["channels"], described(Parameters()))
        known = described(shaped(Parameters(), own))
        for name, value in own.items():
            refuse(name, value, known)
        return replace(Parameters(), own)
    except ParameterError as error:
        raise ParameterFileError(path, str(error)) from None


def dump(
    parameters: Group,
    path: str | Path,
    comments: Iterable[str] = (),
    node_name: str = "",
) -> None:
    """Write parameters as a file that the node takes.

    Args:
        parameters: What to write, each with its meaning, unit and range as a comment.
        path: The file, overwritten if it exists; its directory is made if it is missing.
        comments: Lines to write at the top.
        node_name: The node that it is for, in any namespace; empty for a node of any name.

    Raises:
        FusionError: The file cannot be written.
    """
    with writing(path) as file:
        file.write_text(dumps(parameters, comments, node_name), encoding="utf-8")


def dumps(parameters: Group, comments: Iterable[str] = (), node_name: str = "") -> str:
    """Return the text of the file that :func:`dump` writes."""
    lines = [f"# {visible(line)}".rstrip() for line in comments]
    owner = f"/**/{node_name}:" if node_name else f"/**:  # {NARROW}"
    lines += [owner, f"  {KEY}:"]
    lines += _entries(parameters)
    return "\n".join(lines) + "\n"


def is_builtin(name: str) -> bool:
    """Return whether a parameter is one that every ROS node has."""
    owner, dot, _ = name.partition(".")
    return owner in BUILTIN and bool(dot) == (owner == "qos_overrides")


def refuse(name: str, value: object, known: Mapping[str, Descriptor]) -> None:
    """Raise if a parameter is unknown, or is a text that YAML has turned into true or false.

    Raises:
        ParameterError: It is; the error says what to write.
    """
    if name not in known:
        raise ParameterError(name, _advice(name, known))
    texts = value if isinstance(value, list) else [value]
    if known[name].kind in {str, tuple} and any(isinstance(text, bool) for text in texts):
        expected = known[name].range
        raise ParameterError(
            name, f"got {value!r}, expected {expected}: quote words like 'y' and 'on'"
        )


def _advice(name: str, known: Mapping[str, Descriptor]) -> str:
    """Return what is wrong with the name of an unknown parameter, and what to write."""
    below_it = [each for each in known if each.startswith(f"{name}.")]
    if below_it:
        field = f"{name}.s1.field"
        such = field if field in below_it else below_it[0]
        return f"expected parameters below it, such as {such}"
    channel, _, below = name.partition(".")
    if "channels" in known and below in known:
        field = ".s1.field"
        there = [each.removesuffix(field) for each in known if each.endswith(field)]
        if channel in there:
            return f"{below} belongs to the node, not to a channel: write it as {below}"
        return (
            f"there is no channel {channel!r} in channels, which has: "
            f"{', '.join(there) or 'none'}; add it there, or use one of these"
        )
    close = difflib.get_close_matches(name, list(known), n=1, cutoff=0.6)
    advice = f"did you mean {close[0]}?" if close else f"expected one of {', '.join(known)}"
    return f"unknown; {advice}"


def applies(owner: str, node_name: str) -> bool:
    """Return whether ROS would give the entry ``owner`` to a node.

    Args:
        owner: A node's full name as it stands in a file; ``*`` is any one part of it, ``**``
            any number of parts.
        node_name: ``/ns/name``, or a bare name for a node of that name in any namespace.
    """
    parts = [part for part in owner.split("/") if part]
    if not node_name.startswith("/"):
        return bool(parts) and parts[-1] in {node_name, "*", "**"}
    return _matches(parts, [part for part in node_name.split("/") if part])


def _matches(pattern: list[str], names: list[str]) -> bool:
    if not pattern:
        return not names
    head, rest = pattern[0], pattern[1:]
    if head == "**":
        return any(_matches(rest, names[skipped:]) for skipped in range(len(names) + 1))
    return bool(names) and head in {"*", names[0]} and _matches(rest, names[1:])


def read_text(path: str | Path) -> str:
    """Return the text of a parameter file.

    Raises:
        ParameterFileError: The file cannot be read, or is no text.
    """
    with _reading(path):
        return read_yaml_text(Path(path))


@contextmanager
def _reading(path: str | Path) -> Iterator[None]:
    """Context manager: report any failure to read a file."""
    try:
        yield
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        reason = " ".join(str(error).split())
        raise ParameterFileError(path, f"is not valid YAML: {reason}") from None
    except (OSError, ValueError) as error:
        reason = str(error.strerror if isinstance(error, OSError) else error)
        raise ParameterFileError(path, f"cannot be read: {reason}") from None


def _sections(path: str | Path, text: str) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield each node's name in a file with its parameters."""
    with _reading(path):
        root = yaml.compose(checked_yaml(text, aliases=False), LOADER)
    if not isinstance(root, yaml.MappingNode):
        raise ParameterFileError(path, f"expected node names with {KEY}: below them")
    yield from _nodes_in(path, root, "")


def _nodes_in(path: str | Path, node: Any, owner: str) -> Iterator[tuple[str, dict[str, Any]]]:
    for key, value in node.value:
        if not isinstance(value, yaml.MappingNode):
            line = key.start_mark.line + 1
            raise ParameterFileError(
                path, f"line {line}: expected {KEY}: between the node's name and {key.value!r}"
            )
        if key.value == KEY:
            yield owner or "/", dict(_parameters_in(path, value, ""))
        else:
            yield from _nodes_in(path, value, f"{owner}/{key.value.strip('/')}")


def _parameters_in(path: str | Path, node: Any, prefix: str) -> Iterator[tuple[str, Any]]:
    for key, value in node.value:
        name = f"{prefix}{key.value}"
        if isinstance(value, yaml.MappingNode):
            yield from _parameters_in(path, value, f"{name}.")
        elif isinstance(value, yaml.SequenceNode):
            values = [_scalar(each) for each in value.value]
            if {bool, str} <= {type(each) for each in values}:
                raise ParameterFileError(
                    path,
                    f"line {value.start_mark.line + 1}: {name}: got {values!r}, expected strings: "
                    "quote words like 'y' and 'on'",
                )
            yield name, values
        else:
            yield name, _scalar(value)


def _scalar(node: Any) -> Any:
    """Return a scalar as rcl understands it."""
    text = node.value
    if not isinstance(node, yaml.ScalarNode) or node.style:
        return text
    if text in _TRUE or text in _FALSE:
        return text in _TRUE
    if "_" in text:  # Python's numbers may have it, C's may not
        return text
    if special := _SPECIAL.fullmatch(text):
        return float(special[1] + special[2])
    for read in (_integer, float):
        try:
            return read(text)
        except ValueError:
            pass
    return text or None


def _integer(text: str) -> int:
    """Read an integer as C does: ``0x`` is hexadecimal, a leading 0 octal."""
    sign, digits = (text[:1], text[1:]) if text[:1] in ("-", "+") else ("", text)
    base = 16 if digits[:2].lower() == "0x" else 8 if digits[:1] == "0" else 10
    return int(sign + digits, base)


def _entries(parameters: Group) -> Iterator[str]:
    """Yield the lines of a group, nested as it is; of variants only what differs from it."""
    values, variants = flatten(parameters), parameters.variants()
    above: list[str] = []
    for name, descriptor in described(parameters).items():
        owner, _, shared_name = name.partition(".")
        if owner in variants and values[name] == values[shared_name]:
            continue
        *groups, last = name.split(".")
        shared = _shared(above, groups)
        for depth in range(shared, len(groups)):
            yield f"{'  ' * (depth + 2)}{groups[depth]}:"
        above = groups
        unit = f", {descriptor.unit}" if descriptor.unit else ""
        comment = f"{descriptor.text}; {descriptor.range}{unit}"
        yield f"{'  ' * (len(groups) + 2)}{last}: {_written(values[name])}  # {comment}"


def _shared(one: list[str], other: list[str]) -> int:
    for depth, (a, b) in enumerate(zip(one, other, strict=False)):
        if a != b:
            return depth
    return min(len(one), len(other))


def _written(value: Value) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, tuple):
        return f"[{', '.join(map(_written, value))}]"
    text = repr(value)
    mantissa, e, exponent = text.partition("e")
    return f"{mantissa}.0e{exponent}" if e and "." not in mantissa else text
