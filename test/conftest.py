# SPDX-License-Identifier: Apache-2.0
"""What all tests share: settings, and a ROS graph with what nodes say in it."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from hypothesis import HealthCheck, settings
from searching import QUICK, USUAL

if TYPE_CHECKING:
    from nodes.watching import Diagnostics, Log

    from fuzzy_fusion_ros.testing import Harness

HERE = Path(__file__).parent

# The same examples in every run, and no verdict that depends on the speed of the machine.
# A quick run tries a quarter of them; make test-slow all, by --hypothesis-profile=thorough.
for profile, share in (("quick", QUICK), ("thorough", 1.0)):
    settings.register_profile(
        profile,
        deadline=None,
        derandomize=True,
        max_examples=round(share * USUAL),
        suppress_health_check=[HealthCheck.too_slow],
    )
settings.load_profile("quick")

# A shell ignores interrupts in what it runs in the background, and children inherit that.
signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Order the tests for several workers; refuse one that is slow for no reason.

    Whole programs come first, so that none of these long tests is left to one worker in the end.
    Tests of a module whose fixtures they share run in one worker, which makes these once.

    Raises:
        UsageError: A test is slow for no reason.
    """
    items.sort(key=lambda item: item.path.parent != HERE)
    for item in items:
        if _shares_fixtures(item) and item.get_closest_marker("xdist_group") is None:
            item.add_marker(pytest.mark.xdist_group(str(item.path)))
        for mark in item.iter_markers("slow"):
            if not (len(mark.args) == 1 and isinstance(mark.args[0], str)):
                raise pytest.UsageError(f"{item.nodeid}: say why, as in slow('five more builds')")


def _shares_fixtures(item: pytest.Item) -> bool:
    known = getattr(item, "_fixtureinfo", None)
    definitions = known.name2fixturedefs.values() if known else ()
    return any(each[-1].scope == "module" for each in definitions)


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
