# SPDX-License-Identifier: Apache-2.0
"""What all tests share: settings, and a ROS graph with what nodes say in it."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from typing import TYPE_CHECKING

import pytest
from hypothesis import HealthCheck, settings

if TYPE_CHECKING:
    from nodes.watching import Diagnostics, Log

    from fuzzy_fusion_ros.testing import Harness

# The same examples in every run, and no verdict that depends on the speed of the machine.
settings.register_profile(
    "reproducible",
    deadline=None,
    derandomize=True,
    suppress_health_check=[HealthCheck.too_slow],
)
settings.load_profile("reproducible")

# A shell ignores interrupts in what it runs in the background, and children inherit that.
signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Refuse a test that is slow for no reason.

    Raises:
        UsageError: There is one.
    """
    for item in items:
        for mark in item.iter_markers("slow"):
            if not (len(mark.args) == 1 and isinstance(mark.args[0], str)):
                raise pytest.UsageError(f"{item.nodeid}: say why, as in slow('five more builds')")


# Imports of rclpy are in the fixtures, so that tests of the method start without it.
@pytest.fixture
def harness() -> Iterator[Harness]:
    """A ROS graph of the test's own."""
    from fuzzy_fusion_ros.testing import Harness

    with Harness() as opened:
        yield opened


@pytest.fixture
def log(harness: Harness) -> Log:
    """What nodes log."""
    from nodes.watching import Log

    return Log(harness)


@pytest.fixture
def diagnostics(harness: Harness) -> Diagnostics:
    """What nodes publish on /diagnostics."""
    from nodes.watching import Diagnostics

    return Diagnostics(harness)
