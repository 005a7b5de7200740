# SPDX-License-Identifier: Apache-2.0
"""What happens to a sample: admitted or dropped, the steps that it triggers, the estimates."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

from fuzzy_fusion_ros.core.estimator import Estimate, State
from fuzzy_fusion_ros.online.guard import Drop
from fuzzy_fusion_ros.online.trigger import Step


@dataclass(slots=True)  # frozen, it would take a microsecond to make
class Fused:
    """An estimate with the stamp of its sample.

    Attributes:
        stamp_ns: The stamp, nanoseconds.
        estimate: The estimate.
        state: The state of the estimator after it; not part of the comparison of two estimates.
        s2_message: The message of the newest S2 sample in it, empty if there is none.
        turned: What was subtracted from the estimate because the signal wraps; not from the state.
        s2_ns: The stamp of the newest S2 sample, nanoseconds; 0 if there is none.
    """

    stamp_ns: int
    estimate: Estimate
    state: State = field(compare=False, repr=False)
    s2_message: bytes = b""
    turned: float = 0.0
    s2_ns: int = 0

    @property
    def standard_deviation(self) -> float:
        """Standard deviation of the estimate's error, unit of the signal; 0 while unknown."""
        return self.estimate.standard_deviation


@dataclass(slots=True)
class Verdict:
    """What happened to a sample.

    A sample that is neither admitted nor dropped is held until later ones decide.

    Attributes:
        admitted: Samples admitted now; more than one where earlier ones were held.
        drop: Why the sample was dropped; ``None`` if it was not.
        restarted: Whether timestamps jumped, so that all state was cleared first.
        steps: The steps for the estimator, in order.
        estimates: The resulting estimates; the fusion adds them.
    """

    admitted: int = 0
    drop: Drop | None = None
    restarted: bool = False
    steps: tuple[Step, ...] = ()
    estimates: tuple[Fused, ...] = ()


class Together(NamedTuple):
    """The estimates of one stamp.

    Attributes:
        stamp_ns: The stamp, nanoseconds.
        fused: The estimates by channel; one that has none is left out.
        held: The newest value of S2 of those left out, by channel, where there is one.
    """

    stamp_ns: int
    fused: Mapping[str, Fused]
    held: Mapping[str, float] = {}

    @property
    def s2_message(self) -> bytes:
        """The newest of the messages of S2 that channels hold, empty if there is none."""
        message, newest_ns = b"", -1
        for each in self.fused.values():
            if each.s2_ns > newest_ns:
                message, newest_ns = each.s2_message, each.s2_ns
        return message
