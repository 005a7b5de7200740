# SPDX-License-Identifier: Apache-2.0
"""The benchmarks run. What they measure is no matter of tests."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from bench import (
    bags,
    estimator,
    fleet,
    growth,
    lockstep,
    memory,
    programs,
    replaying,
    startup,
    transport,
)
from bench.effort import TINY, Effort
from bench.table import Row, at_least, at_most, markdown


@pytest.mark.slow("each benchmark in its shortest form")
# scikit-fuzzy's own.
@pytest.mark.filterwarnings("ignore:Passing more than 2 positional:DeprecationWarning")
@pytest.mark.parametrize(
    "rows",
    [
        estimator.rows,
        transport.rows,
        lockstep.rows,
        startup.rows,
        replaying.rows,
        bags.rows,
        memory.rows,
        fleet.rows,
        growth.rows,
        programs.rows,
    ],
    ids=lambda each: each.__module__,
)
def test_a_benchmark_gives_rows(rows: Callable[[Effort], list[Row]]) -> None:
    found = rows(TINY._replace(repetitions=1))
    assert found
    assert all(row.figure >= 0.0 or row.aim is not None for row in found)
    assert markdown(found).count("\n") == len(found) + 1


def test_a_table_says_which_aims_are_met() -> None:
    met = Row("speed", "20 /s", "10 /s relay", 2.0, at_least(2.0))
    missed = Row("start", "3.00 s", "1.00 s relay", 2.0, at_most(1.0, "s more"))
    bare = Row("size", "3 MB", "6 MB theirs", 0.5)
    assert markdown([met, missed, bare]).splitlines() == [
        "| what | ours | against | ratio | aim | met? |",
        "|---|---|---|---|---|---|",
        "| speed | 20 /s | 10 /s relay | 2 | ≥ 2 | yes |",
        "| start | 3.00 s | 1.00 s relay | 2 s more | ≤ 1 s more | **no** |",
        "| size | 3 MB | 6 MB theirs | 0.5 |  |  |",
    ]
