# SPDX-License-Identifier: Apache-2.0
"""Where messages hold the variance of a number, and how they mark it as unknown."""

from __future__ import annotations

import struct
from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

from fuzzy_fusion_ros.messages.cdr import FORMATS, ORDERS, ORIGIN
from fuzzy_fusion_ros.messages.field_path import Field, FieldPath, call_in
from fuzzy_fusion_ros.messages.layout import Layout
from fuzzy_fusion_ros.messages.resolve import resolve_field
from fuzzy_fusion_ros.messages.type_fields import FieldType, TypeDescriptions
from fuzzy_fusion_ros.parameters.errors import MessageError

NO_INFORMATION = 1e6
"""Variance of what is not known, in types without a convention (pose, twist and acceleration with
covariance): filters give it no weight, where 0 would count as certain."""

_AXES = {"x": 0, "y": 1, "z": 2, "roll": 0, "pitch": 1, "yaw": 2}
_GROUPS = {"position": 0, "linear": 0, "orientation": 3, "angular": 3}
_EARTH = {"longitude": 0, "latitude": 1, "altitude": 2}


class Variance(NamedTuple):
    """The variance of a number in a message.

    Attributes:
        path: Where it is; empty if the number has one of several.
        unknown: What a message holds where it is not known, by path: the variance itself and
            its covariances with other numbers.
        known: What it holds besides the variance where that is known: no covariances of it.
    """

    path: str
    unknown: Mapping[str, float]
    known: Mapping[str, float]


NONE = Variance("", {}, {})
"""Of a number whose type has no variance."""


def variance_of(types: TypeDescriptions, type_name: str, field: Field) -> Variance:
    """Return where the variance of a field is in its messages.

    Args:
        types: Who describes message types.
        type_name: ``package/msg/Type``.
        field: Of that type.
    """
    call = call_in(field.text)
    *above_it, last = field.paths[0].parts
    if any(part.key is not None for part in above_it):
        return NONE
    owners = [
        part.name if part.element is None else f"{part.name}[{part.element}]" for part in above_it
    ]
    owner, member = ".".join(owners), last.name
    axis = member
    if call is not None and len(field.paths) > 1:  # an angle of a vector is made of all its axes
        axis = call.name if len(field.paths) == len("xyzw") else ""
    above, _, group = owner.rpartition(".")
    here = _fields(types, type_name, owners)
    if _is_number(here.get("variance")):
        name = _joined(owner, "variance")
        return Variance(name, {name: 0.0}, {})
    if member in _EARTH and _has(here, "position_covariance", 9):
        kind = {_joined(owner, "position_covariance_type"): 0.0}
        return _matrix(_joined(owner, "position_covariance"), 3, _EARTH[member], 0.0, kind)
    siblings = _fields(types, type_name, owners[:-1]) if owners else {}
    if _has(siblings, f"{group}_covariance", 9):
        matrix = _joined(above, f"{group}_covariance")
        if axis in _AXES:
            return _matrix(matrix, 3, _AXES[axis], 0.0)
        return _of_all(_all(matrix, 9))
    over = _fields(types, type_name, owners[:-2]) if len(owners) > 1 else {}
    if group in _GROUPS and _has(over, "covariance", 36):
        matrix = _joined(".".join(owners[:-2]), "covariance")
        first = _GROUPS[group]
        if axis in _AXES:
            return _matrix(matrix, 6, first + _AXES[axis], NO_INFORMATION)
        rows = [_matrix(matrix, 6, first + k, NO_INFORMATION).unknown for k in range(3)]
        return _of_all({path: value for row in rows for path, value in row.items()})
    return NONE


def _fields(
    types: TypeDescriptions, type_name: str, owners: Iterable[str]
) -> Mapping[str, FieldType]:
    for owner in owners:
        type_name = types.fields(type_name)[FieldPath(owner).parts[0].name].name
    return types.fields(type_name)


def _is_number(field: FieldType | None) -> bool:
    return field is not None and field.is_number and not field.is_array


def _has(fields: Mapping[str, FieldType], name: str, size: int) -> bool:
    field = fields.get(name)
    return field is not None and field.is_fixed and field.is_number and field.capacity == size


def _joined(owner: str, name: str) -> str:
    return f"{owner}.{name}" if owner else name


def _all(matrix: str, size: int) -> dict[str, float]:
    return {f"{matrix}[{k}]": 0.0 for k in range(size)}


def _of_all(unknown: Mapping[str, float]) -> Variance:
    """Return the variance of a number that is made of several: none of theirs is its own."""
    return Variance("", unknown, unknown)


def _matrix(
    matrix: str, order: int, row: int, unknown: float, more: Mapping[str, float] | None = None
) -> Variance:
    """Return a variance on the diagonal of a square matrix by rows.

    Args:
        matrix: Its path.
        order: Its rows.
        row: That of the number.
        unknown: A variance that is not known. If it is 0, all others have to be 0, too: only
            then it means that.
        more: What else says that it is not known.
    """
    path = f"{matrix}[{row * (order + 1)}]"
    across = {f"{matrix}[{row * order + k}]": 0.0 for k in range(order) if k != row}
    down = {f"{matrix}[{k * order + row}]": 0.0 for k in range(order) if k != row}
    known = {**across, **down}
    if unknown == 0.0:
        return Variance(path, {**_all(matrix, order * order), **(more or {})}, known)
    return Variance(path, {**known, path: unknown}, known)


class Elements:
    """Numbers of a type's messages, to be overwritten."""

    def __init__(self, types: TypeDescriptions, type_name: str, paths: Sequence[str]) -> None:
        """Find out where they lie.

        Args:
            types: Who describes message types.
            type_name: ``package/msg/Type``.
            paths: To the numbers.

        Raises:
            MessageError: A path does not lead to a number.
        """
        found = [path for each in paths for path in resolve_field(types, type_name, each).paths]
        self._walks = {
            begin: [
                (order + FORMATS[path.number], Layout(types, order).place(type_name, path))
                for path in found
            ]
            for begin, order in ORDERS.items()
        }

    def places(self, data: bytes) -> list[tuple[str, int]]:
        """Return of each number its form, as :mod:`struct` writes it, and where it begins.

        Args:
            data: A message that can be read.

        Raises:
            MessageError: It lacks an element.
        """
        return [(form, walk(data, ORIGIN)) for form, walk in self._walks[data[:2]]]

    def written(self, data: bytes, values: Iterable[float]) -> bytes:
        """Return a message with other numbers.

        Args:
            data: A message that can be read.
            values: The numbers, in the order of their paths.

        Raises:
            MessageError: It lacks an element, or a number does not fit into its type.
        """
        changed = bytearray(data)
        for (form, at), value in zip(self.places(data), values, strict=True):
            try:
                struct.pack_into(form, changed, at, value if form[1] in "fd" else int(value))
            except (struct.error, OverflowError) as error:
                raise MessageError(f"variance {value!r} does not fit: {error}") from None
        return bytes(changed)
