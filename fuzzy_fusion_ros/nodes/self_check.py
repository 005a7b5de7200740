# SPDX-License-Identifier: Apache-2.0
"""What a node finds wrong with its sensors, in the words of ``check``."""

from __future__ import annotations

from concurrent.futures import Executor, Future

from rclpy.impl.rcutils_logger import RcutilsLogger

from fuzzy_fusion_ros.checking.check import Check
from fuzzy_fusion_ros.checking.finding import Finding
from fuzzy_fusion_ros.checking.pair import wrong_period
from fuzzy_fusion_ros.checking.recent import Stream, check_recent, warnings
from fuzzy_fusion_ros.checking.samples import two_sensors
from fuzzy_fusion_ros.nodes.sensor_input import SensorInput
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.ros.diagnostics import Level, Report, Summary

FIRST = 10
"""Reports (one a second) before the first check: there must be motion to compare."""

CONFIRMED = 20
"""Most reports after which a check that has found something new is repeated."""

LONGEST = 60
"""Most reports between two checks; the interval doubles until then."""


class SelfCheck:
    """Checks the most recent samples now and then, and reports what two checks in a row find.

    A check can take longer than a queue of samples lasts, so it runs in another thread.

    Attributes:
        s1: Where samples of S1 go.
        s2: Where samples of S2 go.
    """

    def __init__(
        self,
        log: RcutilsLogger,
        s1: SensorInput,
        s2: SensorInput,
        parameters: Parameters,
        background: Executor,
    ) -> None:
        """Start without samples; warn of what the parameters alone show.

        Args:
            log: Where each finding is said once, until it is gone.
            s1: The input of S1.
            s2: The input of S2.
            parameters: Of the fusion, as at start-up.
            background: Runs the checks.
        """
        self.s1 = Stream("s1", s1.subscription.topic, s1.codec)
        self.s2 = Stream("s2", s2.subscription.topic, s2.codec)
        self._log = log
        self._parameters = parameters
        self._background = background
        self._running: Future[Check] | None = None
        self._reports = self._started = 0
        self._due = FIRST
        known = wrong_period(two_sensors(self.s1.samples(), self.s2.samples(), 0, parameters))
        for each in known:
            log.warning(str(each))
        self._said: dict[str, Finding] = {each.about: each for each in known}
        self._last = self._said

    def restart(self) -> None:
        """Forget all samples: timestamps or the clock have jumped."""
        self.s1.restart()
        self.s2.restart()

    def report(self) -> Report:
        """Report what is wrong, as the last check that has ended found; start one if it is time."""
        self._reports += 1
        if self._running is not None and self._running.done():
            self._take_up(self._running.result())
            self._running = None
        if self._running is None and self._reports >= self._due:
            self._started = self._reports
            self._running = self._background.submit(
                check_recent, self.s1.samples(), self.s2.samples(), self._parameters
            )
        summaries = [Summary(Level.WARN, str(each)) for each in self._said.values()]
        return Report("check", summaries or [Summary(Level.OK, "no problems found")], {})

    def _take_up(self, check: Check) -> None:
        found = {each.about: each for each in warnings(check)}
        lasting = {about: each for about, each in found.items() if about in self._last}
        for about, each in lasting.items():
            if about not in self._said:
                self._log.warning(str(each))
        self._last, self._said = found, lasting
        is_new = found.keys() - lasting.keys()
        self._due = self._started + min(self._started, CONFIRMED if is_new else LONGEST)
