# SPDX-License-Identifier: Apache-2.0
"""Field paths, as they are written."""

from __future__ import annotations

import pickle

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fuzzy_fusion_ros.messages import FieldPath
from fuzzy_fusion_ros.messages.field_path import PathPart
from fuzzy_fusion_ros.parameters.errors import MessageError


@pytest.mark.parametrize(
    ("text", "parts"),
    [
        ("data", [PathPart("data")]),
        ("point.x", [PathPart("point"), PathPart("x")]),
        ("position[0]", [PathPart("position", element=0)]),
        ("position[007]", [PathPart("position", element=7)]),
        ("a.b[2].c", [PathPart("a"), PathPart("b", element=2), PathPart("c")]),
        ("name=pole:position", [PathPart("position", names="name", key="pole")]),
        ("a.name=pole:position", [PathPart("a"), PathPart("position", names="name", key="pole")]),
        (
            "a[1].n=k:v.x",
            [PathPart("a", element=1), PathPart("v", names="n", key="k"), PathPart("x")],
        ),
        ("name=arm.joint/1:position", [PathPart("position", names="name", key="arm.joint/1")]),
        ("name=a:b:position", [PathPart("position", names="name", key="a:b")]),
        ("name=x=y:position", [PathPart("position", names="name", key="x=y")]),
        ("name= :position", [PathPart("position", names="name", key=" ")]),
    ],
)
def test_a_path_is_parsed_into_its_steps(text: str, parts: list[PathPart]) -> None:
    assert FieldPath(text).parts == tuple(parts)


@pytest.mark.parametrize(
    "text",
    [
        "",
        ".",
        "point.",
        ".x",
        "point..x",
        "position[-1]",
        "position[]",
        "position[a]",
        "position[1",
        "position[1][2]",
        "position[1.0]",
        "0",
        "_private",
        "point x",
        "name=pole",
        "name=:position",
        "=pole:position",
        "name=pole:position[0]",
        "point()",
    ],
)
def test_what_is_no_path_is_refused_with_examples(text: str) -> None:
    with pytest.raises(MessageError, match=r"cannot be parsed; for example 'data'"):
        FieldPath(text)


@given(st.text())
def test_any_text_is_a_path_or_refused(text: str) -> None:
    try:
        path = FieldPath(text)
    except MessageError:
        return
    assert path.parts


def test_paths_are_equal_by_text_and_survive_pickling() -> None:
    path = FieldPath("name=pole:position", "float32")
    again = pickle.loads(pickle.dumps(path))
    assert again == path
    assert again != FieldPath("name=pole:position")
    assert hash(again) == hash(path)
    assert again.parts == path.parts
