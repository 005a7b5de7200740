# SPDX-License-Identifier: Apache-2.0
"""Machinery under the parameters: described, checked, immutable, and one flat map away.

A group of parameters is a frozen dataclass derived from :class:`Group`; its fields are made with
:func:`real`, :func:`integer`, :func:`switch`, :func:`text`, :func:`names` or :func:`group`. The
one definition gives the node its descriptors, the YAML its names, the docs their table and the
method its numbers.
"""

from __future__ import annotations

import dataclasses
import functools
import math
from collections import namedtuple
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, TypeVar, cast

from fuzzy_fusion_ros.parameters.errors import ParameterError

Value = bool | int | float | str | tuple[str, ...]
"""What a single parameter can hold."""


@dataclass(frozen=True)
class Descriptor:
    """What a parameter means and may hold.

    Attributes:
        kind: The Python type of the value: ``bool``, ``int``, ``float``, ``str`` or ``tuple``, of
            texts.
        text: Its meaning in one sentence.
        unit: The unit, ``""`` for none; ``signal`` is the unit of S1 and S2.
        low: Smallest allowed number, inclusive.
        high: Largest allowed number, inclusive.
        choices: The allowed texts, empty for any.
        fixed: Whether the value is read at start-up only.
    """

    kind: type
    text: str
    unit: str = ""
    low: float = -math.inf
    high: float = math.inf
    choices: tuple[str, ...] = ()
    fixed: bool = False

    @property
    def range(self) -> str:
        """Allowed values in words, as in the docs and in every error."""
        if self.kind is bool:
            return "true or false"
        if self.choices:
            return "one of " + ", ".join(self.choices)
        if self.kind is str:
            return "a string"
        if self.kind is tuple:
            return "a list of strings"
        noun = "an integer" if self.kind is int else "a number"
        return f"{noun} from {self.low:g} to {self.high:g}"

    def check(self, name: str, value: object) -> Value:
        """Return ``value`` as this parameter's type.

        An integer is accepted where a number is expected, and any list of strings, which ROS leaves
        unset if it is empty; nothing else is converted.

        Raises:
            ParameterError: Wrong type, not finite, out of range or not among the choices.
        """
        if self.kind is tuple and (value is None or isinstance(value, list)):
            value = tuple(value or ())
        fits = type(value) is self.kind or (self.kind is float and type(value) is int)
        if fits and isinstance(value, int | float) and self.kind is not bool:
            fits = self.low <= value <= self.high
        if fits and isinstance(value, str) and self.choices:
            fits = value in self.choices
        if fits and isinstance(value, tuple):
            fits = all(isinstance(each, str) for each in value)
        if not fits:
            unit = f" ({self.unit})" if self.unit else ""
            raise ParameterError(name, f"got {value!r}, expected {self.range}{unit}")
        checked = cast(Value, value)
        return float(checked) if self.kind is float and isinstance(checked, int) else checked


def real(
    default: float,
    text: str,
    *,
    unit: str = "",
    low: float = 0.0,
    high: float = 1e9,
    fixed: bool = False,
) -> Any:
    """Make a field that holds a finite number."""
    return _field(default, Descriptor(float, text, unit, low, high, fixed=fixed))


def integer(default: int, text: str, *, low: int, high: int, fixed: bool = False) -> Any:
    """Make a field that holds an integer."""
    return _field(default, Descriptor(int, text, "", low, high, fixed=fixed))


def switch(default: bool, text: str, *, fixed: bool = False) -> Any:
    """Make a field that holds a yes or no."""
    return _field(default, Descriptor(bool, text, fixed=fixed))


def text(default: str, meaning: str, *, choices: tuple[str, ...] = ()) -> Any:
    """Make a field that holds a text; texts name types and topics and are read at start-up."""
    return _field(default, Descriptor(str, meaning, choices=choices, fixed=True))


def names(meaning: str) -> Any:
    """Make a field that holds names of further parameters; none by default, read at start-up."""
    return _field((), Descriptor(tuple, meaning, fixed=True))


def group(default: Group) -> Any:
    """Make a field that holds a group of parameters."""
    return dataclasses.field(default=default)


def _field(default: Value, descriptor: Descriptor) -> Any:
    return dataclasses.field(default=default, metadata={"descriptor": descriptor})


@dataclass(frozen=True)
class Group:
    """A frozen, checked group of parameters; groups nest.

    Raises:
        ParameterError: On construction, when a value or a combination is not allowed.
    """

    DERIVED: ClassVar[tuple[str, ...]] = ()
    """Properties that are numbers or switches and follow from a text."""

    def __post_init__(self) -> None:
        for field in dataclasses.fields(self):
            if "descriptor" in field.metadata:
                value = field.metadata["descriptor"].check(field.name, getattr(self, field.name))
                object.__setattr__(self, field.name, value)
        self.check_together()

    def check_together(self) -> None:
        """Check what no single value can show.

        Raises:
            CombinationError: The combination is not allowed.
        """

    def variants(self) -> Mapping[str, Group]:
        """Return the groups whose names are values of this one, such as those of channels."""
        return {}

    def gathered(self, changes: Mapping[str, object]) -> Mapping[str, object]:
        """Return changes with those of variants gathered in the field that holds them.

        Raises:
            ParameterError: A change of a variant is not allowed.
        """
        return changes


G = TypeVar("G", bound=Group)


def descriptors(kind: type[Group], prefix: str = "") -> Iterator[tuple[str, Descriptor, Value]]:
    """Yield dotted name, descriptor and default of every parameter of a group, in order."""
    for field in dataclasses.fields(kind):
        name = prefix + field.name
        if isinstance(field.default, Group):
            yield from _nested_descriptors(field.default, name + ".")
        elif "descriptor" in field.metadata:
            yield name, field.metadata["descriptor"], cast(Value, field.default)


def _nested_descriptors(default: Group, prefix: str) -> Iterator[tuple[str, Descriptor, Value]]:
    values = flatten(default)
    for name, descriptor, _ in descriptors(type(default)):
        yield prefix + name, descriptor, values[name]


def described(parameters: Group) -> dict[str, Descriptor]:
    """Return the descriptor of every parameter, those of variants included, by dotted name."""
    found = {name: each for name, each, _ in descriptors(type(parameters))}
    for owner, variant in parameters.variants().items():
        found |= {f"{owner}.{name}": each for name, each, _ in descriptors(type(variant))}
    return found


def flatten(parameters: Group) -> dict[str, Value]:
    """Return every parameter by its dotted name, in order of definition, variants last."""
    flat: dict[str, Value] = {}
    for field in dataclasses.fields(parameters):
        value = getattr(parameters, field.name)
        if isinstance(value, Group):
            flat.update({f"{field.name}.{name}": v for name, v in flatten(value).items()})
        elif "descriptor" in field.metadata:
            flat[field.name] = value
    for owner, variant in parameters.variants().items():
        flat.update({f"{owner}.{name}": v for name, v in flatten(variant).items()})
    return flat


def shaped(parameters: G, changes: Mapping[str, object]) -> G:
    """Return ``parameters`` with those changes only that name further parameters.

    Raises:
        ParameterError: They are not allowed.
    """
    lists = {name for name, each, _ in descriptors(type(parameters)) if each.kind is tuple}
    return replace(parameters, {name: changes[name] for name in lists & changes.keys()})


def replace(parameters: G, changes: Mapping[str, object]) -> G:
    """Return ``parameters`` with the values at dotted names changed, all or none.

    Raises:
        ParameterError: A name is unknown, or a value or the combination is not allowed.
    """
    known = {
        field.name: getattr(parameters, field.name) for field in dataclasses.fields(parameters)
    }
    own: dict[str, Any] = {}
    nested: dict[str, dict[str, object]] = {}
    for name, value in parameters.gathered(changes).items():
        head, dot, rest = name.partition(".")
        if head not in known or isinstance(known[head], Group) != bool(dot):
            raise ParameterError(name, f"unknown; expected one of {', '.join(flatten(parameters))}")
        if dot:
            nested.setdefault(head, {})[rest] = value
        else:
            own[head] = value
    for head, inner in nested.items():
        try:
            own[head] = replace(known[head], inner)
        except ParameterError as error:
            raise error.under(head) from None
    return dataclasses.replace(parameters, **own)


def allowed(kind: type[Group], values: Mapping[str, float]) -> dict[str, float]:
    """Return values by dotted name, each moved to the nearest that the group allows."""
    return within({name: descriptor for name, descriptor, _ in descriptors(kind)}, values)


def within(limits: Mapping[str, Descriptor], values: Mapping[str, float]) -> dict[str, float]:
    """Return values by name, each moved to the nearest that its descriptor allows."""
    return {
        name: min(max(value, limits[name].low), limits[name].high) for name, value in values.items()
    }


def numbers(parameters: Group | tuple[Any, ...]) -> Any:
    """Return the numbers and switches of a group as a nested named tuple.

    Attribute access is the same as on the group, so a function takes either; a named tuple is
    what the compiler understands. Texts and names are left out, but for what ``DERIVED`` names.

    Args:
        parameters: The group; its numbers are returned as they are.
    """
    if not isinstance(parameters, Group):
        return parameters
    values = {
        field.name: getattr(parameters, field.name)
        for field in dataclasses.fields(parameters)
        if not isinstance(getattr(parameters, field.name), str | tuple)
    }
    values |= {name: getattr(parameters, name) for name in parameters.DERIVED}
    tuple_type = _tuple_type(type(parameters).__name__, tuple(values))
    return tuple_type(
        *(numbers(value) if isinstance(value, Group) else value for value in values.values())
    )


def numbers_with(given: Any, changes: Mapping[str, float]) -> Any:
    """Return the numbers of a group with the values at dotted names changed, and nothing checked.

    For fits, which take thousands of runs: :func:`replace` checks every parameter, which takes as
    long as a run over a thousand samples.

    Args:
        given: As from :func:`numbers`.
        changes: Values within what the group allows.
    """
    own: dict[str, Any] = {}
    nested: dict[str, dict[str, float]] = {}
    for name, value in changes.items():
        head, dot, rest = name.partition(".")
        if dot:
            nested.setdefault(head, {})[rest] = value
        else:
            own[head] = type(getattr(given, head))(value)
    for head, inner in nested.items():
        own[head] = numbers_with(getattr(given, head), inner)
    return given._replace(**own)


@functools.cache
def _tuple_type(name: str, fields: tuple[str, ...]) -> Any:
    make: Any = namedtuple
    tuple_type = make(name + "Numbers", fields, module=__name__)
    globals()[tuple_type.__name__] = tuple_type  # importable, so compiled code can be kept
    return tuple_type
