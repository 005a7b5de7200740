"""What tests of nodes share: a graph for each test, and what nodes say about themselves."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from nodes.watching import Diagnostics, Log

from fuzzy_fusion_ros.testing import Harness


@pytest.fixture
def harness() -> Iterator[Harness]:
    """A graph of its own."""
    with Harness() as opened:
        yield opened


@pytest.fixture
def log(harness: Harness) -> Log:
    """What nodes log."""
    return Log(harness)


@pytest.fixture
def diagnostics(harness: Harness) -> Diagnostics:
    """What nodes say on /diagnostics."""
    return Diagnostics(harness)
