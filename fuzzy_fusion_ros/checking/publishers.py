# SPDX-License-Identifier: Apache-2.0
"""Whether the messages of one topic come from two sensors."""

from __future__ import annotations

import re

import numpy as np

from fuzzy_fusion_ros.batch.arrays import Reals
from fuzzy_fusion_ros.checking.finding import Finding, Level
from fuzzy_fusion_ros.checking.samples import SensorSamples

REMEDY = "keep only one publisher on its topic"

FEWEST_RETURNS = 5
"""Frames come back less often where a driver restarts."""

MOST_NAMED = 3
"""Frames that are named."""

FEWEST = 40
"""Fewer samples are not judged."""

TURNS = 0.9
"""Share of the steps, at least, that go back where values alternate between two sensors; of white
noise, two thirds do."""

EVEN = (0.1, 0.9, 0.4)
"""These quantiles of the sizes of the steps are within this factor: two sensors are as far apart
all the time, noise is not."""


def judge_publishers(samples: SensorSamples, values: Reals) -> list[Finding]:
    """Judge whether two sensors share the topic of one.

    Args:
        samples: Of the sensor.
        values: The usable ones without wraps and spikes, shape (n,).
    """
    return _elements(samples) or _frames(samples) or _levels(samples.name, values)


def _elements(samples: SensorSamples) -> list[Finding]:
    """Judge whether an element of an array, taken by its index, always has the same name."""
    if len(samples.elements) < 2:
        return []
    first, other, *_ = samples.elements
    text = (
        f"{samples.field} of {samples.name} is {first!r} in some messages and {other!r} in others"
    )
    by_name = re.sub(r"(\w+)\[\d+\]$", rf"name={first}:\1", samples.field)
    return [Finding(Level.WARNING, "element", text, {}, f"the field {by_name}")]


def _frames(samples: SensorSamples) -> list[Finding]:
    """Judge whether frames alternate."""
    different = list(dict.fromkeys(samples.frames))
    if len(samples.frames) - len(different) < FEWEST_RETURNS:
        return []
    more = len(different) - MOST_NAMED
    named = ", ".join(map(repr, different[:MOST_NAMED])) + (f" and {more} more" if more > 0 else "")
    text = f"messages of {samples.name} alternate between frame_ids: {named}"
    return [Finding(Level.WARNING, "publishers", text, {}, REMEDY)]


def _levels(name: str, values: Reals) -> list[Finding]:
    """Judge whether values go back and forth by the same amount, from each to the next."""
    if values.size < FEWEST:
        return []
    steps = np.diff(values)
    turns = float(np.mean(steps[1:] * steps[:-1] < 0.0))
    low, high = np.quantile(np.abs(steps), EVEN[:2])
    if turns < TURNS or low < EVEN[2] * high:
        return []
    apart = float(np.median(np.abs(steps)))
    text = f"values of {name} alternate by {apart:.2g}, as those of two sensors on one topic do"
    return [Finding(Level.WARNING, "publishers", text, {"share of steps back": turns}, REMEDY)]
