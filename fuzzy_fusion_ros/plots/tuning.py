# SPDX-License-Identifier: Apache-2.0
"""What ``tune --plot`` draws: fuzzy sets, control surfaces, and traces before and after."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from fuzzy_fusion_ros.batch.arrays import Reals, nearest, unwrapped
from fuzzy_fusion_ros.batch.series import Series, held_s2, seconds, trace_at_s1
from fuzzy_fusion_ros.core.aggregator import aggregate
from fuzzy_fusion_ros.core.membership import large
from fuzzy_fusion_ros.core.observer import observes
from fuzzy_fusion_ros.parameters.fusion import AggregatorParameters, BreakPoints, Parameters
from fuzzy_fusion_ros.plots.close_up import close_up
from fuzzy_fusion_ros.plots.names import COLOURS, NAMES, difference_name, with_unit
from fuzzy_fusion_ros.plots.style import WIDTH_PX, save, styled
from fuzzy_fusion_ros.tuning import Tuned
from fuzzy_fusion_ros.tuning.kernel import outputs

_DPI = 100
_HEIGHT_PX = 1150
_GRID = 60
_LEVELS = 20
_MOST_POINTS = 1500
"""Most samples drawn on a surface, and most points of a trace."""


class _Samples(NamedTuple):
    """Inputs of the rules over the recording, shape (n,) each."""

    difference: Reals
    rate: Reals


def plot_tuning(tuned: Tuned, series: Series, unit: str, path: str | Path) -> None:
    """Draw a fit into a file.

    Args:
        tuned: What came out.
        series: The recording.
        unit: Unit of the signal, ``""`` where it is not known.
        path: The file; its suffix names the format.

    Raises:
        FusionError: The file cannot be written or the format is unknown.
    """
    with styled():
        figure = Figure(
            figsize=(WIDTH_PX / _DPI, _HEIGHT_PX / _DPI), dpi=_DPI, layout="constrained"
        )
        FigureCanvasAgg(figure)
        grid = figure.add_gridspec(4, 2, height_ratios=(0.8, 1.2, 1.0, 0.8))
        samples = _samples(tuned.parameters, series)
        _draw_sets(figure.add_subplot(grid[0, 0]), tuned, "difference", samples.difference, unit)
        _draw_sets(figure.add_subplot(grid[0, 1]), tuned, "rate", samples.rate, unit)
        _draw_surface(figure.add_subplot(grid[1, 0]), tuned.parameters, samples, "weight", unit)
        _draw_surface(figure.add_subplot(grid[1, 1]), tuned.parameters, samples, "drift", unit)
        traces = [trace_at_s1(each, series) for each in (tuned.before, tuned.parameters)]
        estimates = [each.known(each.value) for each in traces]
        _draw_traces(figure.add_subplot(grid[2, :]), tuned, series, estimates, unit)
        _draw_errors(figure.add_subplot(grid[3, :]), tuned, series, estimates, unit)
        save(figure, path)


def _samples(parameters: Parameters, series: Series) -> _Samples:
    output = outputs(parameters, series)
    fused = np.isfinite(output.difference)
    return _Samples(output.difference[fused], output.rate[fused])


def _draw_sets(axes: Axes, tuned: Tuned, name: str, samples: Reals, unit: str) -> None:
    """Draw the two fuzzy sets of an input, before and after, over a histogram of its values."""
    after: BreakPoints = getattr(tuned.parameters.aggregator, name)
    before: BreakPoints = getattr(tuned.before.aggregator, name)
    reach = _reach(samples, after)
    if samples.size:
        counts, edges = np.histogram(np.minimum(samples, reach), bins=50, range=(0.0, reach))
        axes.stairs(counts / counts.max(), edges, fill=True, color=COLOURS["s1"], alpha=0.35)
    x = np.linspace(0.0, reach, 400)
    for ramp, style, when in ((before, ":", " before"), (after, "-", "")):
        grade = np.array([large(float(each), ramp) for each in x])
        axes.plot(x, 1.0 - grade, style, color=COLOURS["s2"], label=f"small{when}")
        axes.plot(x, grade, style, color=COLOURS["estimate"], label=f"large{when}")
    axes.set(
        xlabel=_label(tuned.parameters, name, unit),
        ylabel="grade",
        xlim=(0.0, reach),
        ylim=(-0.02, 1.05),
    )
    axes.legend(ncols=2, loc="lower left", bbox_to_anchor=(0.0, 1.0), borderaxespad=0.2)


def _draw_surface(
    axes: Axes, parameters: Parameters, samples: _Samples, name: str, unit: str
) -> None:
    """Draw W1 or the drift over both inputs, with the samples of the recording as dots."""
    rules = parameters.aggregator
    differences = np.linspace(0.0, _reach(samples.difference, rules.difference), _GRID)
    rates = np.linspace(0.0, _reach(samples.rate, rules.rate), _GRID)
    surface = np.array(
        [[_said(rules, float(d), float(r), name) for d in differences] for r in rates]
    )
    top = 1.0
    if name == "drift":
        top = max(rules.drift.large, rules.drift.small) or float(differences[-1])
    levels = np.linspace(0.0, top, _LEVELS + 1)
    mesh = axes.contourf(differences, rates, np.clip(surface, 0.0, top), levels, cmap="cividis")
    every = max(1, samples.rate.size // _MOST_POINTS)
    axes.plot(
        samples.difference[::every], samples.rate[::every], ".", color="#ffffff", ms=1.5, alpha=0.35
    )
    axes.set(
        xlabel=_label(parameters, "difference", unit),
        ylabel=_label(parameters, "rate", unit),
        xlim=(0.0, differences[-1]),
        ylim=(0.0, rates[-1]),
        title="W1, the weight of S1" if name == "weight" else _drift_title(rules),
    )
    axes.grid(False)
    label = "" if name == "weight" else unit.replace("^2", "²")
    axes.figure.colorbar(mesh, ax=axes, label=label, ticks=levels[:: _LEVELS // 5], format="%.2g")


def _drift_title(rules: AggregatorParameters) -> str:
    return "drift" if max(rules.drift.large, rules.drift.small) > 0.0 else "drift: none is used"


def _said(rules: AggregatorParameters, difference: float, rate: float, name: str) -> float:
    return float(getattr(aggregate(rules, difference, 0.0, rate), name))


def _draw_traces(
    axes: Axes, tuned: Tuned, series: Series, estimates: list[Reals], unit: str
) -> None:
    """Draw a close-up of where the signal varies most, with the estimates before and after."""
    s1_s, _ = seconds(series)
    s2 = held_s2(series)
    before, after = estimates
    near = close_up(s1_s, tuned.target, s2)
    period = tuned.parameters.signal.period
    shown = {
        "s1": (series.s1, NAMES["s1"]),
        "s2": (s2, NAMES["s2"]),
        "average": (before, "estimate before"),
        "estimate": (after, "estimate after"),
        "truth": (tuned.target, NAMES["truth"] if tuned.with_truth else "reference"),
    }
    for name, (values, label) in shown.items():
        width = {"s1": 0.6, "s2": 2.0, "truth": 0.9}.get(name, 1.4)
        drawn = without_turns(values, s2, period)
        axes.plot(s1_s[near], drawn[near], color=COLOURS[name], label=label, linewidth=width)
    axes.set(xlabel="time / s", ylabel=with_unit("signal", unit))
    axes.set_xlim(s1_s[near][0], s1_s[near][-1])
    axes.legend(ncols=5, loc="lower left", bbox_to_anchor=(0.0, 1.0), borderaxespad=0.2)


def without_turns(values: Reals, s2: Reals, period: float) -> Reals:
    """Return values as S2 would run if it did not wrap.

    Args:
        values: Finite or NaN, shape (n,).
        s2: S2, NaN before its first sample, shape (n,).
        period: A turn; 0 leaves the values as they are.

    Returns:
        Values whole turns away, NaN before the first sample of S2.
    """
    if period == 0.0:
        return values
    known = np.isfinite(s2)
    drawn = np.full(values.size, np.nan)
    drawn[known] = nearest(values[known], unwrapped(s2[known], period), period)
    return drawn


def _draw_errors(
    axes: Axes, tuned: Tuned, series: Series, estimates: list[Reals], unit: str
) -> None:
    """Draw the errors before and after over the whole recording."""
    s1_s, _ = seconds(series)
    every = max(1, s1_s.size // _MOST_POINTS)
    before, after = estimates
    for estimate, name, label, rmse in (
        (before, "average", "before", tuned.before_error),
        (after, "estimate", "after", tuned.error),
    ):
        error = np.where(tuned.counted, estimate - tuned.target, np.nan)
        label = with_unit(f"{label}, RMSE {rmse:.3g}", unit, " ")
        axes.plot(s1_s[::every], error[::every], color=COLOURS[name], label=label, linewidth=0.8)
    axes.set(xlabel="time / s", ylabel=with_unit("error", unit))
    axes.legend(ncols=2, loc="lower left", bbox_to_anchor=(0.0, 1.0), borderaxespad=0.2)


def _reach(samples: Reals, ramp: BreakPoints) -> float:
    """Return the largest value of an input to show: nearly all samples, and a ramp close by."""
    far = float(np.quantile(samples, 0.995)) if samples.size else 0.0
    return 1.1 * max(far, min(ramp.large, 3.0 * far) if far > 0.0 else ramp.large)


def _label(parameters: Parameters, name: str, unit: str) -> str:
    if name == "difference":
        return with_unit(difference_name(observes(parameters)), unit)
    per_s = f"({unit})/s" if "/" in unit else f"{unit}/s" if unit else "1/s"
    return with_unit("|dS2/dt|", per_s)
