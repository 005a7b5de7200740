# SPDX-License-Identifier: Apache-2.0
"""The command tune."""

from __future__ import annotations

import json
import re
import shlex
from pathlib import Path

import pytest
from bag.making import FLOAT, float_data
from bag.recorded import Scalar, write_scalars
from tuning.quick import be_quick
from tuning.recordings import START_NS, Sensors, made

from fuzzy_fusion_ros.bag import BagWriter
from fuzzy_fusion_ros.cli.replay import main as replay
from fuzzy_fusion_ros.cli.score import main as score
from fuzzy_fusion_ros.cli.tune import main
from fuzzy_fusion_ros.jobs.parameter_file import baseline_parameters
from fuzzy_fusion_ros.offline import excerpts
from fuzzy_fusion_ros.parameters.file import parameters_from
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import flatten


@pytest.fixture(autouse=True)
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let every fit be short."""
    be_quick(monkeypatch)


@pytest.fixture
def bag(tmp_path: Path) -> Path:
    """A bag with a truth."""
    return write_bag(tmp_path / "bag")


def write_bag(
    path: Path,
    *,
    truth: bool = True,
    gap_s: tuple[float, float] = (0.0, 0.0),
    s2: str = "/s2",
    seed: int = 0,
    rate: float = 25.0,
) -> Path:
    """Write a recording as a bag, whose truth has a gap."""
    series, true = made(Sensors(bias=0.4, noise=0.1), seed, seconds=20.0, rate=rate)
    scalars = [
        Scalar(topic, (stamp_ns - START_NS) * 1e-9, value)
        for topic, stamps_ns, values in (
            ("/truth", series.s1_ns, true),
            (s2, series.s2_ns, series.s2),
            ("/s1", series.s1_ns, series.s1),
        )
        for stamp_ns, value in zip(stamps_ns.tolist(), values.tolist(), strict=True)
        if topic != "/truth" or (truth and not gap_s[0] < (stamp_ns - START_NS) * 1e-9 < gap_s[1])
    ]
    return write_scalars(path, sorted(scalars, key=lambda each: each.time_s))


def test_it_writes_what_node_and_score_take(
    bag: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    output = tmp_path / "new" / "tuned.yaml"
    arguments = [str(bag), "--output", str(output), "--unit", "rad"]
    results = {"--plot": "a.png", "--json": "a", "--report": "a.html"}
    arguments += [text for name, file in results.items() for text in (name, str(tmp_path / file))]
    assert main(arguments) == 0
    assert "<title>fit to bag</title>" in (tmp_path / "a.html").read_text()
    out, said = capsys.readouterr()
    assert said == ""
    for part in (
        "S1: 25 Hz",
        "RMSE in rad against the truth",
        "(chosen)",
        "fusion_node --ros-args",
    ):
        assert part in out
    document = json.loads((tmp_path / "a").read_text())
    parameters = parameters_from(output)
    assert json.loads(json.dumps(flatten(parameters))) == document["parameters"]
    assert parameters.s2.type == "geometry_msgs/msg/PointStamped"
    baselines = baseline_parameters(output)
    assert baselines is not None
    assert flatten(baselines) == document["baselines"]["parameters"]
    assert output.read_text().startswith("# Made by tune from bag, --seed 0, fitted to its truth.")
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")
    assert score([str(bag), "--params", str(output), "--json", "-"]) == 0
    scored = json.loads(capsys.readouterr().out)["estimators"]
    assert scored["estimate"]["rmse"] == pytest.approx(document["rmse_after"])
    for name, error in document["baselines"]["rmse"].items():
        assert scored[name]["rmse"] == pytest.approx(error)


def test_two_runs_write_the_same_bytes_and_keep_what_is_given(
    bag: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    params = tmp_path / "params.yaml"
    params.write_text("fusion_node:\n  ros__parameters:\n    qos: reliable\n")
    documents = []
    for name in ("one", "two"):
        output = ["--params", str(params), "--output", str(tmp_path / name), "--json", "-"]
        assert main([str(bag), *output, "--seed", "3"]) == 0
        out, said = capsys.readouterr()
        documents.append(out)
        assert "S1: 25 Hz" in said
    assert documents[0] == documents[1]
    assert json.loads(documents[0])["with_truth"] is True  # it is alone on stdout
    assert (tmp_path / "one").read_bytes() == (tmp_path / "two").read_bytes()
    assert parameters_from(tmp_path / "one").qos == "reliable"
    assert parameters_from(tmp_path / "one") != Parameters()


def test_a_truth_may_be_ignored_or_missing(
    bag: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    without = write_bag(tmp_path / "without", truth=False)
    answers = []
    for arguments in ([str(bag), "--no-truth"], [str(without)]):
        assert main([*arguments, "--output", str(tmp_path / "a.yaml"), "--json", "-"]) == 0
        answers.append(json.loads(capsys.readouterr().out))
    assert answers[0] == answers[1]
    assert answers[0]["with_truth"] is False
    assert "without a truth" in (tmp_path / "a.yaml").read_text()


@pytest.mark.parametrize(
    ("span", "scored"),
    [
        ("--start 1 --end 15", "--start 15"),
        ("--start 8", "--end 8"),
        ("--start 8 --end 15", "--end 8"),  # the longer part
        ("--start 0.1", "--start 0.1"),  # nothing to speak of is left out
        ("--end 19.9 --no-truth", "--end 19.9"),
        ("", ""),
    ],
)
def test_topics_and_span_are_told(
    span: str, scored: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    bag = write_bag(tmp_path / "bag", s2="/gps")
    output = tmp_path / "a.yaml"
    options = ["--s2", "gps", "--unit", "m/s^2", *span.split()]
    assert main([str(bag), *options, "--output", str(output)]) == 0
    to_score, to_run = capsys.readouterr().out.splitlines()[-2:]
    assert to_run.endswith(f"--params-file {output} -r s2:=/gps")
    program, arguments = to_score.split(" score ")
    assert program == "score with: fuzzy-fusion"
    assert arguments == shlex.join(
        [str(bag), "--params", str(output), "--s2", "/gps", *scored.split(), "--unit", "m/s^2"]
    )
    assert score(shlex.split(arguments)) == 0
    assert span.removesuffix(" --no-truth") in output.read_text().splitlines()[0]


def test_a_bag_without_a_truth_is_to_be_replayed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    bag = write_bag(tmp_path / "bag", truth=False, s2="/gps")
    assert main([str(bag), "--s2", "gps"]) == 0
    to_replay, _ = capsys.readouterr().out.splitlines()[-2:]
    program, arguments = to_replay.split(" replay ")
    assert program == "replay with: fuzzy-fusion"
    assert replay(shlex.split(arguments)) == 0
    assert (tmp_path / "bag_replay").is_dir()


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        (["--truth", "/mocap"], "/mocap"),
        (["--s1", "/imu"], "/imu"),
        (["--end", "1"], "got 25 samples of S1, expected at least 50"),
        (["--start", "5", "--end", "5"], "--end must be greater than --start, got 5 and 5"),
        (["--seed", "-1"], "expected an integer"),
        (["--plot", "fit.txt"], "fit.txt"),
        (["--field", "s1=data"], "choose one of: point.x"),
    ],
)
def test_what_cannot_be_used_gives_a_line_and_status_2(
    bag: Path,
    arguments: list[str],
    problem: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main([str(bag), *arguments, "--output", str(tmp_path / "a.yaml")]) == 2
    said = capsys.readouterr().err
    assert re.fullmatch(r"tune: .*\n", said)
    assert problem in said


@pytest.mark.parametrize(
    ("option", "value"),
    [
        ("--output", "TMP"),
        ("--json", "/proc/none/a.json"),
        ("--plot", "/proc/none/a.png"),
        ("--plot", "TMP/a.txt"),
    ],
)
def test_what_cannot_be_written_is_refused_before_the_fit(
    bag: Path,
    option: str,
    value: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.delattr("fuzzy_fusion_ros.jobs.tune.fit")
    output = tmp_path / "a.yaml"
    arguments = ["--output", str(output), option, value.replace("TMP", str(tmp_path))]
    assert main([str(bag), *arguments]) == 2
    out, said = capsys.readouterr()
    assert out == ""
    assert re.fullmatch(r"tune: .* (cannot be written|an unknown format).*\n", said)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["bag"]


@pytest.fixture
def bags(bag: Path, tmp_path: Path) -> list[str]:
    """Two bags of the same sensors."""
    return [str(bag), str(write_bag(tmp_path / "other", seed=1))]


def test_one_set_of_parameters_is_fitted_to_several_bags(
    bags: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    output = tmp_path / "tuned.yaml"
    files = {"--json": "a.json", "--plot": "a.png", "--report": "a.html", "--output": output.name}
    options = [text for name, file in files.items() for text in (name, str(tmp_path / file))]
    assert main([*bags, bags[0], *options, "--jobs", "2"]) == 0
    out, said = capsys.readouterr()
    assert said == ""
    assert "by recording" in out
    document = json.loads((tmp_path / "a.json").read_text())
    assert list(document["recordings"]) == bags
    assert output.read_text().startswith(
        "# Made by tune from bag, other, --seed 0, fitted to their truth."
    )
    for bag in bags:
        row = document["recordings"][bag]
        assert re.search(rf"{Path(bag).name} +{row['baselines']['s1']:.4g} ", out)
        assert score([bag, "--params", str(output), "--json", "-"]) == 0
        scored = json.loads(capsys.readouterr().out)["estimators"]
        assert scored["estimate"]["rmse"] == pytest.approx(row["rmse_after"])
        for name, error in row["baselines"].items():
            assert scored[name]["rmse"] == pytest.approx(error)
        assert row["rmse_after"] < min(row["baselines"]["s1"], row["baselines"]["s2"])
        for suffix in (".png", ".html"):
            assert (tmp_path / f"a_{Path(bag).name}{suffix}").stat().st_size > 0
    assert "<title>fit to other</title>" in (tmp_path / "a_other.html").read_text()


def test_a_long_bag_is_fitted_to_in_excerpts(
    bag: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for name, value in (("MOST", 300), ("EXCERPTS", 2), ("FEWEST_S2", 20)):
        monkeypatch.setattr(excerpts, name, value)
    files = {"--json": "a.json", "--plot": "a.png", "--report": "a.html", "--output": "a.yaml"}
    options = [text for name, file in files.items() for text in (name, str(tmp_path / file))]
    assert main([str(bag), *options]) == 0
    out, said = capsys.readouterr()
    assert said.startswith(f"tune: {bag}: 500 samples of S1: the fit is to 2 excerpts of 150")
    document = json.loads((tmp_path / "a.json").read_text())
    assert list(document["recordings"]) == [f"{bag}, excerpt {k} of 2" for k in (1, 2)]
    assert "bag, excerpt 2 of 2" in out
    page = (tmp_path / "a.html").read_text()
    assert "<title>fit to bag, excerpt 1 of 2</title>" in page
    assert "against the truth, all recordings" in page
    assert (tmp_path / "a.png").exists()
    assert (tmp_path / "a.yaml").read_text().startswith("# Made by tune from bag, --seed 0")


def test_excerpts_that_cannot_be_used_for_fitting_are_skipped(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for name, value in (("MOST", 300), ("EXCERPTS", 2), ("FEWEST_S2", 20)):
        monkeypatch.setattr(excerpts, name, value)
    output = ["--output", str(tmp_path / "a.yaml")]
    half = write_bag(tmp_path / "half", gap_s=(0.5, 10.0))
    assert main([str(half), *output]) == 0
    said = capsys.readouterr().err.splitlines()
    skipped = f"tune: {half}: the excerpt from 0 s to 6 s is skipped: got 8 samples of S1"
    assert said[1].startswith(skipped)
    assert len(said) == 2
    none = write_bag(tmp_path / "none", gap_s=(0.5, 19.5))
    assert main([str(none), *output]) == 2
    assert "no excerpt can be used for fitting: got " in capsys.readouterr().err


def test_a_bag_of_other_sensors_is_named(
    bags: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    odd = str(write_bag(tmp_path / "odd", rate=50.0))
    assert main([*bags, odd, "--output", str(tmp_path / "a.yaml"), "--no-truth"]) == 0
    said = capsys.readouterr().err.splitlines()
    assert said[:1] == [
        f"tune: {odd}: unlike the other recordings: S1 runs at 50 Hz, in the other recordings at "
        "25 Hz; are they of the same sensors?"
    ]
    assert not [line for line in said if not line.startswith(f"tune: {odd}: ")]


def test_a_bag_that_cannot_be_used_ends_the_fit_of_all(
    bags: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    short = write_scalars(tmp_path / "short", [Scalar("/s1", 0.0, 1.0), Scalar("/s2", 0.0, 1.0)])
    blind = write_bag(tmp_path / "blind", truth=False)
    for bag, options, problem in (
        (tmp_path / "none", [], "does not exist"),
        (blind, [], "has no truth, and other bags have one"),
        (short, ["--no-truth"], "got 1 samples of S1, expected at least 50"),
    ):
        arguments = [*bags, str(bag), *options, "--output", str(tmp_path / "a.yaml")]
        assert main(arguments) == 2
        said = capsys.readouterr().err
        assert re.fullmatch(r"tune: .*\n", said)
        assert str(bag) in said
        assert problem in said
    assert not (tmp_path / "a.yaml").exists()


def test_bags_of_other_types_are_refused(
    bags: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    plain = str(tmp_path / "plain")
    with BagWriter(plain) as writer:
        for k in range(5):
            for topic in ("/s1", "/s2"):
                writer.write(topic, FLOAT, 10**9 + k, float_data(1.0))
    assert main([*bags, plain, "--output", str(tmp_path / "a.yaml")]) == 2
    said = capsys.readouterr().err
    assert said == (
        f"tune: {plain}: s1.type is 'std_msgs/msg/Float64', in {bags[0]} it is "
        "'geometry_msgs/msg/PointStamped': tune to bags of the same sensors only\n"
    )


def test_slowness_is_explained(
    bag: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    assert main([str(bag), "--output", str(tmp_path / "a.yaml")]) == 0
    assert "without numba this takes" in capsys.readouterr().err
