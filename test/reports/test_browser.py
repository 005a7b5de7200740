# SPDX-License-Identifier: Apache-2.0
"""Pages in a real browser, on a phone and on a desk, in light and in dark."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from reports.browser import Browser, Screen, browser
from tuning.quick import be_quick
from tuning.recordings import Sensors, made

from fuzzy_fusion_ros.core.aggregator import aggregate
from fuzzy_fusion_ros.jobs.parameter_file import fusion_parameters, text_of
from fuzzy_fusion_ros.jobs.score import score
from fuzzy_fusion_ros.messages.outputs import RULES
from fuzzy_fusion_ros.reports.charts import charts
from fuzzy_fusion_ros.reports.page import write_page
from fuzzy_fusion_ros.reports.rules import BEYOND
from fuzzy_fusion_ros.reports.score import LINES, score_page
from fuzzy_fusion_ros.reports.tune import tune_page
from fuzzy_fusion_ros.scoring.score import Score
from fuzzy_fusion_ros.tuning import tune

pytestmark = pytest.mark.slow("starts a browser")

BAGS = Path(__file__).parents[2] / "bags"
SCREENS = [
    Screen(390, 844, "light"),
    Screen(390, 844, "dark"),
    Screen(1280, 900, "light"),
    Screen(1280, 900, "dark"),
]
LEGIBLE_PX = 12.0
CONTRAST = 4.5
"""Least contrast of text, as WCAG 2 asks for in level AA."""


@pytest.fixture(scope="module")
def window() -> Iterator[Browser]:
    """A browser."""
    with browser() as opened:
        yield opened


@pytest.fixture(scope="module")
def drive() -> Score:
    """The real drive, scored: 10 minutes at 100 Hz."""
    return score(BAGS / "car_accel", parameters=BAGS / "car_accel.yaml", unit="m/s^2")


@pytest.fixture(scope="module")
def page(drive: Score, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Its page."""
    path = tmp_path_factory.mktemp("page") / "car_accel.html"
    source = BAGS / "car_accel.yaml"
    write_page(score_page(drive, fusion_parameters(source), text_of(source)), path)
    assert path.stat().st_size < 3e6
    return path


def legend(window: Browser, chart: str) -> dict[str, str]:
    """Return what a chart says of the sample under the cursor, by the names of its lines."""
    rows = window.value(
        f"[...document.querySelectorAll('#chart-{chart} .u-series')].map(row => "
        "[row.querySelector('.u-label').textContent, row.querySelector('.u-value').textContent])"
    )
    return dict(rows)


def luminance(colour: list[int]) -> float:
    """Return the relative luminance of a colour, 0 to 1, as WCAG 2 defines it."""
    c = np.array(colour[:3]) / 255.0
    linear = np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)
    return float(linear @ [0.2126, 0.7152, 0.0722])


@pytest.mark.parametrize("screen", SCREENS, ids=lambda s: f"{s.width}-{s.scheme}")
def test_a_page_is_zoomed_and_shows_the_sample_under_the_cursor(
    window: Browser, drive: Score, page: Path, screen: Screen
) -> None:
    window.open(page, screen)
    assert window.value("document.documentElement.scrollWidth") <= screen.width
    window.drag("#chart-signal .u-over", 0.4, 0.6)
    spans = window.value("report.charts.map(each => [each.scales.x.min, each.scales.x.max])")
    assert spans == [spans[0]] * len(charts(LINES, "", drive.behind))
    low, high = spans[0]
    whole = drive.time_s[-1] - drive.time_s[0]
    assert high - low == pytest.approx(0.2 * whole, rel=0.1)
    assert low == pytest.approx(0.4 * whole, rel=0.1)

    window.point_at("#chart-errors .u-over", 0.5)
    k = window.value("report.idx")
    assert drive.time_s[k] == pytest.approx((low + high) / 2.0, abs=0.02 * (high - low))
    shown = {name: legend(window, name) for name in ("signal", "errors", "weight", "strengths")}
    assert shown["signal"].pop("time") == f"{drive.time_s[k]:.3f} s"
    signal = {"truth": drive.truth[k], **{n: drive.values[n][k] for n in ("s1", "s2", "estimate")}}
    labels = {"S1": "s1", "S2": "s2", "estimate": "estimate", "truth": "truth"}
    for label, name in labels.items():
        assert float(shown["signal"][label]) == pytest.approx(signal[name], rel=1e-5)
    error = signal["estimate"] - signal["truth"]
    assert float(shown["errors"]["estimate"]) == pytest.approx(error, abs=1e-5)
    deviation = drive.deviations["estimate"][k]
    assert float(shown["errors"]["+1 σ"]) == pytest.approx(deviation, rel=1e-5)
    assert float(shown["errors"]["−1 σ"]) == pytest.approx(-deviation, rel=1e-5)
    assert float(shown["weight"]["weight"]) == pytest.approx(drive.behind["weight"][k], abs=1e-3)
    for rule in RULES:
        strength = float(window.find(f"#{rule} b").text.removesuffix(" %"))
        assert strength == pytest.approx(100.0 * drive.behind[rule][k], abs=0.1)

    for title, share in (("zoom in", 0.5), ("later", 0.5), ("zoom out", 1.0)):
        window.find(f"button[title='{title}']").click()
        now_low, now_high = window.value(
            "[report.charts[0].scales.x.min, report.charts[0].scales.x.max]"
        )
        assert now_high - now_low == pytest.approx(share * (high - low))
    window.find("button[title='the whole recording']").click()
    assert window.value("report.charts[1].scales.x.max") == pytest.approx(drive.time_s[-1])

    window.point_at("figure canvas", 0.98)
    caption: str = window.value("document.querySelector('figcaption').textContent")
    at_mark = caption.rpartition("; ")[2].removesuffix(" at the mark")
    rules = fusion_parameters(BAGS / "car_accel.yaml").aggregator
    there = aggregate(
        rules, 0.98 * BEYOND * rules.difference.large, 0.0, 0.5 * BEYOND * rules.rate.large
    )
    assert float(at_mark) == pytest.approx(there.weight, rel=0.05)
    assert window.complaints() == []


def test_a_finger_moves_the_cursor_of_all_charts(window: Browser, drive: Score, page: Path) -> None:
    window.open(page, SCREENS[0])
    window.swipe("#chart-strengths .u-over", 0.2, 0.7)
    k = window.value("report.idx")
    assert drive.time_s[k] == pytest.approx(0.7 * drive.time_s[-1], rel=0.05)
    assert legend(window, "signal")["time"] == f"{drive.time_s[k]:.3f} s"
    assert window.complaints() == []


@pytest.mark.parametrize("screen", SCREENS, ids=lambda s: f"{s.width}-{s.scheme}")
def test_a_page_is_legible(window: Browser, page: Path, screen: Screen) -> None:
    window.open(page, screen)
    sizes = window.value(
        "[...document.querySelectorAll('h1,h2,h3,p,li,td,th,button,figcaption,summary,pre')]"
        ".map(each => parseFloat(getComputedStyle(each).fontSize))"
    )
    assert min(sizes) >= LEGIBLE_PX
    paper, *inks = window.value(
        "['--paper', '--ink', '--faint', '--mark'].map(name => { "
        "const e = document.createElement('i'); e.style.color = `var(${name})`; "
        "document.body.append(e); return getComputedStyle(e).color.match(/\\d+/g).map(Number); })"
    )
    assert (luminance(paper) < 0.1) == (screen.scheme == "dark")
    for ink in inks:
        dark, light = sorted((luminance(paper), luminance(ink)))
        assert (light + 0.05) / (dark + 0.05) >= CONTRAST
    assert window.complaints() == []


def test_the_page_of_a_fit_shows_sensors_candidates_and_what_came_before(
    window: Browser, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    be_quick(monkeypatch)
    series, truth = made(Sensors(bias=0.4, noise=0.1), seconds=20.0)
    path = tmp_path / "tune.html"
    write_page(
        tune_page(tune(series, truth), series, "rad", "a/bag", "bag, --seed 0", "# file"), path
    )
    window.open(path, SCREENS[0])
    assert window.find("h1").text == "fit to bag"
    text = window.find("main").text
    assert "S1: 25 Hz, white noise of" in text
    assert "(chosen)" in text
    sides = window.value(
        "Array.from(document.querySelectorAll('.wide tbody tr:first-child > *'), "
        "each => getComputedStyle(each).textAlign)"
    )
    assert sides == ["left", "right", "right", "left"]  # name, two numbers, text
    window.point_at("#chart-signal .u-over", 0.5)
    shown = legend(window, "signal")
    k = window.value("report.idx")
    assert list(shown) == ["time", "S1", "S2", "estimate before", "estimate after", "truth"]
    assert float(shown["S1"]) == pytest.approx(series.s1[k], rel=1e-5)
    assert float(shown["truth"]) == pytest.approx(truth[k], rel=1e-5, abs=1e-6)
    assert window.complaints() == []
