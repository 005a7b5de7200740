# SPDX-License-Identifier: Apache-2.0
"""YAML is checked before it is composed."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml

from fuzzy_fusion_ros.parameters import yaml_text
from fuzzy_fusion_ros.parameters.yaml_text import YamlLimitError, checked_yaml, read_yaml_text

GOOD = (
    "",
    "a: 1",
    "a: &a [1, 2]\nb: *a\nc: {<<: {x: 1}}",
    "a: &a x\nb: *a",
    "&a a: &a b\nc: *a",
    f"{'[' * 49}{']' * 49}",
    "--- 1\n--- 2",
    "a: !!binary aGVsbG8=\nb: |\n  text",
)


@pytest.mark.parametrize("text", GOOD)
def test_what_people_write_passes(text: str) -> None:
    assert checked_yaml(text) == text


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        (f"{'[' * 51}{']' * 51}", "nests more than 50 levels deep"),
        ("[" * 100_000, "nests more than 50 levels deep"),
        ("{a: " * 100_000, "nests more than 50 levels deep"),
        ("- " * 100_000, "nests more than 50 levels deep"),
        ("? " * 100_000, "nests more than 50 levels deep"),
        (f"[{'1,' * 200_001}]", "holds more than 200000 values"),
        ("a: &a {b: [*a]}", "alias 'a' contains itself"),
        ("&a [&a [*a]]", "alias 'a' contains itself"),
        ("x" * (yaml_text.LARGEST + 1), "is longer than 4194304 characters"),
        (
            "a: &a [1, 2, 3, 4, 5, 6, 7, 8, 9, 0]\n"
            + "".join(
                f"{chr(98 + k)}: &{chr(98 + k)} [{', '.join(['*' + chr(97 + k)] * 10)}]\n"
                for k in range(5)
            ),
            "holds more than 200000 values",
        ),
    ],
)
def test_what_would_exhaust_memory_is_refused(text: str, problem: str) -> None:
    with pytest.raises(YamlLimitError, match=problem):
        checked_yaml(text)


def test_aliases_can_be_forbidden() -> None:
    assert checked_yaml("a: &a 1\nb: 2", aliases=False)
    with pytest.raises(YamlLimitError, match="it has an alias, 'a'; ROS supports none"):
        checked_yaml("a: &a 1\nb: *a", aliases=False)


@pytest.mark.parametrize("text", ["a: *unknown", "a: [", "\0", "a: b: c"])
def test_what_is_no_yaml_is_an_error_of_yaml(text: str) -> None:
    """An unknown alias is damage, which the loader reports."""
    with pytest.raises(yaml.YAMLError) as refusal:
        yaml.load(checked_yaml(text), Loader=yaml_text.LOADER)
    assert not isinstance(refusal.value, YamlLimitError)


def test_a_file_is_read_within_bounds(tmp_path: Path) -> None:
    path = tmp_path / "some.yaml"
    path.write_bytes("é: 1".encode())
    assert read_yaml_text(path) == "é: 1"
    with pytest.raises(YamlLimitError, match="larger than 4194304 bytes"):
        read_yaml_text(Path("/dev/zero"))
