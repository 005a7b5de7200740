# SPDX-License-Identifier: Apache-2.0
"""The messages that stand behind many estimates, as rows of bytes."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fuzzy_fusion_ros.core.aggregator import FiringStrengths
from fuzzy_fusion_ros.messages.cdr import ORIGIN
from fuzzy_fusion_ros.messages.codec import ScalarCodec
from fuzzy_fusion_ros.messages.defaults import default_message
from fuzzy_fusion_ros.messages.outputs import DEVIATION, POINT, RULES, STRENGTHS, strengths_message
from fuzzy_fusion_ros.messages.rows import Rows, filled, put, put_stamps, repeated
from fuzzy_fusion_ros.messages.type_fields import TypeDescriptions

_AFTER_STRENGTHS = 8 * len(RULES) + 2 * 4
"""Bytes from the first of them to the end: the numbers, and the counts of two empty arrays."""


class ExplanationColumns(NamedTuple):
    """Estimates and what stands behind them, all of shape (n,), strengths (n, 4).

    Attributes:
        stamp_ns: Their stamps, nanoseconds.
        aggregate: FA's output.
        weight: W1.
        drift: Magnitude of the drift.
        strengths: Firing strengths in Table 1's order.
        predicted: Whether there was a prediction.
        prediction: The prediction.
        standard_deviation: Of the estimate's error, 0 where nothing is known.
    """

    stamp_ns: NDArray[np.int64]
    aggregate: NDArray[np.float64]
    weight: NDArray[np.float64]
    drift: NDArray[np.float64]
    strengths: NDArray[np.float64]
    predicted: NDArray[np.bool_]
    prediction: NDArray[np.float64]
    standard_deviation: NDArray[np.float64]


class ExplanationRows:
    """Makes what stands behind many estimates, as :func:`explain` does for one."""

    def __init__(self, types: TypeDescriptions) -> None:
        """Get ready.

        Args:
            types: Who describes message types.
        """
        self._codec = ScalarCodec(types, POINT)
        self._point = default_message(types, POINT, "")
        self._place = self._codec.place(self._point)
        self._strengths = strengths_message(FiringStrengths(0.0, 0.0, 0.0, 0.0), 0)

    def rows(self, trace: ExplanationColumns) -> list[tuple[str, NDArray[np.int64], Rows]] | None:
        """Return topic, the estimates that it has a message of, and these messages.

        Args:
            trace: The estimates.

        Returns:
            ``None`` if the messages must be made one by one.
        """
        everywhere = np.arange(trace.stamp_ns.size)
        predicted = np.flatnonzero(trace.predicted)
        with np.errstate(over="ignore", invalid="ignore"):
            innovation = trace.aggregate - trace.prediction
        columns = (
            ("weight", everywhere, trace.weight),
            ("drift", everywhere, trace.drift),
            ("aggregate", everywhere, trace.aggregate),
            ("prediction", predicted, trace.prediction),
            ("innovation", predicted, innovation),
            (DEVIATION, np.flatnonzero(trace.standard_deviation > 0.0), trace.standard_deviation),
        )
        found = []
        for name, which, values in columns:
            rows = repeated(self._point, which.size)
            if not filled(rows, self._codec, self._place, values[which], trace.stamp_ns[which]):
                return None
            found.append((name, which, rows))
        rows = repeated(self._strengths, everywhere.size)
        begin = len(self._strengths) - _AFTER_STRENGTHS
        for k in range(len(RULES)):
            put(rows, begin + 8 * k, "<d", trace.strengths[:, k])
        put_stamps(rows, ORIGIN, "<", trace.stamp_ns)
        return [*found, (STRENGTHS, everywhere, rows)]
