# SPDX-License-Identifier: Apache-2.0
"""The single intake of node, replay, score and tune: guards, timeline, lines, trigger."""

from __future__ import annotations

from fuzzy_fusion_ros.core.numerics import seconds_between
from fuzzy_fusion_ros.core.sample import Sample
from fuzzy_fusion_ros.core.silence import S2_TIMEOUT
from fuzzy_fusion_ros.online.clocks import clock_problem
from fuzzy_fusion_ros.online.guard import Drop, Guard
from fuzzy_fusion_ros.online.lines import lines_for
from fuzzy_fusion_ros.online.timeline import Admission, Timeline
from fuzzy_fusion_ros.online.trigger import Step, trigger_for
from fuzzy_fusion_ros.online.verdict import Verdict
from fuzzy_fusion_ros.parameters.fusion import Parameters


class Intake:
    """Decides which samples count and which steps of the estimator they make due.

    Attributes:
        s1, s2: The guards, with the counts of what was admitted and dropped.
        newest_s2: The newest sample of S2 taken since the state was last cleared, if any.
    """

    def __init__(self, parameters: Parameters) -> None:
        self._parameters = parameters
        self.s1 = Guard()
        self.s2 = Guard(S2_TIMEOUT)
        self._timeline = Timeline(self.s1, self.s2)
        self._trigger = trigger_for(parameters)
        self._lines = lines_for(parameters)
        self.newest_s2: Sample | None = None

    @property
    def parameters(self) -> Parameters:
        """The parameters; assign new ones to use them from the next sample on."""
        return self._parameters

    @parameters.setter
    def parameters(self, parameters: Parameters) -> None:
        self._parameters = parameters
        self._trigger.parameters = parameters
        self._lines.parameters = parameters

    def on_s1(self, sample: Sample, now_ns: int) -> Verdict:
        """Take a sample of S1.

        Args:
            sample: The sample as received, valid or not.
            now_ns: Time of receipt, nanoseconds on the clock of the stamps.
        """
        tolerance = self._parameters.future_tolerance
        return self._follow(self._timeline.receive(self.s1, sample, now_ns, tolerance))

    def on_s2(self, sample: Sample, now_ns: int) -> Verdict:
        """Take a sample of S2; as :meth:`on_s1`."""
        tolerance = self._parameters.future_tolerance
        return self._follow(self._timeline.receive(self.s2, sample, now_ns, tolerance))

    def on_tick(self) -> Verdict:
        """Take a tick of the timer, for ``trigger: timer``."""
        return Verdict(steps=(self._trigger.on_tick(),))

    @property
    def started_ns(self) -> int:
        """Stamp from which on S2 is awaited: of the first sample of S1, of a rate that of S2.

        Nanoseconds; 0 before it. Without S2, a rate says nothing.
        """
        return (self.s2 if self._parameters.s1.is_rate else self.s1).first_ns

    def is_settled(self) -> bool:
        """Return whether no sample is held, so that the next one is judged alone."""
        return self._timeline.is_settled

    def clocks_known(self) -> bool:
        """Return whether enough samples of both sensors have arrived to compare their clocks."""
        return self.s1.delay is not None and self.s2.delay is not None

    def clock_problem(self) -> str:
        """Describe the offset between the sensors' clocks, ``""`` while it does no harm."""
        parameters = self._parameters
        return clock_problem(
            self.s1,
            self.s2,
            self.s1.timeout(parameters.s1.timeout),
            self.s2.timeout(parameters.s2.timeout),
        )

    def restart(self) -> Verdict:
        """Start a new timeline: the clock of the stamps has jumped back."""
        return self._follow(self._timeline.restart())

    def reset(self) -> None:
        """Clear the state; the counts are kept."""
        self._timeline.reset()
        self._clear()

    def finish(self) -> None:
        """Count what is still held as dropped: nothing more will come."""
        self._timeline.finish()

    def _follow(self, admission: Admission) -> Verdict:
        admitted, drop, restarted = admission
        if restarted:
            self._clear()
        steps: tuple[Step, ...] = ()
        for guard, sample in admitted:
            steps += self._of_s1(sample) if guard is self.s1 else self._of_s2(sample)
        return Verdict(len(admitted), drop, restarted, steps)

    def _clear(self) -> None:
        self.newest_s2 = None
        self._trigger = trigger_for(self._parameters)
        self._lines = lines_for(self._parameters)

    def _of_s1(self, sample: Sample) -> tuple[Step, ...]:
        on_line = self._lines.on_s1(sample)
        return () if on_line is None else (self._counted(self._trigger.on_s1(on_line)),)

    def _of_s2(self, sample: Sample) -> tuple[Step, ...]:
        self.newest_s2 = sample
        on_line = self._lines.on_s2(sample)
        early = tuple(self._counted(self._trigger.on_s1(each)) for each in self._lines.early())
        step = self._counted(self._trigger.on_s2(on_line))
        if step.s2 is not None and step.s1 is None and self._s1_is_lost(step.s2.stamp_ns):
            step = step._replace(s2_alone=True)
        return (*early, step)

    def _counted(self, step: Step) -> Step:
        """Count the samples that are given up on with a step."""
        if step.unpaired_s1 or step.unpaired_s2:
            self.s1.drop(Drop.UNPAIRED, step.unpaired_s1)
            self.s2.drop(Drop.UNPAIRED, step.unpaired_s2)
        return step

    def _s1_is_lost(self, stamp_ns: int) -> bool:
        heard_ns = self.s2.first_ns if self.s1.newest_ns is None else self.s1.newest_ns
        return seconds_between(heard_ns, stamp_ns) > self.s1.timeout(self._parameters.s1.timeout)
