# SPDX-License-Identifier: Apache-2.0
"""How many examples tests of properties try."""

from __future__ import annotations

from hypothesis import settings

USUAL = 100
"""Examples in a thorough run, where a test does not say."""

QUICK = 0.25
"""Share of them in a quick run."""

FEWEST = 10
"""A quick run tries this many, or all that a test asks for if those are fewer."""


def examples(count: int) -> settings:
    """Return settings for a number of examples in a thorough run, and a share of it in a quick one.

    Args:
        count: In a thorough run.
    """
    share = count * settings().max_examples // USUAL
    return settings(max_examples=max(min(count, FEWEST), share))
