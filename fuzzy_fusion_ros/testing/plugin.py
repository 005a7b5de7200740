# SPDX-License-Identifier: Apache-2.0
"""The fixtures that pytest finds wherever this package is installed."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from fuzzy_fusion_ros.testing.harness import Harness


@pytest.fixture
def ros_domain() -> Iterator[int]:
    """A free DDS domain, which this process and its children have joined; on this machine only."""
    from fuzzy_fusion_ros.testing.domain import (  # needs fcntl, which Windows lacks
        claimed_domain,
        environment,
        isolation,
    )

    with claimed_domain() as domain, environment(isolation(domain)):
        yield domain


@pytest.fixture
def fusion_harness(ros_domain: int) -> Iterator[Harness]:
    """A ROS graph of the test's own, to run nodes in and to feed them."""
    from fuzzy_fusion_ros.testing.harness import Harness  # imports rclpy, which few tests need

    with Harness(ros_domain) as harness:
        yield harness
