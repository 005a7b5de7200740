# SPDX-License-Identifier: Apache-2.0
"""The tables of evaluate, where a method does not know its standard deviation."""

from __future__ import annotations

import math
from typing import Any

import pytest
from tuning.evaluate import line, markdown, sureness, sureness_table
from tuning.standins import standin

from fuzzy_fusion_ros.baselines import BaselineParameters, methods
from fuzzy_fusion_ros.batch.arrays import Flags

UNKNOWN = [math.nan] * 3


def row(ours: list[float], kalman: list[float]) -> dict[str, Any]:
    return {
        "kind": "drive",
        "seed": 0,
        "truth": True,
        "ours": 1.0,
        "constant": 1.0,
        "chosen": "observer",
        "correlation": 0.9,
        "others": {"s1": 2.0, "s2": 3.0},
        "picked": "s2",
        "sureness": {"ours": ours, "s1": UNKNOWN, "kalman_bias": kalman},
        "candidates": {},
        "seconds": 1.0,
    }


def test_sensors_do_not_know_their_standard_deviation() -> None:
    made = standin("turns_walk", 0)
    everywhere: Flags = made.truth == made.truth
    found = sureness(methods(BaselineParameters())["s1"], made, everywhere)
    assert all(map(math.isnan, found))


@pytest.mark.parametrize("ours", [UNKNOWN, [0.7, 0.9, 0.1]])
@pytest.mark.parametrize("kalman", [UNKNOWN, [0.7, 0.9, 0.2]])
def test_rows_are_printed_whatever_is_known(ours: list[float], kalman: list[float]) -> None:
    made = row(ours, kalman)
    assert f"1sd {ours[0]:.2f} " in line(made)
    last = sureness_table([made])[-1]
    assert f"{-ours[2]:.2f} | {-kalman[2]:.2f} | " in last
    assert ("`kalman_bias`" in last) == (kalman is not UNKNOWN)


def test_errors_have_a_row_for_each_way_of_tuning() -> None:
    made = row(UNKNOWN, UNKNOWN)
    rows = markdown([made, {**made, "truth": False, "constant": 3.0}])[2:]
    assert rows == [
        "| drive | yes | 2 | 2 `s1` | 1 | 0.50 | 0.33 `s2` | 1.00 |",
        "| drive | no | 2 | 2 `s1` | 1 | 0.50 | 0.33 `s2` | 3.00 |",
    ]
