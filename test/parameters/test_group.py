# SPDX-License-Identifier: Apache-2.0
"""The machinery under the parameters, on a small tree of its own."""

from __future__ import annotations

import dataclasses
import math
import pickle
from dataclasses import dataclass

import numpy as np
import pytest

from fuzzy_fusion_ros.parameters.errors import ParameterError
from fuzzy_fusion_ros.parameters.group import (
    Descriptor,
    Group,
    descriptors,
    flatten,
    group,
    integer,
    numbers,
    numbers_with,
    real,
    replace,
    switch,
    text,
)


@dataclass(frozen=True)
class Span(Group):
    """Two numbers that must rise."""

    start: float = real(0.0, "where it starts", unit="m", low=-10.0, high=10.0)
    end: float = real(1.0, "where it ends", unit="m", low=-10.0, high=10.0)

    def check_together(self) -> None:
        if self.start >= self.end:
            raise ParameterError("start", f"got {self.start!r}, expected less than {self.end!r}")


@dataclass(frozen=True)
class Spans(Group):
    """Groups in a group."""

    first: Span = group(Span())
    second: Span = group(Span(2.0, 3.0))
    closed: bool = switch(True, "whether the ends belong to it")


@dataclass(frozen=True)
class Settings(Group):
    """One of everything."""

    name: str = text("pole", "what it is called")
    kind: str = text("a", "what it is", choices=("a", "b"))
    count: int = integer(3, "how many", low=1, high=9)
    depth: int = integer(1, "how deep", low=0, high=4, fixed=True)
    spans: Spans = group(Spans())


FLAT = {
    "name": "pole",
    "kind": "a",
    "count": 3,
    "depth": 1,
    "spans.first.start": 0.0,
    "spans.first.end": 1.0,
    "spans.second.start": 2.0,
    "spans.second.end": 3.0,
    "spans.closed": True,
}


def test_flatten_names_every_parameter_in_order() -> None:
    assert list(flatten(Settings()).items()) == list(FLAT.items())


def test_descriptors_tell_every_parameter_and_its_default_in_order() -> None:
    told = list(descriptors(Settings))
    assert [(name, default) for name, _, default in told] == list(FLAT.items())
    by_name = {name: descriptor for name, descriptor, _ in told}
    assert by_name["count"] == Descriptor(int, "how many", "", 1, 9)
    assert by_name["spans.second.end"] == Descriptor(float, "where it ends", "m", -10.0, 10.0)
    assert by_name["spans.closed"] == Descriptor(bool, "whether the ends belong to it")


def test_descriptors_carry_a_prefix() -> None:
    assert [name for name, _, _ in descriptors(Span, "s.")] == ["s.start", "s.end"]


def test_texts_are_fixed_and_numbers_are_not_unless_said() -> None:
    fixed = {name: descriptor.fixed for name, descriptor, _ in descriptors(Settings)}
    assert [name for name in fixed if fixed[name]] == ["name", "kind", "depth"]


@pytest.mark.parametrize(
    ("descriptor", "said"),
    [
        (Descriptor(bool, ""), "true or false"),
        (Descriptor(str, ""), "a string"),
        (Descriptor(str, "", choices=("a", "b")), "one of a, b"),
        (Descriptor(int, "", low=1, high=9), "an integer from 1 to 9"),
        (Descriptor(float, "", low=0.0, high=1e9), "a number from 0 to 1e+09"),
    ],
)
def test_a_range_is_said_in_words(descriptor: Descriptor, said: str) -> None:
    assert descriptor.range == said


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("name", ""),
        ("kind", "b"),
        ("count", 1),
        ("count", 9),
        ("spans.first.start", -10.0),
        ("spans.second.end", 10.0),
        ("spans.closed", False),
    ],
)
def test_what_is_allowed_is_taken(name: str, value: object) -> None:
    assert flatten(replace(Settings(), {name: value})) == {**FLAT, name: value}


@pytest.mark.parametrize(
    ("name", "value", "problem"),
    [
        ("name", 5, "got 5, expected a string"),
        ("name", None, "got None, expected a string"),
        ("kind", "c", "got 'c', expected one of a, b"),
        ("kind", "", "got '', expected one of a, b"),
        ("count", 0, "got 0, expected an integer from 1 to 9"),
        ("count", 10, "got 10, expected an integer from 1 to 9"),
        ("count", 3.0, "got 3.0, expected an integer from 1 to 9"),
        ("count", True, "got True, expected an integer from 1 to 9"),
        ("count", "3", "got '3', expected an integer from 1 to 9"),
        ("count", 10**400, "got 1000"),
        ("spans.closed", 1, "got 1, expected true or false"),
        ("spans.closed", "true", "got 'true', expected true or false"),
        ("spans.first.start", True, r"got True, expected a number from -10 to 10 \(m\)"),
        ("spans.first.start", "0", r"got '0', expected a number from -10 to 10 \(m\)"),
        ("spans.first.start", math.nan, r"got nan, expected a number from -10 to 10 \(m\)"),
        ("spans.first.start", -math.inf, "got -inf, expected a number"),
        ("spans.second.end", math.inf, "got inf, expected a number"),
        ("spans.second.end", math.nextafter(10.0, 11.0), "got 10.000000000000002, expected"),
        ("spans.second.end", 11, "got 11, expected a number from -10 to 10"),
        ("spans.second.end", 10**400, "got 1000"),
        ("spans.first.start", 1.0, r"got 1.0, expected less than 1.0"),
        ("spans.second.start", np.float64(2.5), "got np.float64|got 2.5"),
    ],
)
def test_what_is_not_allowed_is_named_with_its_range(
    name: str, value: object, problem: str
) -> None:
    named = name if "less than" not in problem else "spans.first.start"
    with pytest.raises(ParameterError, match=rf"^parameter {named}: {problem}"):
        replace(Settings(), {name: value})


def test_an_integer_is_taken_for_a_number_and_becomes_one() -> None:
    changed = replace(Settings(), {"spans.first.start": -1})
    assert type(changed.spans.first.start) is float
    assert changed.spans.first.start == -1.0


@pytest.mark.parametrize(
    "name", ["nothing", "name.x", "spans", "spans.third", "spans.first", "spans.first.start.x", ""]
)
def test_an_unknown_name_is_answered_with_those_known(name: str) -> None:
    with pytest.raises(ParameterError, match=rf"^parameter {name}: unknown; expected one of .*\w"):
        replace(Settings(), {name: 1.0})


def test_a_combination_is_checked_when_all_changes_are_in() -> None:
    changes = {"spans.first.start": 5.0, "spans.first.end": 6.0}
    assert replace(Settings(), changes).spans.first == Span(5.0, 6.0)


@pytest.mark.parametrize(
    "changes",
    [
        {"count": 5, "spans.first.start": 50.0},
        {"spans.second.end": 2.0, "name": "rod"},
        {"spans.closed": False, "unknown": 1},
    ],
)
def test_one_bad_change_leaves_everything_as_it_was(changes: dict[str, object]) -> None:
    before = Settings()
    with pytest.raises(ParameterError, match=r"^parameter "):
        replace(before, changes)
    assert flatten(before) == FLAT


def test_replacing_by_what_is_there_changes_nothing() -> None:
    changed = replace(Settings(), {"spans.first.end": 0.5, "kind": "b"})
    assert replace(Settings(), flatten(changed)) == changed
    assert replace(changed, {}) == changed


def test_construction_is_checked_like_a_change() -> None:
    with pytest.raises(ParameterError, match=r"^parameter start: got 2.0, expected less than 1.0"):
        Span(2.0, 1.0)
    with pytest.raises(ParameterError, match=r"^parameter count: got 0"):
        Settings(count=0)
    assert type(Span(0, 1).end) is float


def test_a_group_cannot_be_changed() -> None:
    with pytest.raises(dataclasses.FrozenInstanceError):
        Span().start = 1.0  # type: ignore[misc]


def test_numbers_have_the_attributes_of_the_group_less_its_texts() -> None:
    plain = numbers(Settings())
    assert plain._fields == ("count", "depth", "spans")
    assert plain.spans.second.end == 3.0
    assert plain.spans.closed is True
    assert not hasattr(plain, "name")


def test_numbers_are_changed_as_the_group_is() -> None:
    changes = {"count": 5.0, "spans.first.end": 4, "spans.second.end": 7.0}
    changed = numbers_with(numbers(Settings()), changes)
    assert changed == numbers(replace(Settings(), {**changes, "count": 5}))
    assert [type(each) for each in (changed.count, changed.spans.first.end)] == [int, float]
    assert numbers(changed) is changed


def test_numbers_of_equal_groups_are_of_one_type_and_can_be_pickled() -> None:
    one, other = numbers(Settings()), numbers(Settings(count=4))
    assert type(one) is type(other)
    assert pickle.loads(pickle.dumps(one)) == one
