# SPDX-License-Identifier: Apache-2.0
"""An executor is served for a time."""

from __future__ import annotations

from rclpy.context import Context

from fuzzy_fusion_ros.ros.spinning import executor_for, serve


def test_one_call_serves_all_that_is_due() -> None:
    context = Context()
    context.init([])
    executor = executor_for(context)
    served: list[int] = []
    for k in range(3):
        executor.create_task(served.append, k)
    serve(executor, 0.05)
    assert served == [0, 1, 2]
    executor.shutdown()
    context.try_shutdown()
