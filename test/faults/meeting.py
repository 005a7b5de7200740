# SPDX-License-Identifier: Apache-2.0
"""Both ends of a connection between processes have to know each other before anything counts."""

from __future__ import annotations

from std_srvs.srv import Trigger

from fuzzy_fusion_ros.testing import Feed, Harness


def meet(harness: Harness, feed: Feed) -> None:
    """Feed a fusion_node of another process until it answers, then let it forget all but counts.

    A publisher knows of a subscription before that knows of it, and what is sent in between is
    lost.

    Raises:
        TimeoutError: It does not answer.
    """
    sent = 0

    def answered() -> bool:
        nonlocal sent
        sent += 1
        feed.send(1e-6 * sent, s1=0.0, s2=0.0)
        return bool(feed.estimates)

    harness.spin_until(answered, "an answer")
    response = harness.call(Trigger, "/fusion_node/reset", Trigger.Request())
    assert response.success
    last = feed(1e-6 * (sent + 1), s1=0.0, s2=0.0)
    assert last == 0.0
    assert harness.call(Trigger, "/fusion_node/reset", Trigger.Request()).success
