# SPDX-License-Identifier: Apache-2.0
"""Who makes messages."""

from __future__ import annotations

import functools

import pytest
from messages.worlds import Rclpy, Rosbags, World


@functools.cache
def worlds() -> dict[str, World]:
    return {"rclpy": Rclpy(), "rosbags": Rosbags()}


@pytest.fixture(params=["rclpy", "rosbags"])
def world(request: pytest.FixtureRequest) -> World:
    """Each maker of messages in turn."""
    return worlds()[request.param]


@pytest.fixture
def rclpy() -> World:
    """Messages that rclpy would publish."""
    return worlds()["rclpy"]


@pytest.fixture
def rosbags() -> World:
    """Messages that rosbags would read, also of types that nobody installed."""
    return worlds()["rosbags"]
