"""A path to one number in a message, such as ``point.x`` or ``name=pole:position``."""

from __future__ import annotations

import operator
import re
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from fuzzy_fusion_ros.core.errors import MessageError
from fuzzy_fusion_ros.messages.scalars import as_float, like
from fuzzy_fusion_ros.messages.type_names import type_name_of

_NAME = r"[A-Za-z]\w*"
_PLAIN = re.compile(rf"({_NAME})(?:\[(\d+)\])?")
_LOOK_UP = re.compile(rf"((?:{_NAME}(?:\[\d+\])?\.)*)({_NAME})=(.+):({_NAME})((?:\..+)?)")


class Step(NamedTuple):
    """One step of a path: into a field, and into an element of it where it is an array.

    Attributes:
        name: The field to enter.
        element: The index of the element of it to take, or None.
        names: The sibling array to look ``key`` up in; its index is that of the element.
        key: The name of the element, or None.
    """

    name: str
    element: int | None = None
    names: str | None = None
    key: str | None = None

    @property
    def picks(self) -> bool:
        """Whether the step takes one element of an array."""
        return self.element is not None or self.key is not None


@dataclass(frozen=True)
class FieldPath:
    """A path to one number in a message, parsed and compiled once.

    ``point.x`` goes through fields, ``position[0]`` takes an element, and
    ``name=pole:position`` takes the element of ``position`` at the index at which the array
    ``name`` beside it holds ``pole``.

    Attributes:
        text: The path as the user wrote it.
        number: The type of the number, such as ``float64``; an integer type rounds and limits
            what is written.
        steps: The path, parsed.

    Raises:
        MessageError: The text is no path.
    """

    text: str
    number: str = "float64"
    steps: tuple[Step, ...] = field(init=False, repr=False, compare=False)
    _get: Callable[[Any], Any] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        """Parse and compile ``text``."""
        steps = _parse(self.text)
        object.__setattr__(self, "steps", steps)
        object.__setattr__(self, "_get", _compile(steps))

    def __reduce__(self) -> tuple[type[FieldPath], tuple[str, str]]:
        """Pickle as the text alone; the compiled path is made anew."""
        return FieldPath, (self.text, self.number)

    def read(self, message: object) -> float:
        """Return the number, NaN and infinite ones too.

        Raises:
            MessageError: This message lacks the field or element, or it holds no number.
        """
        try:
            value = self._get(message)
        except (AttributeError, IndexError, TypeError, ValueError):
            raise MessageError(self._why_not(message)) from None
        return value if value.__class__ is float else as_float(value, self.number, self.text)

    def write(self, message: object, value: float) -> None:
        """Set the number in place; a field of an integer type takes the nearest integer.

        Args:
            message: The message to change.
            value: The new value; finite if the field is of an integer type.

        Raises:
            MessageError: This message lacks the field or element, it holds no number, or the
                value does not fit its type.
        """
        old = self.read(message)  # says what is wrong with the path
        last = self.steps[-1]
        owner = _compile(self.steps[:-1])(message)
        if not last.picks:
            current = getattr(owner, last.name)
            setattr(owner, last.name, like(current, value, self.number, self.text))
            return
        array = getattr(owner, last.name)
        index = _index(owner, last)
        if isinstance(array, bytes):  # rclpy hands out byte arrays that cannot be changed
            changed = bytearray(array)
            changed[index] = int(like(int(old), value, "uint8", self.text))
            setattr(owner, last.name, bytes(changed))
        else:
            array[index] = like(array[index], value, self.number, self.text)

    def _why_not(self, message: object) -> str:
        """Return why this message has no such number, found by walking the path slowly."""
        owner = message
        for step in self.steps:
            if not hasattr(owner, step.name):
                return f"field {self.text!r}: {type_name_of(owner)} has no field {step.name!r}"
            array = getattr(owner, step.name)
            try:
                index = _index(owner, step) if step.picks else None
            except (AttributeError, TypeError, ValueError):
                names = getattr(owner, step.names or "", None)
                return f"field {self.text!r}: {step.key!r} is not in {step.names} {names!r}"
            if index is None:
                owner = array
                continue
            try:
                owner = array[index]
            except (IndexError, TypeError):
                size = len(array) if hasattr(array, "__len__") else "no"
                return f"field {self.text!r}: {step.name} has {size} elements in this message"
        return f"field {self.text!r} cannot be read from {type_name_of(message)}"


def _parse(text: str) -> tuple[Step, ...]:
    look_up = _LOOK_UP.fullmatch(text)
    if look_up is None:
        return tuple(_parse_plain(part, text) for part in text.split("."))
    before, names, key, values, after = look_up.groups()
    return (
        *(_parse_plain(part, text) for part in before.split(".") if part),
        Step(values, names=names, key=key),
        *(_parse_plain(part, text) for part in after.split(".")[1:]),
    )


def _parse_plain(part: str, text: str) -> Step:
    match = _PLAIN.fullmatch(part)
    if match is None:
        raise MessageError(
            f"field {text!r} is no path: {part!r} is not understood; write for example "
            "'data', 'point.x', 'position[0]' or 'name=pole:position'"
        )
    return Step(match[1], element=None if match[2] is None else int(match[2]))


def _compile(steps: tuple[Step, ...]) -> Callable[[Any], Any]:
    """Return one function that follows all steps."""
    if not steps:
        return lambda message: message
    plain = next((at for at, step in enumerate(steps) if step.picks), len(steps))
    if plain == len(steps):
        return operator.attrgetter(".".join(step.name for step in steps))
    pick = _compile_pick(steps[plain])
    if plain > 0:
        pick = _chain(_compile(steps[:plain]), pick)
    rest = steps[plain + 1 :]
    return _chain(pick, _compile(rest)) if rest else pick


def _compile_pick(step: Step) -> Callable[[Any], Any]:
    values = operator.attrgetter(step.name)
    index = step.element
    if index is not None:
        return lambda owner: values(owner)[index]
    names, key = operator.attrgetter(step.names or ""), step.key
    return lambda owner: values(owner)[names(owner).index(key)]


def _chain(first: Callable[[Any], Any], then: Callable[[Any], Any]) -> Callable[[Any], Any]:
    return lambda message: then(first(message))


def _index(owner: Any, step: Step) -> int:
    if step.element is not None:
        return step.element
    return int(getattr(owner, step.names or "").index(step.key))
