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


@pytest.hookimpl(tryfirst=True)  # before xdist reads the groups
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Order the tests for several workers; refuse one that is slow for no reason.

    Tests of a module whose fixtures they share run in one worker, which makes these once. Such
    modules come before single tests, and whole programs before all: none of what takes long is
    left to one worker in the end.

    Raises:
        UsageError: A test is slow for no reason.
    """
    for item in items:
        if _shares_fixtures(item) and item.get_closest_marker("xdist_group") is None:
            group = str(item.path.relative_to(HERE.parent))
            item.add_marker(pytest.mark.xdist_group(group))
        for mark in item.iter_markers("slow"):
            if not (len(mark.args) == 1 and isinstance(mark.args[0], str)):
                raise pytest.UsageError(f"{item.nodeid}: say why, as in slow('five more builds')")
    items.sort(key=lambda item: (item.path.parent != HERE, not _is_grouped(item)))


def _is_grouped(item: pytest.Item) -> bool:
    return item.get_closest_marker("xdist_group") is not None


def _shares_fixtures(item: pytest.Item) -> bool:
    known = getattr(item, "_fixtureinfo", None)
    definitions = known.name2fixturedefs.values() if known else ()
    return any(each[-1].scope == "module" for each in definitions)


# Imports of rclpy are in the fixtures, so that tests of the method start without it.
@pytest.fixture
def harness(monkeypatch: pytest.MonkeyPatch) -> Iterator[Harness]:
    """A ROS graph of the test's own, whose nodes shed nothing because the machine is slow."""
    from fuzzy_fusion_ros.ros import backlog
    from fuzzy_fusion_ros.testing import Harness

    monkeypatch.setattr(backlog, "LATE", 60.0)
    with Harness() as opened:
        yield opened


@pytest.fixture
def log(harness: Harness) -> Log:
    """What nodes log."""
    from nodes.watching import Log

    return Log(harness)


@pytest.fixture
def diagnostics(harness: Harness, monkeypatch: pytest.MonkeyPatch) -> Diagnostics:
    """What nodes publish on /diagnostics: ten times a second, so that tests wait less."""
    from nodes.watching import Diagnostics

    from fuzzy_fusion_ros.ros import diagnostics

    monkeypatch.setattr(diagnostics, "PERIOD", 0.1)
    return Diagnostics(harness)
