# SPDX-License-Identifier: Apache-2.0
"""The paper's Figs 6-23, drawn from their tables."""

from __future__ import annotations

from functools import partial
from typing import NamedTuple

import numpy as np
from matplotlib.figure import Figure

from fuzzy_fusion_ros.batch.arrays import integral_absolute_error, root_mean_square
from fuzzy_fusion_ros.paper.tables import RESPONSES, SWEPT, Table
from fuzzy_fusion_ros.plots.canvas import Canvas, canvas, outlined, put_legend, put_title
from fuzzy_fusion_ros.plots.names import COLOURS
from fuzzy_fusion_ros.plots.sweep_figures import draw_sweep
from fuzzy_fusion_ros.simulation.scenario import Scenario

START = (0.0, 3.0)
"""Span of the panel that shows the start, seconds."""

USUAL_REACH = 0.25
"""Responses that stay within this are drawn on one scale, rad."""

SENSORS = {
    "ideal": "an ideal sensor",
    "s1": "S1 alone",
    "s2": "S2 alone",
    "average": "the average of S1 and S2",
    "no_drift": "the aggregator without drift",
    "aggregator": "the aggregator",
    "complete": "aggregator and predictor",
}
"""The signal that each response is controlled on."""


class Line(NamedTuple):
    """How a column of a table is drawn over time: its legend and its style."""

    label: str
    colour: str
    width: float = 1.3
    dashes: str = "-"


def draw(number: int, table: Table) -> Figure:
    """Draw a figure of the paper; call this and save the result inside ``styled()``.

    Args:
        number: Its number, 6 to 23.
        table: What it shows, from :func:`fuzzy_fusion_ros.paper.tables.table_of`.
    """
    if number in SWEPT:
        return draw_sweep(number, table)
    if number in RESPONSES:
        return _response(number, table)
    return {12: _weight, 13: _drift, 14: _sensors, 15: _estimate, 17: _prediction}[number](table)


def _response(number: int, table: Table) -> Figure:
    method = RESPONSES[number]
    lines = {"angle_rad": Line("response", COLOURS[method])}
    iae = partial(integral_absolute_error, table["time_s"])
    text = f"IAE {iae(table['angle_rad']):.3g} rad s"
    if method != "ideal":
        lines["ideal_rad"] = Line("with an ideal sensor", COLOURS["ideal"], 0.9, "--")
        text += f", ideal sensor {iae(table['ideal_rad']):.2g} rad s"
    title = f"Fig. {number}: the pendulum, balanced on {SENSORS[method]}"
    reach = USUAL_REACH if np.max(np.abs(table["angle_rad"])) <= USUAL_REACH else None
    return _over_time(title, text, "angle, rad", table, lines, reach).figure


def _weight(table: Table) -> Figure:
    lines = {"weight_1": Line("W1", COLOURS["aggregator"], 0.9)}
    text = f"mean {np.mean(table['weight_1']):.2g}, largest {np.max(table['weight_1']):.2g}"
    title = "Fig. 12: W1, the weight of S1, rises while the signal moves"
    return _over_time(title, text, "weight", table, lines).figure


def _drift(table: Table) -> Figure:
    lines = {"added_rad": Line("drift, signed", COLOURS["aggregator"], 0.9)}
    text = f"largest {np.max(table['drift_rad']):.2g} rad"
    title = "Fig. 13: drift, added in the direction in which S2 moves"
    return _over_time(title, text, "drift, rad", table, lines).figure


def _sensors(table: Table) -> Figure:
    lines = {
        "s1_rad": Line("S1", COLOURS["s1"], 0.7),
        "s2_rad": Line("S2", COLOURS["s2"], 1.6),
        "angle_rad": Line("signal", COLOURS["truth"], 1.3),
    }
    errors = {name: table[name] - table["angle_rad"] for name in ("s1_rad", "s2_rad")}
    text = (
        f"S1 is off by {np.mean(errors['s1_rad']):.2g} rad on average and by "
        f"{np.std(errors['s1_rad']):.2g} rad from sample to sample; S2 lags"
    )
    title = "Fig. 14: the signal and both sensors"
    return _over_time(title, text, "angle, rad", table, lines).figure


def _estimate(table: Table) -> Figure:
    lines = {
        "estimate_rad": Line("estimate", COLOURS["aggregator"], 1.1),
        "angle_rad": Line("signal", COLOURS["truth"], 1.3),
    }
    error = table["estimate_rad"] - table["angle_rad"]
    text = f"RMS error {root_mean_square(error):.2g} rad"
    title = "Fig. 15: the signal and the aggregator's estimate"
    return _over_time(title, text, "angle, rad", table, lines).figure


def _prediction(table: Table) -> Figure:
    lines = {
        "aggregate_rad": Line("aggregator's output", COLOURS["aggregator"], 0.7),
        "prediction_rad": Line("prediction", COLOURS["complete"], 1.1),
        "angle_rad": Line("signal", COLOURS["truth"], 1.3),
    }
    rejected = np.asarray(table["rejected"], bool)
    share = np.mean(rejected)
    text = f"the gate rejects {share:.1%} of the predictions"
    title = "Fig. 17: the prediction, and where the gate rejects it"
    on = _over_time(title, text, "angle, rad", table, lines)
    for axes in on.panels:
        low, high = axes.get_xlim()
        t = table["time_s"][rejected]
        inside = t[(t >= low) & (t < high)]
        base = np.full(inside.size, 0.03)
        axes.plot(
            inside,
            base,
            "|",
            color=COLOURS["s2"],
            markersize=9,
            transform=axes.get_xaxis_transform(),
            label="rejected by the gate",
        )
    put_legend(on, 5)
    return on.figure


def _over_time(
    title: str,
    text: str,
    unit: str,
    table: Table,
    lines: dict[str, Line],
    reach: float | None = None,
) -> Canvas:
    """Draw columns over the whole run and, closer, at the start and around the disturbance."""
    push = Scenario().disturbance
    on = canvas("AA;BC;LL", (10.0, 10.0, 1.0), 580)
    panels = on.panels
    t = table["time_s"]
    spans = (float(t[0]), float(t[-1])), START, (push.start - 0.5, push.end + 2.4)
    for axes, (low, high) in zip(panels, spans, strict=True):
        inside = (t >= low) & (t <= high)
        for column, line in lines.items():
            axes.plot(
                t[inside],
                table[column][inside],
                line.dashes,
                color=line.colour,
                linewidth=line.width,
                label=line.label,
                path_effects=outlined(line.colour, line.width),
            )
        axes.axvspan(push.start, push.end, color="#F5C0A0", linewidth=0, label="push on the cart")
        axes.set_xlim(low, high)
        axes.set_xlabel("time, s")
        axes.set_ylabel(unit)
    panels[1].set_title("the start")
    panels[2].set_title("around the push")
    if reach is not None:
        panels[0].set_ylim(-reach, reach)
    put_legend(on, 5)
    put_title(on, title, text)
    return on
