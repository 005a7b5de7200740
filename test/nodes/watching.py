# SPDX-License-Identifier: Apache-2.0
"""Watches what nodes say about themselves."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from rclpy.qos import DurabilityPolicy, QoSProfile

from fuzzy_fusion_ros.testing import Harness


class Log:
    """What nodes log, as it comes over /rosout."""

    def __init__(self, harness: Harness) -> None:
        qos = QoSProfile(depth=1000, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self._harness = harness
        self._messages = harness.record("/rosout", "rcl_interfaces/msg/Log", qos)

    @property
    def lines(self) -> list[str]:
        """All that was logged so far."""
        return [message.msg for message in self._messages]

    def wait_for(self, text: str) -> str:
        """Return the first line that holds a text, once it has come."""
        try:
            self._harness.spin_until(lambda: self._with(text))
        except TimeoutError:
            raise AssertionError(f"nothing logged with {text!r}, but {self.lines}") from None
        return self._with(text)[0]

    def count(self, text: str) -> int:
        """Return how many lines hold a text."""
        return len(self._with(text))

    def _with(self, text: str) -> list[str]:
        return [line for line in self.lines if text in line]


class Status(NamedTuple):
    """One status of /diagnostics."""

    level: int
    message: str
    values: dict[str, str]


OK, WARN, ERROR = 0, 1, 2


class Diagnostics:
    """What nodes say on /diagnostics."""

    def __init__(self, harness: Harness) -> None:
        self._harness = harness
        self._messages = harness.record("/diagnostics", "diagnostic_msgs/msg/DiagnosticArray")

    @property
    def names(self) -> set[str]:
        """The names of every status so far."""
        return {status.name for message in self._messages for status in message.status}

    def of(self, name: str) -> list[Status]:
        """Return every status of a name so far."""
        return [
            Status(
                status.level[0],
                status.message,
                {each.key: each.value for each in status.values},
            )
            for message in self._messages
            for status in message.status
            if status.name == name
        ]

    def next(self, name: str) -> Status:
        """Return the first status of a name that is made from now on."""
        seen = len(self.of(name)) + 1  # the next may be under way already
        self._harness.spin_until(lambda: len(self.of(name)) > seen, f"diagnostics of {name}")
        return self.of(name)[seen]

    def saying(self, name: str, text: str) -> Status:
        """Return the first status of a name that holds a text, once there is one."""
        return self._first(name, lambda status: text in status.message, repr(text))

    def having(self, name: str, key: str, value: str) -> Status:
        """Return the first status of a name with a value, once there is one."""
        return self._first(name, lambda status: status.values[key] == value, f"{key} {value}")

    def _first(self, name: str, matches: Callable[[Status], bool], what: str) -> Status:
        def found() -> list[Status]:
            return [status for status in self.of(name) if matches(status)]

        self._harness.spin_until(found, f"diagnostics of {name} with {what}")
        return found()[0]
