# SPDX-License-Identifier: Apache-2.0
"""The command score."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest
from bag.recorded import swing, write_scalars
from tuning.quick import be_quick

from fuzzy_fusion_ros.baselines import BaselineParameters
from fuzzy_fusion_ros.cli import check
from fuzzy_fusion_ros.cli.score import main
from fuzzy_fusion_ros.jobs.parameter_file import text
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import replace


@pytest.fixture(autouse=True)
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let every fit be short."""
    be_quick(monkeypatch)


@pytest.fixture
def bag(tmp_path: Path) -> Path:
    """A bag with everything."""
    return write_scalars(tmp_path / "bag", swing())


@pytest.fixture
def params(tmp_path: Path) -> str:
    """A parameter file with the baselines, so that none is fitted."""
    path = tmp_path / "with_baselines.yaml"
    path.write_text(text(Parameters(), {"": BaselineParameters()}))
    return str(path)


def test_a_table_is_printed(bag: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([str(bag), "--unit", "rad"]) == 0
    out, said = capsys.readouterr()
    assert out.startswith(f"{bag}\n500 of 500 estimates matched")
    assert "kalman_bias" in out
    assert "rad s^2" in out
    assert said == ""


def test_json_on_stdout_is_alone(bag: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([str(bag), "--json", "-"]) == 0
    out, said = capsys.readouterr()
    assert json.loads(out)["matched"] == 500
    assert "kalman_bias" in said


def test_several_bags_make_one_table_and_one_document(
    bag: Path, params: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    other = write_scalars(tmp_path / "other", swing(estimate=False))
    path = tmp_path / "both.json"
    plot = tmp_path / "both.png"
    given = ["--params", params, "--baseline", str(path)]
    both = [str(bag), str(other)]
    assert main([*both, "--params", params, "--json", str(path), "--plot", str(plot)]) == 0
    assert list(json.loads(path.read_text())) == [str(bag), str(other)]
    out = capsys.readouterr().out
    assert [line.split()[0] for line in out.splitlines()[1:] if line[0] != " "] == [
        f"…{str(each)[-23:]}" for each in (bag, other)
    ]
    assert max(map(len, out.splitlines())) <= 80
    assert (tmp_path / "both_bag.png").exists()
    assert (tmp_path / "both_other.png").exists()
    assert main([*both, *given]) == 0
    capsys.readouterr()
    assert main([str(bag), str(tmp_path / "new"), *given, "--jobs", "2"]) == 1
    assert "failed: bag" in capsys.readouterr().out
    write_scalars(tmp_path / "new", swing())
    assert main([str(bag), str(tmp_path / "new"), *given]) == 2
    assert "--baseline has no score of" in capsys.readouterr().err


def test_a_plot_is_drawn(bag: Path, params: str, tmp_path: Path) -> None:
    assert main([str(bag), "--params", params, "--plot", str(tmp_path / "plot.png")]) == 0
    assert (tmp_path / "plot.png").read_bytes().startswith(b"\x89PNG")


def test_a_page_is_written_for_each_bag(bag: Path, tmp_path: Path) -> None:
    params = tmp_path / "params.yaml"
    params.write_text("fusion_node: {ros__parameters: {qos: reliable}}  # ours\n")
    other = write_scalars(tmp_path / "other", swing())
    arguments = ["--params", str(params), "--report", str(tmp_path / "page.html")]
    assert main([str(bag), str(other), *arguments]) == 0
    for name in ("bag", "other"):
        page = (tmp_path / f"page_{name}.html").read_text()
        assert f"<title>score of {name}</title>" in page
        assert "{qos: reliable}}  # ours" in page


@pytest.mark.parametrize(
    ("target", "problem"),
    [
        ("page.png", "expected a name that ends in .html"),
        ("bag/metadata.yaml/page.html", "cannot be written: File exists"),
    ],
)
def test_a_target_that_cannot_be_is_refused_before_the_work(
    bag: Path,
    target: str,
    problem: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    before = sorted(tmp_path.rglob("*"))
    assert main([str(bag), "--params", "params.yaml", "--report", target]) == 2
    out, said = capsys.readouterr()
    assert out == ""
    assert problem in said
    assert sorted(tmp_path.rglob("*")) == before


def test_a_regression_is_named(
    bag: Path, params: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "before.json"
    assert main([str(bag), "--params", params, "--json", str(path)]) == 0
    given = [str(bag), "--params", params, "--baseline", str(path)]
    assert main([*given, "--tolerance", "0"]) == 0
    document = json.loads(path.read_text())
    document["estimators"]["estimate"]["rmse"] /= 1.2
    path.write_text(json.dumps(document))
    capsys.readouterr()
    assert main(given) == 1
    assert "worse than before by more than 5 %: rmse of the estimate" in capsys.readouterr().err
    assert main([*given, "--tolerance", "30"]) == 0


def test_the_parameters_run_where_there_is_no_estimate(tmp_path: Path) -> None:
    bag = write_scalars(tmp_path / "bag", swing(estimate=False))
    params = tmp_path / "params.yaml"
    weights = ("very_small", "small", "large", "very_large")
    half = {f"aggregator.weight.{each}": 0.5 for each in weights}
    params.write_text(
        text(
            replace(Parameters(), {**half, "aggregator.drift.large": 0.0}),
            {"": replace(BaselineParameters(), {"constant_weight.weight": 1.0})},
        )
    )
    assert main([str(bag), "--params", str(params), "--json", str(tmp_path / "a.json")]) == 0
    found = json.loads((tmp_path / "a.json").read_text())["estimators"]
    common = {name: found["estimate"][name] for name in found["average"]}  # less what is its own
    assert common == pytest.approx(found["average"])
    assert found["constant_weight"] == pytest.approx(found["s1"])


def test_baselines_are_fitted_where_no_file_has_them(
    bag: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    params = tmp_path / "params.yaml"
    params.write_text("fusion_node:\n  ros__parameters:\n    trigger: pair\n")
    rmse = {}
    for name in ("fitted", "again", "derived"):
        if name == "derived":
            monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
        path = tmp_path / name
        assert main([str(bag), "--params", str(params), "--json", str(path)]) == 0
        out, said = capsys.readouterr()
        assert ("not fitted" in out) == ("numba is not installed" in said) == (name == "derived")
        assert ("flatters" in out) == (name != "derived")
        estimators = json.loads(path.read_text())["estimators"]
        rmse[name] = {each: found["rmse"] for each, found in estimators.items()}
    assert rmse["fitted"] == rmse["again"]
    for name in ("constant_weight", "complementary", "kalman"):
        assert rmse["fitted"][name] <= rmse["derived"][name]


def test_fields_and_topics_are_passed_on(bag: Path, tmp_path: Path) -> None:
    path = tmp_path / "score.json"
    arguments = [str(bag), "--estimate", "/s1", "--field", "truth=point.y", "--json", str(path)]
    assert main([*arguments, "--start", "1", "--end", "2"]) == 0
    document = json.loads(path.read_text())
    assert (document["of"], document["span_s"][0]) == (100, 1.0)
    assert document["estimators"]["estimate"] == document["estimators"]["s1"]
    assert document["estimators"]["s1"]["bias"] > 1.0  # point.y is 0


def test_what_was_left_out_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    scalars = swing(1.0)
    bag = write_scalars(
        tmp_path / "bag", [*scalars, scalars[-1]._replace(value=float("nan"), time_s=1.0)]
    )
    assert main([str(bag)]) == 0
    assert "/estimate: 1 dropped: value is not finite" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        ([], "the following arguments are required: BAG"),
        (["nothing"], "'nothing' does not exist"),
        (["BAG", "--truth", "/gps"], "has no topic '/gps'; it has /estimate"),
        (["BAG", "--field", "s1=data"], "choose one of: point.x"),
        (["BAG", "--field", "point.q"], "choose one of: point.x"),
        (["BAG", "--start", "9"], "no message in this span"),
        (["BAG", "--baseline", "none.json"], "'none.json' cannot be read"),
        (["BAG", "--params", "none.yaml"], "'none.yaml': cannot be read"),
        (["BAG", "--plot", "plot.xyz"], "an unknown format"),
        (["BAG", "--tolerance", "-1"], "--tolerance: got '-1'"),
        (["BAG", "--json", "/proc/none/a.json"], "cannot be written"),
    ],
)
def test_what_cannot_be_used_is_one_line_and_status_2(
    bag: Path, arguments: list[str], problem: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([each.replace("BAG", str(bag)) for each in arguments]) == 2
    said = capsys.readouterr().err
    assert problem in said
    assert said.startswith("score: ")
    assert said.count("\n") == 1


def test_no_match_is_status_2(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    apart = [
        each._replace(log_s=each.time_s, time_s=each.time_s - 100.0 * (each.topic == "/truth"))
        for each in swing(1.0)
    ]
    assert main([str(write_scalars(tmp_path / "bag", apart))]) == 2
    said = capsys.readouterr().err
    assert "matched 0 of 100 estimates" in said
    assert said.count("\n") == 1


@pytest.mark.parametrize("command", [main, check.main])
def test_a_bag_named_twice_is_one(
    command: Callable[..., int], capsys: pytest.CaptureFixture[str]
) -> None:
    assert command(["nosuch", "nosuch"]) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.count("\n") == 1
