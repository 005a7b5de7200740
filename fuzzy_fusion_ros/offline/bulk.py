# SPDX-License-Identifier: Apache-2.0
"""Blocks of a bag through the fusion at once, where no guard has anything to do.

Instead of message by message because that takes many times as long. Where anything else is to be
done than to estimate at each sample of S1, a block is left to the messages' way, which goes on from
the same state; both give the same messages.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fuzzy_fusion_ros.bag.block import Block
from fuzzy_fusion_ros.batch.arrays import Stamps
from fuzzy_fusion_ros.batch.series import (
    Trace,
    advanced,
    fusion,
    interval_after,
    pays_to_compile,
)
from fuzzy_fusion_ros.core.estimator import WAITING
from fuzzy_fusion_ros.core.sample import Sample
from fuzzy_fusion_ros.messages.codec import ScalarCodec
from fuzzy_fusion_ros.messages.columns import ColumnReader, Columns, rows_alike
from fuzzy_fusion_ros.messages.explanation_rows import ExplanationColumns, ExplanationRows
from fuzzy_fusion_ros.messages.outputs import EstimateMessages
from fuzzy_fusion_ros.messages.rows import Rows, repeated
from fuzzy_fusion_ros.offline.clean import is_settled, series_of, takes_arrays
from fuzzy_fusion_ros.offline.topics import Topics
from fuzzy_fusion_ros.online.fusion import Fusion, Standing
from fuzzy_fusion_ros.online.guard import DELAYS, Guard
from fuzzy_fusion_ros.online.mode_shares import ModeShares
from fuzzy_fusion_ros.parameters.fusion import Parameters

_SLOTS = 16
"""Messages that one message may bring about, itself included, at most."""


class Brought(NamedTuple):
    """What a block brings about.

    Attributes:
        block: Its messages, each followed by what it brings about.
        estimates: How many estimates are among them.
    """

    block: Block
    estimates: int


class Bulk:
    """The fusion on blocks."""

    def __init__(
        self,
        topics: Topics,
        parameters: Parameters,
        codecs: Mapping[str, ScalarCodec],
        estimates: EstimateMessages,
        explanation: ExplanationRows | None,
        outputs: Mapping[str, str],
        samples: int,
    ) -> None:
        """Get ready.

        Args:
            topics: Where S1 and S2 are, and where the estimate goes.
            parameters: Of the fusion.
            codecs: Read S1 and S2, by role.
            estimates: Makes the messages of estimates.
            explanation: Makes those that explain them, if any are wanted.
            outputs: The topics that are written, and their types, the estimate's first.
            samples: How many samples of S1 there are to be, as far as that is known.
        """
        self._is_possible = (
            topics.s1 != topics.s2 and takes_arrays(parameters) and estimates.makes_rows
        )
        self._topics = topics
        self._parameters = parameters
        self._codecs = codecs
        self._estimates = estimates
        self._explanation = explanation
        self._outputs = tuple(outputs.items())
        self._compiles = pays_to_compile(fusion(parameters), samples)

    def follow(self, block: Block, live: Fusion, modes: ModeShares) -> Brought | None:
        """Take a block; return ``None``, and change nothing, if it must go message by message.

        Args:
            block: Messages of any topics.
            live: The fusion so far; it continues after the block.
            modes: The time in each mode so far.
        """
        parameters, topics = self._parameters, self._topics
        if not self._is_possible or not live.is_settled():
            return None
        places = {"s1": block.which(topics.s1), "s2": block.which(topics.s2)}
        columns = {role: self._columns(role, block.chosen(at)) for role, at in places.items()}
        guards = {"s1": live.s1, "s2": live.s2}
        if not all(
            is_settled(columns[role], parameters.future_tolerance, guards[role]) for role in places
        ):
            return None
        series = series_of(columns, places, guards, parameters)
        if series is None:
            return None
        heard = block.chosen(places["s2"])
        s2_rows = rows_alike(self._codecs["s2"], heard.data, heard.at, heard.sizes)
        if s2_rows is None:
            return None
        before = live.standing
        method = fusion(parameters)._replace(state=before.state)
        trace, state = advanced(method, series, compiles=self._compiles)
        is_due = (trace.mode != WAITING) & (trace.stamp_ns > before.estimated_ns)
        due = np.flatnonzero(is_due)
        estimates = trace.rows(is_due)
        pieces = self._messages(estimates, s2_rows, series.s2_known[due] - 1, before.s2.message)
        if pieces is None:
            return None
        for role, guard in guards.items():
            self._admit(guard, columns[role])
        newest = next(heard.chosen(slice(-1, None)).messages(), None)
        s2 = before.s2
        if newest is not None:
            s2 = Sample(int(series.s2_ns[-1]), float(series.s2[-1]), newest.data)
        estimated_ns = int(estimates.stamp_ns[-1]) if due.size else before.estimated_ns
        live.standing = Standing(state, estimated_ns, s2)
        modes.see_all(estimates.mode, estimates.stamp_ns)
        causes = places["s1"][due]
        return Brought(self._interleaved(block, causes, pieces), int(due.size))

    def _columns(self, role: str, block: Block) -> Columns:
        reader = ColumnReader([self._codecs[role]])
        reader.add(block.data, block.at, block.sizes, block.log_ns)
        found = reader.columns()
        return found._replace(values=found.values[0], lacking=found.lacking[0])

    def _messages(
        self, trace: Trace, s2_rows: Rows, newest: Stamps, before: bytes
    ) -> list[tuple[str, NDArray[np.int64], Rows]] | None:
        """Return topic, estimates and messages; ``None`` if they must be made one by one.

        Args:
            trace: The estimates.
            s2_rows: The messages of S2, shape (n, bytes).
            newest: Which of them is the newest at each estimate, -1 for the one before them.
            before: That one, empty if there was none.
        """
        pieces: list[tuple[str, NDArray[np.int64], Rows]] = []
        old, new = np.flatnonzero(newest < 0), np.flatnonzero(newest >= 0)
        sources = [(old, repeated(before, old.size))] if old.size else []
        if new.size:
            sources.append((new, s2_rows[newest[new]]))
        for which, s2 in sources:
            made = self._estimates.rows(
                s2,
                trace.value[which],
                trace.stamp_ns[which],
                trace.standard_deviation[which],
            )
            if made is None:
                return None
            pieces.append((self._outputs[0][0], which, made))
        if self._explanation is not None:
            prefix = self._outputs[1][0].rpartition("/")[0]
            own = ExplanationColumns(*(getattr(trace, name) for name in ExplanationColumns._fields))
            explained = self._explanation.rows(own)
            if explained is None:
                return None
            pieces += [(f"{prefix}/{name}", which, rows) for name, which, rows in explained]
        return pieces

    def _interleaved(
        self,
        block: Block,
        causes: NDArray[np.int64],
        pieces: list[tuple[str, NDArray[np.int64], Rows]],
    ) -> Block:
        """Return the messages of a block, each followed by what it brings about."""
        numbers = {topic: k for k, (topic, _) in enumerate(self._outputs)}
        data, at, sizes = [block.data], [block.at], [block.sizes]
        log_ns, kinds, keys = [block.log_ns], [block.kinds], [_SLOTS * np.arange(block.at.size)]
        begin = len(block.data)
        for topic, which, rows in pieces:
            n, size = rows.shape
            data.append(rows.tobytes())
            at.append(begin + size * np.arange(n))
            sizes.append(np.full(n, size))
            log_ns.append(block.log_ns[causes[which]])
            kinds.append(np.full(n, len(block.names) + numbers[topic]))
            keys.append(_SLOTS * causes[which] + 1 + numbers[topic])
            begin += n * size
        order = np.argsort(np.concatenate(keys), kind="stable")
        return Block(
            b"".join(data),
            np.concatenate(at)[order],
            np.concatenate(sizes)[order],
            np.concatenate(log_ns)[order],
            np.concatenate(kinds)[order],
            (*block.names, *self._outputs),
        )

    def _admit(self, guard: Guard, columns: Columns) -> None:
        stamps_ns = columns.stamps_ns
        if stamps_ns.size:
            newest = slice(-DELAYS, None)
            delays_ns = (columns.received_ns[newest] - stamps_ns[newest]).tolist()
            first_ns, last_ns = int(stamps_ns[0]), int(stamps_ns[-1])
            later_ns = stamps_ns[1:] if guard.newest_ns is None else stamps_ns
            before_ns = first_ns if guard.newest_ns is None else guard.newest_ns
            interval = interval_after(guard.interval, before_ns, later_ns, compiles=self._compiles)
            guard.admit_run(first_ns, last_ns, stamps_ns.size, interval, delays_ns)
