# SPDX-License-Identifier: Apache-2.0
"""Sensors in other units than the signal's: scaled when read, back when written."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from bag.recorded import messages, read, swing, write_scalars

from fuzzy_fusion_ros.bag import open_bag
from fuzzy_fusion_ros.messages import InstalledTypes, ScalarCodec
from fuzzy_fusion_ros.offline.replay import replay
from fuzzy_fusion_ros.offline.topics import Topics
from fuzzy_fusion_ros.parameters.errors import ParameterError
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import replace

POINT = "geometry_msgs/msg/PointStamped"
DEGREE = math.pi / 180.0


def replayed(path: Path, output: Path, parameters: Parameters) -> Path:
    with open_bag(path) as bag:
        replay(bag, output, Topics(), parameters)
    return output


def test_the_estimate_is_in_the_unit_of_s2s_message_and_read_in_the_signals(
    tmp_path: Path,
) -> None:
    plain = write_scalars(tmp_path / "plain", swing(estimate=False))
    off = [
        each._replace(value=(each.value - 1.0) / DEGREE) if each.topic == "/s2" else each
        for each in swing(estimate=False)
    ]
    scaled = write_scalars(tmp_path / "scaled", off)
    parameters = replace(Parameters(), {"s2.scale": DEGREE, "s2.offset": 1.0})
    expected = replayed(plain, tmp_path / "out", Parameters())
    found = replayed(scaled, tmp_path / "degrees", parameters)
    codec = ScalarCodec(InstalledTypes(), POINT)
    raw = [codec.sample(each.data, 0).value for each in messages(found, ["/estimate"])]
    estimates = read(expected).estimate.values
    assert np.array(raw) * DEGREE + 1.0 == pytest.approx(estimates)
    assert read(found, parameters=parameters).estimate.values == pytest.approx(estimates)


def test_s1_may_be_negated(tmp_path: Path) -> None:
    scalars = swing(estimate=False)
    negated = [
        each._replace(value=-each.value) if each.topic == "/s1" else each for each in scalars
    ]
    parameters = replace(Parameters(), {"s1.scale": -1.0})
    plain, other = (
        write_scalars(tmp_path / name, each)
        for name, each in (("plain", scalars), ("negated", negated))
    )
    found = read(other, parameters=parameters)
    assert np.array_equal(found.series.s1, read(plain).series.s1)


def test_a_scale_of_zero_is_refused() -> None:
    with pytest.raises(ParameterError, match=r"s1\.scale: got 0\.0, expected any other number"):
        replace(Parameters(), {"s1.scale": 0.0})
