# SPDX-License-Identifier: Apache-2.0
"""What becomes of a sample: admitted or dropped, the steps that it makes due, the estimates."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

from fuzzy_fusion_ros.core.estimator import Estimate, State
from fuzzy_fusion_ros.online.guard import Drop
from fuzzy_fusion_ros.online.trigger import Step


@dataclass(frozen=True, slots=True)
class Fused:
    """An estimate with the stamp of the sample that it is for.

    Attributes:
        stamp_ns: The stamp, nanoseconds.
        estimate: The estimate.
        state: The state of the estimator behind it; two that are equal may differ in this.
        s2_message: The message of the newest S2 sample in it, empty if there is none.
        turned: What the estimate was turned by, as the signal wraps; the state is not.
    """

    stamp_ns: int
    estimate: Estimate
    state: State = field(compare=False, repr=False)
    s2_message: bytes = b""
    turned: float = 0.0

    @property
    def standard_deviation(self) -> float:
        """Standard deviation of the estimate's error, unit of the signal; 0 while not known."""
        return self.estimate.standard_deviation


class Verdict(NamedTuple):
    """What became of a sample.

    A sample that is neither admitted nor dropped is held: the next ones decide.

    Attributes:
        admitted: Samples admitted now; more than one where earlier ones were held.
        drop: Why the sample was dropped, ``None`` if it was not.
        restarted: Whether timestamps jumped, so that all state was cleared first.
        steps: What the estimator has to do, in order.
        estimates: What it answered; empty before it has.
    """

    admitted: int = 0
    drop: Drop | None = None
    restarted: bool = False
    steps: tuple[Step, ...] = ()
    estimates: tuple[Fused, ...] = ()
