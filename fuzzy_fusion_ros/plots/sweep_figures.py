# SPDX-License-Identifier: Apache-2.0
"""The paper's Figs 18-23: IAE and ITAE of each method over the sweeps."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter, StrMethodFormatter

from fuzzy_fusion_ros.paper.checks import SYMBOLS
from fuzzy_fusion_ros.paper.sweep import NOMINAL, SWEEPS
from fuzzy_fusion_ros.paper.tables import SWEPT, Table
from fuzzy_fusion_ros.plots.canvas import canvas, outlined, put_legend, put_title
from fuzzy_fusion_ros.plots.names import COLOURS, NAMES

QUANTITIES = {"iae": ("IAE", "rad s"), "itae": ("ITAE", "rad s²")}
SWEPT_NAMES = {
    "tau2": "time constant of S2",
    "sigma1": "standard deviation of S1's noise",
    "bias1": "bias of S1",
}

MARKERS = {
    "ideal": "",
    "s1": "x",
    "s2": "s",
    "average": "D",
    "no_drift": "v",
    "aggregator": "^",
    "complete": "o",
    "complementary": "P",
    "kalman": "*",
}
PAPERS = ("s2", "average", "complete")
"""The methods in the paper's own figures; the others are drawn lighter."""

LABELS = {
    **NAMES,
    "complete": "fusion: aggregator and predictor",
    "kalman": "Kalman filter that knows the plant",
}


def draw_sweep(number: int, table: Table) -> Figure:
    """Draw IAE or ITAE over the swept quantity, Figs 18-23; as ``paper_figures.draw``."""
    swept, quantity = SWEPT[number]
    on = canvas("A;L", (10.0, 2.0), 620)
    (axes,) = on.panels
    for method in dict.fromkeys(table["method"].tolist()):
        _draw_method(axes, method, swept, table)
    unit = SYMBOLS[swept][1]
    name, of = QUANTITIES[quantity]
    axes.axvline(getattr(NOMINAL, swept), color="#BBBBBB", linestyle=":", zorder=0)
    axes.set_yscale("log")
    axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axes.yaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
    axes.yaxis.set_minor_formatter(NullFormatter())
    axes.set_xticks(SWEEPS[swept])
    axes.set_xlabel(f"{SWEPT_NAMES[swept]}, {unit} (dotted: nominal)")
    axes.set_ylabel(f"{name}, {of}")
    put_legend(on, 3)
    runs = int(table["runs"][0])
    title = f"Fig. {number}: {name} over the {SWEPT_NAMES[swept]}, parameters unchanged"
    text = f"mean and 95 % interval of {runs} runs a point"
    if np.any(table["fell"]):
        text += "; hollow: the pendulum fell"
    put_title(on, title, text)
    return on.figure


def _draw_method(axes: Axes, method: str, swept: str, table: Table) -> None:
    mine = table["method"] == method
    x, mean, low, high, fell = (table[n][mine] for n in (swept, "mean", "low", "high", "fell"))
    colour = COLOURS[method]
    if method == "ideal":
        axes.plot(x, mean, "--", color=colour, linewidth=0.9, label=LABELS[method])
        return
    width = 2.2 if method in PAPERS else 1.1
    axes.errorbar(
        x,
        mean,
        yerr=np.array([mean - low, high - mean]),
        color=colour,
        marker=MARKERS[method],
        markersize=7,
        linewidth=width,
        path_effects=outlined(colour, width),
        capsize=3,
        label=LABELS[method],
        zorder=3 if method in PAPERS else 2,
    )
    some = fell > 0
    axes.plot(x[some], mean[some], MARKERS[method], color=colour, mfc="white", ms=7, zorder=4)
