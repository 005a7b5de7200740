# SPDX-License-Identifier: Apache-2.0
"""The options that mean the same everywhere."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest

from fuzzy_fusion_ros.cli import options
from fuzzy_fusion_ros.offline.topics import Topics
from fuzzy_fusion_ros.parameters.arguments import Parser
from fuzzy_fusion_ros.parameters.errors import FusionError, UsageError
from fuzzy_fusion_ros.parameters.writing import OutputError


@pytest.fixture
def parser() -> Parser:
    """A parser with all of them."""
    made = Parser("tool", "Does things.")
    options.add_params(made)
    options.add_topics(made)
    options.add_window(made)
    options.add_seed(made, 7)
    options.add_json(made)
    options.add_plot(made)
    return made


def test_defaults_are_as_documented(parser: Parser) -> None:
    given = parser.parse_args([])
    assert options.topics_of(given) == Topics(fields={})
    assert options.window_of(given) == {"start": None, "end": None}
    assert (given.params, given.seed, given.json, given.plot) == (None, 7, None, None)


def test_topics_may_lack_their_slash(parser: Parser) -> None:
    given = parser.parse_args(["--s1", "imu", "--truth", "/mocap/tilt"])
    topics = options.topics_of(given)
    assert (topics.s1, topics.s2, topics.truth) == ("/imu", "/s2", "/mocap/tilt")


@pytest.mark.parametrize(
    ("arguments", "fields"),
    [
        (["--field", "data"], {"": "data"}),
        (["--field", "name=pole:position"], {"": "name=pole:position"}),
        (["--field", "s1=data"], {"s1": "data"}),
        (["--field", "/s1=name=pole:position"], {"s1": "name=pole:position"}),
        (["--s1", "/imu", "--field", "/imu=a.b"], {"s1": "a.b"}),
        (["--s1", "/x", "--s2", "/x", "--field", "/x=a"], {"s1": "a", "s2": "a"}),
        (["--field", "truth=x", "--field", "data"], {"truth": "x", "": "data"}),
        (["--field", "a", "--field", "b"], {"": "b"}),
    ],
)
def test_fields_belong_to_topics_or_to_all(
    parser: Parser, arguments: list[str], fields: dict[str, str]
) -> None:
    assert options.topics_of(parser.parse_args(arguments)).fields == fields


def test_a_field_of_a_topic_that_is_not_read_is_refused(parser: Parser) -> None:
    with pytest.raises(UsageError, match="topic /gyro is not read; the topics that are read: /s1"):
        options.topics_of(parser.parse_args(["--field", "/gyro=x"]))


@pytest.mark.parametrize(
    ("arguments", "span"),
    [
        (["--start", "1.5"], (1.5, None)),
        (["--end", "3"], (None, 3.0)),
        (["--start", "0", "--end", "1e3"], (0.0, 1000.0)),
    ],
)
def test_a_span(
    parser: Parser, arguments: list[str], span: tuple[float | None, float | None]
) -> None:
    assert tuple(options.window_of(parser.parse_args(arguments)).values()) == span


@pytest.mark.parametrize("arguments", [["--start", "2", "--end", "2"], ["--end", "0"]])
def test_an_empty_span_is_refused(parser: Parser, arguments: list[str]) -> None:
    with pytest.raises(UsageError, match="--end must be greater than --start, got"):
        options.window_of(parser.parse_args(arguments))


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        (["--start", "-1"], r"--start: got '-1', expected a number from 0 to 1e\+09"),
        (["--start", "nan"], "--start: got 'nan'"),
        (["--end", "inf"], "--end: got 'inf'"),
        (["--end", "soon"], "--end: got 'soon'"),
        (["--seed", "-1"], "--seed: got '-1', expected an integer from 0"),
        (["--seed", "1.5"], "--seed: got '1.5'"),
        (["--seed", str(2**32)], "--seed: got '4294967296'"),
        (["--sed", "1"], "unrecognized arguments: --sed 1"),
        (["--see", "1"], "unrecognized arguments: --see 1"),
        (["--json"], "--json: expected one argument"),
    ],
)
def test_bad_arguments_are_one_line(parser: Parser, arguments: list[str], problem: str) -> None:
    with pytest.raises(UsageError, match=f"{problem}.*; see fuzzy-fusion tool --help") as caught:
        parser.parse_args(arguments)
    assert "\n" not in str(caught.value)


def test_json_goes_into_a_file(tmp_path: Path) -> None:
    path = tmp_path / "new" / "score.json"
    options.write_json({"unit": "m/s²", "rmse": 0.1}, str(path))
    assert json.loads(path.read_text(encoding="utf-8")) == {"unit": "m/s²", "rmse": 0.1}


def test_json_goes_to_stdout(capsys: pytest.CaptureFixture[str]) -> None:
    options.write_json({"rmse": 0.1}, "-")
    assert json.loads(capsys.readouterr().out) == {"rmse": 0.1}


def test_json_holds_no_nan() -> None:
    with pytest.raises(ValueError, match="Out of range float"):
        options.write_json({"rmse": math.nan}, "-")


def test_a_file_that_cannot_be_written_is_the_users(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(OutputError, match=r"score\.json' cannot be written: "):
        options.write_json({}, str(tmp_path / "file" / "score.json"))


def test_results_that_cannot_be_written_are_refused_before_the_work(
    parser: Parser, tmp_path: Path
) -> None:
    def require(*arguments: str) -> None:
        given = parser.parse_args(arguments)
        options.require_results(given, given.plot)

    require("--json", "-", "--plot", str(tmp_path / "new" / "a.png"))
    assert list((tmp_path / "new").iterdir()) == []
    with pytest.raises(OutputError, match="cannot be written"):
        require("--json", str(tmp_path))
    with pytest.raises(FusionError, match="has an unknown format"):
        require("--plot", str(tmp_path / "a.doc"))
