"""What tests of nodes share: a graph for each test, and what nodes say about themselves."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest
from rclpy.qos import DurabilityPolicy, QoSProfile

from fuzzy_fusion_ros.testing import Harness


@pytest.fixture
def harness() -> Iterator[Harness]:
    """A graph of its own."""
    with Harness() as opened:
        yield opened


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
        self._harness.spin_until(lambda: self._with(text), f"a log line with {text!r}")
        return self._with(text)[0]

    def count(self, text: str) -> int:
        """Return how many lines hold a text."""
        return len(self._with(text))

    def _with(self, text: str) -> list[str]:
        return [line for line in self.lines if text in line]


@pytest.fixture
def log(harness: Harness) -> Log:
    """What nodes log."""
    return Log(harness)


class Diagnostics:
    """What nodes say on /diagnostics."""

    def __init__(self, harness: Harness) -> None:
        self._harness = harness
        self._messages = harness.record("/diagnostics", "diagnostic_msgs/msg/DiagnosticArray")

    def now(self, name: str) -> tuple[int, str, dict[str, str]]:
        """Return level, message and values of a status that is made from now on."""
        seen = len(self._messages)
        found: list[Any] = []

        def has_come() -> bool:
            found.extend(
                status
                for message in self._messages[seen:]
                for status in message.status
                if status.name == name
            )
            return bool(found)

        self._harness.spin_until(has_come, f"diagnostics of {name}")
        status = found[-1]
        values = {each.key: each.value for each in status.values}
        return status.level[0], status.message, values

    def wait_for(self, name: str, text: str) -> tuple[int, str, dict[str, str]]:
        """Return the first status made from now on whose message holds a text."""
        found = self.now(name)
        while text not in found[1]:
            found = self.now(name)
        return found


@pytest.fixture
def diagnostics(harness: Harness) -> Diagnostics:
    """What nodes say on /diagnostics."""
    return Diagnostics(harness)
