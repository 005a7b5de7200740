# SPDX-License-Identifier: Apache-2.0
"""The messages that come out: the estimate, and what stands behind it, serialised."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from itertools import combinations
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fuzzy_fusion_ros.core.aggregator import FiringStrengths
from fuzzy_fusion_ros.core.estimator import Estimate
from fuzzy_fusion_ros.messages.cdr import CdrWriter
from fuzzy_fusion_ros.messages.codec import ScalarCodec, Template
from fuzzy_fusion_ros.messages.defaults import default_message
from fuzzy_fusion_ros.messages.field_path import call_in
from fuzzy_fusion_ros.messages.functions import Angles
from fuzzy_fusion_ros.messages.rows import Rows, filled, fills, put, put_same, repeated
from fuzzy_fusion_ros.messages.type_fields import TypeDescriptions
from fuzzy_fusion_ros.messages.type_names import normalise_type_name
from fuzzy_fusion_ros.messages.variances import Elements, variance_of
from fuzzy_fusion_ros.online.verdict import Fused, Together
from fuzzy_fusion_ros.parameters.errors import MessageError
from fuzzy_fusion_ros.parameters.fusion import EstimateParameters

TEXT = "std_msgs/msg/String"
POINT = "geometry_msgs/msg/PointStamped"
JOINTS = "sensor_msgs/msg/JointState"
"""The one stock type with a stamp, names and numbers; plotting tools show them by their names."""

RULES = tuple(f"difference_{d}_rate_{r}" for d in ("small", "large") for r in ("small", "large"))
"""Names of Table 1's rules in its order, as published with their firing strengths."""

DEVIATION = "standard_deviation"
STRENGTHS = "firing_strengths"
EXPLANATION = {
    **dict.fromkeys(("weight", "drift", "aggregate", "prediction", "innovation", DEVIATION), POINT),
    STRENGTHS: JOINTS,
}
"""The topics below the node's own name, and their types."""

ANGLES = set(Angles._fields)
"""Functions that replace one angle of an orientation and keep the others."""

SENTENCE = "explanation"
"""The topic that explains estimates in words. Not recorded: ``explain`` gives it for any bag."""


def point_template(types: TypeDescriptions, frame: str = "") -> Template:
    """Return a stamped scalar, in ``point.x``, to be filled.

    Args:
        types: Who describes message types.
        frame: Its ``frame_id``.
    """
    return ScalarCodec(types, POINT).template(default_message(types, POINT, frame))


def explain(point: Template, fused: Fused) -> Iterator[tuple[str, bytes]]:
    """Yield what stands behind an estimate: topic and message, one by one.

    Args:
        point: What :func:`point_template` returns.
        fused: The estimate. Without a prediction its two topics are silent, and so is the standard
            deviation while nothing is known of it.
    """
    for name, value in scalars(fused.estimate).items():
        yield name, point.filled(value, fused.stamp_ns)
    yield STRENGTHS, strengths_message(fused.estimate.aggregate.strengths, fused.stamp_ns)


def scalars(estimate: Estimate) -> dict[str, float]:
    """Return the numbers behind an estimate by their topics' names."""
    aggregate, prediction = estimate.aggregate, estimate.prediction
    known = {"weight": aggregate.weight, "drift": aggregate.drift, "aggregate": aggregate.value}
    if prediction.exists:
        known["prediction"] = prediction.value
        known["innovation"] = aggregate.value - prediction.value
    if estimate.standard_deviation > 0.0:
        known[DEVIATION] = estimate.standard_deviation
    return known


def strengths_message(strengths: FiringStrengths, stamp_ns: int) -> bytes:
    """Return the firing strengths by the names in ``RULES``, as positions of a JointState.

    Args:
        strengths: The strengths.
        stamp_ns: Stamp of the estimate, nanoseconds.
    """
    message = CdrWriter().stamp(stamp_ns).text("").count(len(RULES))
    for name in RULES:
        message.text(name)
    message.count(len(strengths))
    for strength in strengths:
        message.number("float64", strength)
    return message.count(0).count(0).done()  # neither velocities nor efforts


def text_message(text: str) -> bytes:
    """Return a text as a ``std_msgs/msg/String``."""
    return CdrWriter().text(text).done()


class EstimateSource(NamedTuple):
    """What the estimates of a channel are made from.

    Attributes:
        parameters: Type and field where they are not S2's.
        s2: Reads S2.
    """

    parameters: EstimateParameters
    s2: ScalarCodec


class EstimateMessages:
    """Makes messages of estimates: S2's latest with other numbers and stamp, or of another type.

    Never with S2's variance: ours where a field for it is named and it is known, else *unknown*.
    Where ours is in a matrix, S2's variances of other numbers stay, without covariances of ours.

    Attributes:
        type_name: Their type.
        codecs: Where the estimate of each channel is in them.
        makes_rows: Whether :meth:`rows` can make them, unless a message stands in its way.
        lacking: Messages made without the estimate of a channel, by its name.
    """

    def __init__(self, types: TypeDescriptions, sources: Mapping[str, EstimateSource]) -> None:
        """Settle type and fields.

        Args:
            types: Who describes message types.
            sources: What the estimates are made from, by channel; one without a name is alone.

        Raises:
            MessageError: The type is unknown or has no such fields, a field is a function that
                cannot be inverted, or two channels do not fit into one message.
        """
        self._types = types
        self._s2 = {name: each.s2 for name, each in sources.items()}
        self.type_name = _common_type(sources)
        self._copies_s2 = all(s2.type_name == self.type_name for s2 in self._s2.values())
        self.codecs = {
            name: self._codec(parameters, s2) for name, (parameters, s2) in sources.items()
        }
        codec, *others = self.codecs.values()
        self.makes_rows = self._copies_s2 and fills(codec) and not others
        named = {name: each.parameters.variance_field for name, each in sources.items()}
        self._variances = {
            name: Elements(types, self.type_name, [path]) for name, path in named.items() if path
        }
        _refuse_overlaps(self.type_name, self.codecs, named)
        self._filled = sorted(self.codecs, key=lambda name: _is_pitch(self.codecs[name]))
        self.lacking: Counter[str] = Counter()
        self._own = {
            name: variance_of(types, self.type_name, codec.field)
            for name, codec in self.codecs.items()
        }
        self._written = [
            name for name, path in named.items() if path and path == self._own[name].path
        ]
        self._marks: dict[frozenset[str], _Marks] = {}
        self._blank: tuple[bytes, frozenset[str]] | None = None
        self._templates: list[tuple[str, Template]] = []

    @property
    def described(self) -> str:
        """Fields and type in words."""
        fields = ", ".join(
            f"{name}: {codec.field.text}" if name else codec.field.text
            for name, codec in self.codecs.items()
        )
        return f"{fields} of {self.type_name}"

    def message(self, together: Together) -> bytes:
        """Return the message of the estimates of one stamp.

        A channel without an estimate gives what it holds of S2.

        Raises:
            MessageError: A number or the stamp does not fit into it, or a channel has neither.
        """
        stamp_ns, fused, held = together
        s2_message = together.s2_message
        sure = frozenset(name for name in self._written if _is_sure(fused.get(name)))
        if self._blank is None or s2_message is not self._blank[0] or sure != self._blank[1]:
            elements, numbers = self._marks_with(sure)
            blank = elements.written(self._like(s2_message), numbers)
            self._templates = [(name, self.codecs[name].template(blank)) for name in self._filled]
            self._blank = s2_message, sure
        lacks = len(fused) < len(self.codecs)
        missing = [name for name in self.codecs if name not in fused] if lacks else ()
        for name in missing:
            if name not in held:
                raise MessageError(f"channel {name} has neither an estimate nor a value of S2")
        (_, first), *_ = templates = self._templates
        message = first.stamped(stamp_ns)
        for name, template in templates:
            template.fill(message, held[name] if name in missing else fused[name].estimate.value)
        data = bytes(message)
        for name, variance in self._variances.items():
            if name in fused:
                own = fused[name]
                deviation = self.codecs[name].deviation(own.estimate.value, own.standard_deviation)
                if deviation != 0.0:
                    data = variance.written(data, [deviation * deviation])
        for name in missing:
            self.lacking[name] += 1
        return data

    def rows(
        self,
        s2: Rows,
        values: NDArray[np.float64],
        stamps_ns: NDArray[np.int64],
        deviations: NDArray[np.float64],
    ) -> Rows | None:
        """Return the messages of many estimates; ``None`` if they must be made one by one.

        Args:
            s2: The newest message of S2 at each, all with one layout, shape (n, bytes), n at least
                1; of no bytes where there is none yet.
            values: The estimates, shape (n,).
            stamps_ns: Their stamps, shape (n,), nanoseconds.
            deviations: Standard deviations of their errors, 0 where not known, shape (n,).
        """
        if not self.makes_rows:
            return None
        (codec,), variances = self.codecs.values(), self._variances.values()
        known = deviations != 0.0
        sure = frozenset(self._written)
        marked = [(known, sure), (~known, frozenset())] if sure else [(slice(None), sure)]
        rows = s2.copy() if s2.shape[1] else repeated(self._like(b""), len(s2))
        first = rows[0].tobytes()
        try:
            place = codec.place(first)
            marks = [(which, self._marks_with(each)) for which, each in marked]
            places = [(which, each.elements.places(first), each.numbers) for which, each in marks]
            ours = [at for each in variances for at in each.places(first)]
        except MessageError:
            return None
        for which, at_all, numbers in places:
            some = rows[which]
            put_same(some, at_all, numbers)
            rows[which] = some
        fit = filled(rows, codec, place, values, stamps_ns)
        for form, at in ours:
            scaled = deviations[known] / codec.scale
            some = rows[known]
            fit = fit and form[1] in "fd" and put(some, at, form, scaled * scaled)
            rows[known] = some
        return rows if fit else None

    def _marks_with(self, sure: frozenset[str]) -> _Marks:
        """Return what marks variances as unknown, but for those of some channels, which are known.

        Those of S2 in the same matrix then stay.
        """
        if sure not in self._marks:
            numbers: dict[str, float] = {}
            for known in (True, False):  # what is unknown may be all of a matrix
                for name, own in self._own.items():
                    if (name in sure) == known:
                        numbers |= own.known if known else own.unknown
            elements = Elements(self._types, self.type_name, list(numbers))
            self._marks[sure] = _Marks(elements, tuple(numbers.values()))
        return self._marks[sure]

    def _codec(self, parameters: EstimateParameters, s2: ScalarCodec) -> ScalarCodec:
        is_s2s = s2.type_name == self.type_name and not parameters.field
        codec = s2 if is_s2s else ScalarCodec(self._types, self.type_name, parameters.field)
        if codec.function.write is None:
            raise MessageError(
                f"the estimate cannot be written into field {codec.field.text!r} of "
                f"{self.type_name}, which cannot be inverted: set estimate.type and estimate.field"
            )
        return codec

    def _like(self, s2_message: bytes) -> bytes:
        """Return a message to fill: the one of S2, or a default one in its frame."""
        if self._copies_s2 and s2_message:
            return s2_message
        s2 = next(iter(self._s2.values()))
        frame = s2.frame(s2_message) if s2_message else ""
        return default_message(self._types, self.type_name, frame)


class _Marks(NamedTuple):
    """Numbers of a message that say how sure others are, and what they are set to."""

    elements: Elements
    numbers: tuple[float, ...]


def _is_sure(fused: Fused | None) -> bool:
    return fused is not None and fused.standard_deviation != 0.0


def _is_pitch(codec: ScalarCodec) -> bool:
    """Return whether a field is a pitch: one past a right angle turns the angles read after it."""
    call = call_in(codec.field.text)
    return call is not None and call.name == "pitch"


def _common_type(sources: Mapping[str, EstimateSource]) -> str:
    """Return the type of the message of all channels.

    Raises:
        MessageError: They differ.
    """
    types = {
        name: normalise_type_name(parameters.type) if parameters.type else s2.type_name
        for name, (parameters, s2) in sources.items()
    }
    (first, type_name), *others = types.items()
    for name, other in others:
        if other != type_name:
            raise MessageError(
                f"channels share one message, but that of {first} is {type_name} and that of "
                f"{name} {other}: give them one s2.type, or set estimate.type"
            )
    return type_name


def _refuse_overlaps(
    type_name: str, codecs: Mapping[str, ScalarCodec], variances: Mapping[str, str]
) -> None:
    """Refuse channels that write the same numbers.

    Raises:
        MessageError: Two do, or one its variance over an estimate; angles of one orientation are
            apart, though they share its numbers.
    """
    estimates = {path.text: name for name, each in codecs.items() for path in each.field.paths}
    for name, variance in variances.items():
        if variance in estimates:
            of = f" of channel {estimates[variance]}" if estimates[variance] else ""
            own = f"{name}.estimate" if name else "estimate"
            raise MessageError(
                f"{own}.variance_field is {variance} of {type_name}, which holds the estimate{of}: "
                "name the field of a variance"
            )
    for (one, first), (other, second) in combinations(codecs.items(), 2):
        numbers = {path.text for path in first.field.paths}
        shared = numbers & {path.text for path in second.field.paths}
        calls = call_in(first.field.text), call_in(second.field.text)
        angles = {call.name for call in calls if call is not None} & ANGLES
        if shared and len(angles) < 2:
            raise MessageError(
                f"channels {one} and {other} both write {second.field.text} of {type_name}: "
                "give each its own field"
            )
        if variances[one] and variances[one] == variances[other]:
            raise MessageError(
                f"channels {one} and {other} both write their variance into {variances[one]} of "
                f"{type_name}: give each its own estimate.variance_field"
            )
