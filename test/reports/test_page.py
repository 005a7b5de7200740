# SPDX-License-Identifier: Apache-2.0
"""The page itself: self-contained, small, and what is in it can be had out of it again."""

from __future__ import annotations

import base64
import json
import re
import zlib
from html.parser import HTMLParser
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fuzzy_fusion_ros.batch.arrays import Reals
from fuzzy_fusion_ros.messages.outputs import DEVIATION, RULES
from fuzzy_fusion_ros.parameters.errors import FusionError
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import replace
from fuzzy_fusion_ros.reports import page as pages
from fuzzy_fusion_ros.reports.charts import charts
from fuzzy_fusion_ros.reports.page import Line, Page, Table, packed, rendered, write_page
from fuzzy_fusion_ros.reports.rules import rule_base

LINES = tuple(Line(name, name, "#000000") for name in ("s1", "s2", "estimate", "truth"))


def made(series: dict[str, Reals], **changes: Any) -> Page:
    """Return a page of some series at 100 Hz."""
    n = len(next(iter(series.values())))
    page = Page(
        title="score of <bag> & co",
        lead="what was done",
        notes=["one note"],
        tables=[Table("scores", [["", "rmse"]], [["estimate", "0.1*"]])],
        facts=(),
        modes={"FUSED": 1.0},
        time_s=np.arange(n) * 0.01,
        series=series,
        charts=charts(LINES, "rad", series),
        rules=rule_base(Parameters(), "rad"),
        parameters="# </script> <!-- in a comment\n",
    )
    return page._replace(**changes)


def unpacked(text: str) -> Reals:
    """Return an array as the page unpacks it."""
    planes = np.frombuffer(zlib.decompress(base64.b64decode(text)), np.uint8).reshape(4, -1)
    return planes.T.copy().view("<f4").ravel().astype(float)


class Parts(HTMLParser):
    """The data of a page, the tags in it, and everything that it would fetch."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.fetched: list[str | None] = []
        self.data = ""
        self._in_data = False
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.fetched += [value for name, value in attrs if name in {"src", "href", "srcset"}]
        self._in_data = ("id", "data") in attrs

    def handle_data(self, data: str) -> None:
        if self._in_data:
            self.data += data


def document(page: Page) -> dict[str, Any]:
    """Return the document in a page."""
    found: dict[str, Any] = json.loads(Parts(rendered(page)).data)
    return found


def noise(n: int, names: tuple[str, ...] = ("s1", "s2", "estimate", "truth")) -> dict[str, Reals]:
    """Return series that nothing compresses."""
    generator = np.random.default_rng(0)
    return {name: generator.normal(size=n) for name in names}


def test_a_page_fetches_nothing_and_no_text_breaks_out_of_it() -> None:
    page = made(noise(5))
    parts = Parts(rendered(page))
    assert parts.fetched == []
    assert "default-src 'none'" in rendered(page)
    assert parts.tags.count("script") == 3
    assert "<title>score of &lt;bag&gt; &amp; co</title>" in rendered(page)
    assert json.loads(parts.data)["parameters"] == page.parameters


def test_a_name_that_is_no_utf_8_is_written(tmp_path: Path) -> None:
    write_page(made(noise(5), lead="bag \udcff"), tmp_path / "page.html")
    assert "\\udcff" in (tmp_path / "page.html").read_text(encoding="utf-8")


@pytest.mark.parametrize("values", [[1.5, -0.1, 3e38, 0.0], [np.nan, 1.0], [7.0]])
def test_arrays_come_out_as_they_went_in(values: list[float]) -> None:
    assert np.array_equal(unpacked(packed(np.array(values))), np.float32(values), equal_nan=True)


def test_the_time_of_each_sample_is_right_to_the_microsecond_after_an_hour() -> None:
    time_s = 3.25 + np.arange(90_000) * 0.04
    found = document(made(noise(90_000, ("s1",)), time_s=time_s))
    assert found["start_s"] + np.cumsum(unpacked(found["steps"])) == pytest.approx(time_s, abs=1e-4)


def test_ten_minutes_at_100_hz_are_less_than_3_mb() -> None:
    series = noise(60_000)
    series["s2"] = np.repeat(series["s2"][::10], 10)
    d, r = np.random.default_rng(1).uniform(size=(2, 60_000))
    strengths = np.array([(1 - d) * (1 - r), (1 - d) * r, d * (1 - r), d * r])
    series |= zip(RULES, pages.shares(strengths), strict=True)
    series |= {"weight": pages.shares(d), "drift": 0.1 * r, DEVIATION: 0.1 + d}
    assert len(rendered(made(series)).encode()) < 3e6


def test_of_a_long_recording_one_sample_in_several_is_shown(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(pages, "MOST_SAMPLES", 4)
    found = document(made({"s1": np.arange(9.0)}))
    assert unpacked(found["series"]["s1"]).tolist() == [0.0, 3.0, 6.0]
    assert unpacked(found["steps"]).tolist() == pytest.approx([0.0, 0.03, 0.03])
    assert found["notes"] == ["one note", "one sample in 3 is shown; the scores use all of them"]


def test_only_what_is_known_and_moves_is_drawn() -> None:
    rules = dict.fromkeys(RULES, np.zeros(3))
    names = [each.name for each in charts(LINES, "", {"weight": np.arange(3.0), **rules})]
    assert names == ["signal", "errors", "weight", "strengths"]
    assert [each.name for each in charts(LINES, "", {"drift": np.ones(3)})] == ["signal", "errors"]
    errors = charts(LINES, "", {})[1]
    assert errors.band == ""
    assert charts(LINES, "", {DEVIATION: np.ones(3)})[1].band == DEVIATION
    assert [(line.series, line.minus) for line in errors.lines] == [
        ("s1", "truth"),
        ("s2", "truth"),
        ("estimate", "truth"),
    ]


def test_surfaces_show_what_the_rules_conclude_at_their_corners() -> None:
    rules = Parameters().aggregator
    base = rule_base(Parameters(), "m/s")
    weight, drift = (each["values"] for each in base["surfaces"])
    assert (weight[0][0], weight[-1][0]) == (rules.weight.small, rules.weight.large)
    assert (weight[0][-1], weight[-1][-1]) == (rules.weight.very_small, rules.weight.very_large)
    assert (drift[0][0], drift[-1][0], drift[-1][-1]) == (0.0, rules.drift.large, 0.0)
    assert [each["unit"] for each in base["inputs"]] == ["m/s", "(m/s)/s"]
    for each, ramp in zip(base["inputs"], (rules.difference, rules.rate), strict=True):
        grades = dict(zip(each["values"], each["grades"], strict=True))
        assert (grades[ramp.small], grades[ramp.large]) == (0.0, 1.0)


def test_the_observers_rules_are_about_the_innovation_and_conclude_no_drift() -> None:
    base = rule_base(replace(Parameters(), {"s1.bias_time_constant": 1.0}), "m")
    assert base["inputs"][0]["title"] == "|innovation of S2|"
    assert [each["title"] for each in base["surfaces"]] == ["W1, the weight of S1"]
    assert {rule["drift"] for rule in base["rules"]} == {None}


def test_a_page_that_cannot_be_written_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(FusionError, match="cannot be written: Is a directory"):
        write_page(made(noise(2)), tmp_path)


def test_uplot_is_the_one_that_its_licence_came_with() -> None:
    folder = resources.files("fuzzy_fusion_ros.reports") / "uplot"
    script = (folder / "uPlot.iife.min.js").read_text(encoding="utf-8")
    assert re.match(r"/\*! https://github\.com/leeoniya/uPlot \(v1\.6\.32\) \*/\n", script)
    assert "The MIT License" in (folder / "LICENSE").read_text(encoding="utf-8")
    assert "MIT License, Copyright (c) 2022 Leon Sorokin" in rendered(made(noise(2)))
