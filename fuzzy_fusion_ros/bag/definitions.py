# SPDX-License-Identifier: Apache-2.0
"""Parses definitions of message types, within bounds that no definition of a recorder exceeds.

The parsers are rosbags'. They take exponential time for some texts (parentheses in a constant of
IDL) and quadratic time for others (blank lines), so what they need not see is removed first.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import lru_cache
from typing import Any

from rosbags.interfaces import Nodetype
from rosbags.typesys import TypesysError, get_types_from_idl, get_types_from_msg

from fuzzy_fusion_ros.bag.installed import SEPARATOR
from fuzzy_fusion_ros.bag.topic import IDL_ENCODINGS, MSG_ENCODINGS, Definition
from fuzzy_fusion_ros.messages.type_fields import FieldType

LARGEST = 256 * 1024
"""Characters of a definition without its comments; those of large real types are a tenth of it."""

_MOST_KEPT, _KEPT = 16 * 1024, 64
"""Characters of a definition that is parsed once for all bags, and how many of these are kept."""

Types = Mapping[str, Mapping[str, FieldType]]
"""The fields of types, by name."""

MOST_CONSTANTS = 1000
"""Constants of a definition in IDL."""

UNPARSED = (
    TypesysError,
    ArithmeticError,
    AssertionError,
    AttributeError,
    LookupError,
    RecursionError,
    TypeError,
    ValueError,
)
"""What :func:`parse` raises on text that is no definition, or is out of bounds."""

_MSG_BLANK = re.compile(r"^[ \t\r]*(?:#.*)?\n", re.MULTILINE)
_IDL_HEAD = re.compile(r"\AIDL: .*$|^[ \t]*#.*$", re.MULTILINE)
_IDL_QUOTED = re.compile(r"\"(?:\\.|[^\"\\\n])*\"|//[^\n]*|/\*.*?\*/", re.DOTALL)
_IDL_ANNOTATION = re.compile(r"@[\w:]+(?:\s*\([^()]*\))?")
_IDL_EXPRESSION = re.compile(r"\(|<<|<[^<>]*<[^<>]*<[^<>]*<")
_IDL_CONSTANT = re.compile(r"\bconst\b")


def parse(msgtype: str, definition: Definition) -> Types:
    """Return the fields of every type in a definition, by the type's name.

    Bags of one robot have the same definitions: they are parsed once.

    Args:
        msgtype: The type that is defined, ``package/msg/Type``.
        definition: Its definition, followed by those of its nested types.

    Raises:
        One of ``UNPARSED``: The text is no definition, or out of bounds.
    """
    is_usual = len(definition.text) <= _MOST_KEPT
    return _parsed(msgtype, definition) if is_usual else _parse(msgtype, definition)


def _parse(msgtype: str, definition: Definition) -> Types:
    if definition.encoding in MSG_ENCODINGS:
        text = _bounded(_MSG_BLANK.sub("", definition.text))
        return _fields(get_types_from_msg(text, msgtype))
    if definition.encoding not in IDL_ENCODINGS:
        raise TypesysError(f"encoding {definition.encoding!r} is neither ros2msg nor ros2idl")
    parts = [_plain_idl(part) for part in definition.text.split(SEPARATOR)]
    whole = _bounded("".join(parts))
    if len(_IDL_CONSTANT.findall(whole)) > MOST_CONSTANTS:
        raise TypesysError(f"it has more than {MOST_CONSTANTS} constants")
    found: dict[str, Mapping[str, FieldType]] = {}
    for part in parts:
        if part.strip():
            found.update(_fields(get_types_from_idl(part)))
    return found


_parsed = lru_cache(maxsize=_KEPT)(_parse)


def _plain_idl(part: str) -> str:
    """Return IDL without comments, texts, annotations and lines for a preprocessor."""
    text = _IDL_QUOTED.sub(_emptied, _IDL_HEAD.sub("", part))
    text = _IDL_ANNOTATION.sub(" ", text)
    if _IDL_EXPRESSION.search(text):
        raise TypesysError("parentheses, shifts and nested sequences are not supported")
    return text


def _emptied(match: re.Match[str]) -> str:
    return '""' if match[0].startswith('"') else " "


def _bounded(text: str) -> str:
    if len(text) > LARGEST:
        raise TypesysError(f"it has {len(text)} characters, at most {LARGEST} are read")
    return text


def _fields(types: Any) -> Types:
    return {name: field_types(each) for name, each in types.items()}


def field_types(described: Any) -> dict[str, FieldType]:
    """Return the fields of a type that rosbags describes."""
    _, fields = described
    return {name: _field_type(each) for name, each in fields}


def _field_type(described: Any) -> FieldType:
    kind, what = described
    if kind == Nodetype.NAME:
        return FieldType(what)
    if kind == Nodetype.BASE:
        name = what[0]
        return FieldType("uint8" if name in {"byte", "char"} else name)
    element, size = what
    return FieldType(_field_type(element).name, True, size or None, kind == Nodetype.ARRAY)
