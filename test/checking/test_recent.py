# SPDX-License-Identifier: Apache-2.0
"""The check of the most recent samples."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest

from fuzzy_fusion_ros.checking import recent
from fuzzy_fusion_ros.checking.recent import Stream, check_recent, warnings
from fuzzy_fusion_ros.messages import InstalledTypes, ScalarCodec
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import replace

CODEC = ScalarCodec(InstalledTypes(), "geometry_msgs/msg/PointStamped")
TEMPERATURE = ScalarCodec(InstalledTypes(), "sensor_msgs/msg/Temperature")


def motion(time_s: float) -> float:
    return math.sin(time_s) + math.sin(2.3 * time_s + 1.0) + 0.01 * math.sin(1e6 * time_s)


def filled(name: str, factor: float, lag: float, every: int, samples: int = 6000) -> Stream:
    stream = Stream(name, f"/{name}", CODEC)
    for k in range(0, samples, every):
        at_ns = 10**18 + k * 10**7
        stream.add(at_ns, at_ns + 10**6, factor * motion(0.01 * k - lag))
    return stream


def said(s1: Stream, s2: Stream) -> list[str]:
    return [each.about for each in warnings(check_recent(s1.samples(), s2.samples(), Parameters()))]


def test_what_is_wrong_is_found_in_recent_samples() -> None:
    good = filled("s2", 1.0, 0.2, 10)
    assert said(filled("s1", 1.0, 0.0, 1), good) == []
    assert said(filled("s1", -1.0, 0.0, 1), good) == ["sign"]
    assert said(filled("s1", 57.3, 0.0, 1), good) == ["scale"]


def test_a_restart_forgets_and_silence_is_not_repeated() -> None:
    s1, s2 = filled("s1", -1.0, 0.0, 1), filled("s2", 1.0, 0.2, 10)
    s1.restart()
    assert s1.samples().values.size == 0
    assert said(s1, s2) == []  # the report of the sensor says that it is silent


def test_memory_is_bounded_and_the_newest_are_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(recent, "SAMPLES", 100)
    samples = filled("s1", 1.0, 0.0, 1, 250).samples()
    assert samples.stamps_ns.size == 100
    assert samples.stamps_ns[-1] == 10**18 + 249 * 10**7
    assert all(after - before == 10**7 for before, after in pairwise(samples.stamps_ns))


def test_units_are_those_of_the_types_unless_the_parameters_name_one() -> None:
    pressure = ScalarCodec(InstalledTypes(), "sensor_msgs/msg/FluidPressure")
    streams = []
    for name, codec in (("s1", pressure), ("s2", TEMPERATURE)):
        stream = Stream(name, f"/{name}", codec)
        for k in range(100):
            stream.add(10**18 + k * 10**7, 10**18 + k * 10**7, motion(0.01 * k))
        streams.append(stream)
    found = check_recent(streams[0].samples(), streams[1].samples(), Parameters()).findings
    assert "s1 is in Pa, s2 in degC" in {each.text for each in found}
    named = replace(Parameters(), {"signal.unit": "K"})
    found = check_recent(streams[0].samples(), streams[1].samples(), named).findings
    assert "units" not in {each.about for each in found}
