# SPDX-License-Identifier: Apache-2.0
"""What a check says, as text and as JSON."""

from __future__ import annotations

import json
import math

import numpy as np
from checking.made import both, sensor

from fuzzy_fusion_ros.checking.finding import Finding, Level
from fuzzy_fusion_ros.checking.report import check_json, check_text

TIMES = 0.01 * np.arange(3000)
VALUES = np.sin(TIMES) + np.sin(2.3 * TIMES)
S2 = sensor("s2", TIMES[::10], VALUES[::10] + 1e-3, unit="rad", field="angle")


def test_nothing_is_wrong() -> None:
    text = check_text(both(sensor("s1", TIMES, VALUES), S2))
    lines = text.splitlines()
    assert lines[:2] == ["s1 is /s1 data", "s2 is /s2 angle rad"]
    assert max(map(len, lines)) <= 80
    rows = {line[:17].strip(): line[17:].split() for line in lines[3:14]}
    assert rows["samples"] == ["3000", "300"]
    assert rows["rate"] == ["100", "Hz", "10", "Hz"]
    assert rows["longest gap"] == ["0.01", "s", "0.1", "s"]
    assert rows["spikes"] == ["0.0", "%", "0.0", "%"]
    assert lines[-1] == "no problems found"


def test_what_is_wrong_comes_last_the_worst_first() -> None:
    values = -VALUES
    values[10] = math.nan
    text = check_text(both(sensor("s1", TIMES, values), S2))
    assert (
        "\n\nERROR   s1 has the opposite sign of s2 (correlation -1); fix: s1.scale: -1\n" in text
    )
    assert text.endswith("WARNING 1 of 3000 samples of s1 are dropped: value is not finite")


def test_a_lag_of_little_correlation_is_called_a_guess() -> None:
    found = both(sensor("s1", TIMES, VALUES), S2)
    assert found.relation is not None
    assert "guess" not in check_text(found)
    text = check_text(found._replace(relation=found.relation._replace(correlation=0.54)))
    assert " s (a guess); correlation 0.540" in text


def test_json_is_finite_and_complete() -> None:
    found = both(sensor("s1", TIMES, -VALUES), S2)
    document = json.loads(json.dumps(check_json(found), allow_nan=False))
    assert document["sensors"]["s1"]["samples"] == 3000
    assert document["s2_behind_s"] == 0.0
    assert document["relation"]["sign"] == -1
    (finding,) = document["findings"]
    assert finding["level"] == "error"
    assert finding["about"] == "sign"
    assert finding["remedy"] == "s1.scale: -1"
    assert finding["evidence"]["correlation"] < -0.99
    nothing = check_json(both(sensor("s1", [], []), sensor("s2", [], [])))
    assert nothing["relation"] is None
    assert nothing["s2_behind_s"] is None
    json.dumps(nothing, allow_nan=False)


def test_a_finding_on_one_line() -> None:
    finding = Finding(
        Level.ERROR, "sign", "it is negated", {"correlation": -0.98765}, "s1.scale: -1"
    )
    assert str(finding) == "it is negated (correlation -0.988); fix: s1.scale: -1"
    assert str(Finding(Level.INFO, "x", "it is so", {})) == "it is so"
    endless = Finding(Level.INFO, "x", "it is so", {"ratio": math.inf})
    assert endless.as_json()["evidence"] == {"ratio": None}
