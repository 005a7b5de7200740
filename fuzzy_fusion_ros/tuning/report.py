# SPDX-License-Identifier: Apache-2.0
"""Results of tuning: in words, as comments of the parameter file, and as JSON."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from fuzzy_fusion_ros.batch.lag import GUESS_BELOW, SHARE_OF_SPAN
from fuzzy_fusion_ros.parameters.group import flatten
from fuzzy_fusion_ros.text.table import bag_table, text_table
from fuzzy_fusion_ros.tuning.candidates import HICCUP, LOST_AFTER, PAUSES
from fuzzy_fusion_ros.tuning.characterise import Characteristics
from fuzzy_fusion_ros.tuning.model_selection import ENOUGH_S2
from fuzzy_fusion_ros.tuning.tune import Tuned

WORSE = 1.001
"""The fit is worse than a sensor alone if its error is larger by more than rounding explains."""

MUCH_BETTER = 0.75
"""A filter whose error is below this share of ours shows that the fit has missed something."""

AS_FAST = 2.0
"""Up to this many intervals of S1 between its samples, S2 is as fast: its errors, such as those of
an accelerometer in motion, last for many of them."""

FAR_BETTER = 0.5
"""Below this share of the error of either sensor, the fusion helps even where the sensors show no
common motion, as in violent motion."""

HARDLY_BETTER = 0.9
"""An error after the fit above this share of that of the better sensor alone is hardly a gain."""


def described(sensors: Characteristics, unit: str) -> list[str]:
    """Return what the sensors are like, one line each.

    Args:
        sensors: Their characteristics.
        unit: Unit of the signal, ``""`` where it is not known.
    """
    u = f" {unit}" if unit else ""
    bias = "S1's bias" if sensors.clocks_agree and not sensors.moves_one_way else "S1 minus S2"
    per_s = f" {unit}/s" if unit and "/" not in unit else f" ({unit})/s" if unit else "/s"
    return [
        f"S1: {_rate(sensors.s1_interval)}, white noise of {sensors.s1_noise:.3g}{u} "
        f"(standard deviation), {_spikes(sensors)}",
        f"S2: {_rate(sensors.s2_interval)}{_gap(sensors)}{_delivery(sensors)}; "
        f"it changes by {sensors.rate:.3g}{per_s} (root mean square)",
        _lag(sensors),
        f"{bias} is {sensors.bias:+.3g}{u} on average; "
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


def recording_lines(tuned: Tuned, unit: str, names: Sequence[str]) -> list[str]:
    """Return how the fit does on each recording as the lines of a table; none for a single one.

    Args:
        tuned: The result of tuning.
        unit: Unit of the signal, ``""`` where it is not known.
        names: Names of the recordings.
    """
    if len(names) < 2:
        return []
    return [
        f"{error_title(tuned, unit)}, by recording; unseen is a fit to the others:",
        *bag_table(recording_rows(tuned, names)).splitlines(),
    ]


def recording_rows(tuned: Tuned, names: Sequence[str]) -> list[tuple[str, ...]]:
    """Return how the fit does on each recording as rows of a table, below one of headers."""
    rows: list[tuple[str, ...]] = [
        ("bag", "s1", "s2", "before", "after", "unseen", "best baseline")
    ]
    for name, each in zip(names, tuned.recordings, strict=True):
        errors = each.baseline_errors
        best = min(errors, key=errors.__getitem__)
        numbers = (
            errors["s1"],
            errors["s2"],
            each.before_error,
            each.error,
            each.unseen_error,
        )
        rows.append((name, *(f"{number:.4g}" for number in numbers), f"{best}, {errors[best]:.4g}"))
    return rows


def recording_notes(tuned: Tuned, unit: str, of_one_bag: bool = False) -> list[list[str]]:
    """Return for each recording what is wrong with it, or with the fit on it, one line each.

    Args:
        tuned: The result of tuning.
        unit: Unit of the signal, ``""`` where it is not known.
        of_one_bag: Whether all recordings are excerpts of one bag, and so of the same sensors.
    """
    u = f" {unit}" if unit else ""
    others, question = "recordings", "; are they of the same sensors?"
    if of_one_bag:
        others, question = "excerpts", ""
    notes = []
    for each in tuned.recordings:
        own = [f"unlike the other {others}: {text}{question}" for text in each.oddities]
        alone = min(("s1", "s2"), key=each.baseline_errors.__getitem__)
        if len(tuned.recordings) > 1 and each.error > WORSE * each.baseline_errors[alone]:
            own.append(
                f"here {alone} alone has an RMSE of {each.baseline_errors[alone]:.3g}{u}, "
                f"the fit {each.error:.3g}{u}"
            )
        notes.append(own)
    return notes


def outcome(tuned: Tuned, unit: str) -> str:
    """Return the gain in one line, with a warning where it is small or S2 has said too little.

    Args:
        tuned: The result of tuning.
        unit: Unit of the signal, ``""`` where it is not known.
    """
    u = f" {unit}" if unit else ""
    return (
        f"RMSE {tuned.before_error:.4g}{u} before, {tuned.error:.4g}{u} after; "
        f"S2 counts as lost after {tuned.parameters.s2.timeout:.3g} s"
        + _bound(tuned)
        + _adaptation(tuned)
        + _limits(tuned)
        + ("" if tuned.parameters.predictor.enabled else "; the predictor would not help")
        + (_WRONG_TRUTH if tuned.truth_is_wrong else _advice(tuned, u))
    )


_WRONG_TRUTH = (
    ". WARNING: a truth does not suit the sensors, so fit and errors mean nothing: correct it and "
    "tune again, or use --no-truth"
)


def _advice(tuned: Tuned, u: str) -> str:
    return _gain_over_one_sensor(tuned, u) + _better_filter(tuned, u) + _warning(tuned)


def _gain_over_one_sensor(tuned: Tuned, u: str) -> str:
    """Return what to do where the fusion hardly pays, ``""`` where it does."""
    if tuned.chosen in {"s1", "s2"}:
        return _alone(tuned, u)
    alone = min(("s1", "s2"), key=tuned.baseline_errors.__getitem__)
    error = tuned.baseline_errors[alone]
    if not tuned.sensors.related and tuned.error > FAR_BETTER * error:
        return (
            f". WARNING: s1 and s2 show no common motion, and this is not far better than {alone} "
            f"alone ({error:.4g}{u}): run check; are the fields right?"
        )
    if tuned.error <= HARDLY_BETTER * error:
        return ""
    how_much = "hardly" if tuned.error < error else "not"
    return (
        f". WARNING: this is {how_much} better than {alone} alone ({error:.4g}{u}): run check; "
        "is S2 right throughout, also at rest?"
    )


def _better_filter(tuned: Tuned, u: str) -> str:
    """Return which filter is much better than the fusion, if any is."""
    best = min(tuned.baseline_errors, key=tuned.baseline_errors.__getitem__)
    error = tuned.baseline_errors[best]
    if {"s1", "s2"} & {tuned.chosen, best} or error > MUCH_BETTER * tuned.error:
        return ""
    return (
        f". WARNING: the filter {best} is much better ({error:.4g}{u}): run check; "
        "is the scale of S1 that of S2?"
    )


def _alone(tuned: Tuned, u: str) -> str:
    """Return what a choice of one sensor means."""
    if not (tuned.with_truth or tuned.sensors.related):
        return (
            f". WARNING: {tuned.chosen} alone was taken because s1 and s2 show no common motion; "
            "the error says nothing: run check, or record a truth and tune to it"
        )
    errors = tuned.baseline_errors
    best = min(errors, key=errors.__getitem__)
    if best == tuned.chosen or errors[best] > HARDLY_BETTER * tuned.error:
        return f"; {tuned.chosen} alone is as good as anything: you do not need the node"
    return (
        f". WARNING: no fit was better than {tuned.chosen} alone, but the filter {best} is "
        f"({errors[best]:.4g}{u}): use that, or record a truth and tune to it"
    )


def _bound(tuned: Tuned) -> str:
    threshold = tuned.parameters.s2.outlier_threshold
    if threshold <= 0.0:
        return ""
    return f"; innovations of S2 are bounded at {threshold:g} of their standard deviations"


def _adaptation(tuned: Tuned) -> str:
    adapt = tuned.parameters.adapt
    scale = "; S1's scale is adapted" if adapt.scale_time_constant > 0.0 else ""
    return scale + ("; S2's lag is adapted" if adapt.lag_time_constant > 0.0 else "")


def _limits(tuned: Tuned) -> str:
    if not tuned.at_limit:
        return ""
    found = flatten(tuned.parameters)
    named = ", ".join(f"{each} {found[each]:.3g} s" for each in tuned.at_limit)
    return f"; at the upper end of the search range; the best value may be larger: {named}"


def _warning(tuned: Tuned) -> str:
    """Return why a fit without a truth may be worse than it seems."""
    if tuned.with_truth:
        return ""
    if tuned.s2_samples < ENOUGH_S2:
        return (
            f". WARNING: {tuned.s2_samples} samples of S2 and no truth cannot show which sensor is "
            f"better, so one alone may be better than this; record at least {ENOUGH_S2}"
        )
    if tuned.chosen == "s2":
        return ""
    if tuned.sensors.s2_interval <= AS_FAST * tuned.sensors.s1_interval:
        return (
            ". WARNING: S2 is as fast as S1, so its errors last for many samples, and without a "
            "truth they cannot be seen: record one, or compare this with what was given"
        )
    if tuned.error > tuned.before_error:
        return (
            ". WARNING: by this error what was given is better; without a truth it is uncertain: "
            "record one, or compare both"
        )
    return ""


def comments(tuned: Tuned, unit: str, origin: str, names: Sequence[str] = ()) -> Iterator[str]:
    """Yield the lines at the top of the parameter file.

    Args:
        tuned: The result of tuning.
        unit: Unit of the signal, ``""`` where it is not known.
        origin: The recordings and the target, in words.
        names: Names of the recordings; needless for one.
    """
    yield f"Made by tune from {origin}."
    yield ""
    yield from described(tuned.sensors, unit)
    yield ""
    yield from candidate_lines(tuned, unit)
    yield ""
    if names[1:]:
        yield from recording_lines(tuned, unit, names)
        yield ""
    yield outcome(tuned, unit)
    yield f"s2.timeout is {LOST_AFTER:g} intervals of S2, {PAUSES:g} usual pauses, or"
    yield f"{HICCUP[0]:g} s, and its delivery time; after that, conditioned S1 is used alone."
    yield "The entry `baselines` is for score --params; nodes ignore it."


def as_json(tuned: Tuned, unit: str, names: Sequence[str] = ()) -> dict[str, Any]:
    """Return the document of ``tune --json``; an unknown unit is null.

    Args:
        tuned: The result of tuning.
        unit: Unit of the signal, ``""`` where it is not known.
        names: Names of the recordings, if there are several: each then has an entry.
    """
    sensors = tuned.sensors._asdict()
    lag_is_identifiable = tuned.sensors.lag_is_identifiable
    sensors["lag"] = {**tuned.sensors.lag._asdict(), "identifiable": lag_is_identifiable}
    document = {
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
    if names[1:]:
        document["recordings"] = {
            name: {
                "samples": int(np.count_nonzero(each.counted)),
                "rmse_before": each.before_error,
                "rmse_after": each.error,
                "unseen_rmse": each.unseen_error,
                "baselines": each.baseline_errors,
                "odd": list(each.oddities),
            }
            for name, each in zip(names, tuned.recordings, strict=True)
        }
    return document


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


def _lag(sensors: Characteristics) -> str:
    """Return S2's lag in words, without a number where there is no measurement."""
    lag = sensors.lag
    why = _why_no_lag(sensors)
    if why:
        return f"S2's lag is not identifiable{why}"
    seen = (
        f" (seen through it, S1 and S2 correlate by {lag.correlation:.2f})"
        if lag.correlation >= GUESS_BELOW
        else "; this is a guess: seen through it, S1 explains little of S2 "
        f"(correlation {lag.correlation:.2f})"
    )
    return (
        f"S2 lags {lag.total:.2g} s behind S1: a delay of {lag.delay:.2g} s, "
        f"then a time constant of {lag.time_constant:.2g} s{seen}"
    )


def _why_no_lag(sensors: Characteristics) -> str:
    if sensors.lag_is_identifiable:
        return ""
    if not sensors.clocks_agree:
        return ", nor is S1's bias: the clocks that stamp S1 and S2 disagree"
    if sensors.moves_one_way:
        return (
            ", nor is S1's bias: the signal moves one way, and a lag of S2 then looks like a bias "
            "of S1; record motion both ways"
        )
    if not sensors.related:
        return (
            ": S1 and S2 have no more in common than unrelated signals "
            f"(correlation {sensors.lag.correlation:.2f})"
        )
    return (
        f": the search ended at its longest lag, {sensors.longest_lag:.2g} s; check the stamps "
        f"of S1 and S2, or record at least {1.0 / SHARE_OF_SPAN:.0f} times the lag"
    )
