# SPDX-License-Identifier: Apache-2.0
"""Results of tuning: in words, as comments of the parameter file, and as JSON."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from fuzzy_fusion_ros.batch.lag import TRUSTED
from fuzzy_fusion_ros.parameters.group import flatten
from fuzzy_fusion_ros.text.table import text_table
from fuzzy_fusion_ros.tuning.candidates import LOST_AFTER
from fuzzy_fusion_ros.tuning.characterise import Characteristics
from fuzzy_fusion_ros.tuning.tune import Tuned


def described(sensors: Characteristics, unit: str) -> list[str]:
    """Return what the sensors are like, one line each.

    Args:
        sensors: Their characteristics.
        unit: Unit of the signal, ``""`` where it is not known.
    """
    u = f" {unit}" if unit else ""
    per_s = f" {unit}/s" if unit and "/" not in unit else f" ({unit})/s" if unit else "/s"
    return [
        f"S1: {_rate(sensors.s1_interval)}, white noise of {sensors.s1_noise:.3g}{u} "
        f"(standard deviation), {_spikes(sensors)}",
        f"S2: {_rate(sensors.s2_interval)}{_gap(sensors)}{_delivery(sensors)}; "
        f"it changes by {sensors.rate:.3g}{per_s} (root mean square)",
        f"S2 lags {sensors.lag.total:.2g} s behind S1: a delay of {sensors.lag.delay:.2g} s, "
        f"then a time constant of {sensors.lag.time_constant:.2g} s{_trust(sensors)}",
        f"S1's bias is {sensors.bias:+.3g}{u} on average; "
        f"it drifts by {sensors.drift:+.2g}{per_s}, and scatters about that by "
        f"{sensors.wander:.3g}{u} (standard deviation)",
        f"S1 and S2 are typically {sensors.difference:.3g}{u} apart",
    ]


def candidate_lines(tuned: Tuned, unit: str) -> list[str]:
    """Return the candidates and the baselines as the lines of a table.

    Args:
        tuned: The result of tuning.
        unit: Unit of the signal, ``""`` where it is not known.
    """
    return [
        f"{error_title(tuned, unit)}:",
        *text_table(candidates(tuned), align="lrrl").splitlines(),
    ]


def error_title(tuned: Tuned, unit: str) -> str:
    """Return what the errors of the candidates are, in words."""
    against = "truth" if tuned.with_truth else "reference made from both sensors"
    return f"RMSE{f' in {unit}' if unit else ''} against the {against}"


def candidates(tuned: Tuned) -> list[tuple[str, str, str, str]]:
    """Return the candidates and the baselines as rows of a table, below one of headers."""
    best = min(tuned.baseline_errors, key=tuned.baseline_errors.__getitem__)
    rows = [("candidate", "fitted", "unseen", "")]
    rows += [
        (
            each.name,
            f"{each.fitted:.4g}",
            f"{each.unseen:.4g}",
            each.text
            + (" (chosen)" if each.name == tuned.chosen else "")
            + (", the best baseline" if each.name == best else ""),
        )
        for each in tuned.candidates
    ]
    rows += [
        (name, f"{error:.4g}", "", "the best baseline" if name == best else "baseline")
        for name, error in tuned.baseline_errors.items()
        if name not in {"s1", "s2"}
    ]
    return rows


def outcome(tuned: Tuned, unit: str) -> str:
    """Return the gain in one line.

    Args:
        tuned: The result of tuning.
        unit: Unit of the signal, ``""`` where it is not known.
    """
    u = f" {unit}" if unit else ""
    return (
        f"RMSE {tuned.before_error:.4g}{u} before, {tuned.error:.4g}{u} after; "
        f"S2 counts as lost after {tuned.parameters.s2.timeout:.3g} s"
        + ("" if tuned.parameters.predictor.enabled else "; the predictor would not help")
    )


def comments(tuned: Tuned, unit: str, origin: str) -> Iterator[str]:
    """Yield the lines at the top of the parameter file.

    Args:
        tuned: The result of tuning.
        unit: Unit of the signal, ``""`` where it is not known.
        origin: The recording and the target, in words.
    """
    yield f"Made by tune from {origin}."
    yield ""
    yield from described(tuned.sensors, unit)
    yield ""
    yield from candidate_lines(tuned, unit)
    yield ""
    yield outcome(tuned, unit)
    yield f"s2.timeout is {LOST_AFTER:g} intervals of S2 and its delivery time; after that,"
    yield "conditioned S1 is used alone."
    yield "The entry `baselines` is for score --params; nodes ignore it."


def as_json(tuned: Tuned, unit: str) -> dict[str, Any]:
    """Return the document of ``tune --json``; an unknown unit is null.

    Args:
        tuned: The result of tuning.
        unit: Unit of the signal, ``""`` where it is not known.
    """
    sensors = tuned.sensors._asdict()
    sensors["lag"] = tuned.sensors.lag._asdict()
    return {
        "unit": unit or None,
        "with_truth": tuned.with_truth,
        "samples": int(np.count_nonzero(tuned.counted)),
        "characteristics": sensors,
        "candidates": [
            {"name": each.name, "fitted_rmse": each.fitted, "unseen_rmse": each.unseen}
            for each in tuned.candidates
        ],
        "chosen": tuned.chosen,
        "rmse_before": tuned.before_error,
        "rmse_after": tuned.error,
        "parameters": flatten(tuned.parameters),
        "baselines": {
            "rmse": tuned.baseline_errors,
            "parameters": flatten(tuned.baselines),
        },
    }


def _spikes(sensors: Characteristics) -> str:
    if sensors.has_spikes:
        return f"{100.0 * sensors.spike_share:.2g} % spikes, which are rejected"
    return "no spikes"


def _rate(interval: float) -> str:
    """Return a rate in words; a slow one as the interval."""
    return f"{1.0 / interval:.3g} Hz" if interval <= 1.0 else f"one sample in {interval:.3g} s"


def _delivery(sensors: Characteristics) -> str:
    if sensors.s2_delivery > sensors.s2_interval:
        return f", delivered up to {sensors.s2_delivery:.2g} s after the measurement"
    return ""


def _gap(sensors: Characteristics) -> str:
    if sensors.s2_gap > LOST_AFTER * sensors.s2_interval:
        return f", with gaps of up to {sensors.s2_gap:.3g} s"
    return ""


def _trust(sensors: Characteristics) -> str:
    correlation = sensors.lag.correlation
    if sensors.moves_one_way:
        return (
            "; this is meaningless, and so is the bias: the signal moves one way, and a lag of S2 "
            "then looks like a bias of S1; record motion both ways"
        )
    if not sensors.related:
        return (
            f"; this is meaningless: S1 and S2 have no more in common than unrelated signals "
            f"(correlation {correlation:.2f})"
        )
    if correlation < TRUSTED:
        return (
            f"; this is a guess: seen through it, S1 explains little of S2 "
            f"(correlation {correlation:.2f})"
        )
    return f" (seen through it, S1 and S2 correlate by {correlation:.2f})"
