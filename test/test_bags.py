# SPDX-License-Identifier: Apache-2.0
"""The recordings in bags/ are what their README says, and what their script makes."""

from __future__ import annotations

import importlib.util
import json
import shutil
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from bag.making import decoded

from fuzzy_fusion_ros.bag import open_bag
from fuzzy_fusion_ros.cli import score

BAGS = Path(__file__).resolve().parents[1] / "bags"
SIMULATED = ("nominal", "nominal_predictor", "feedback_s1", "feedback_s2", "feedback_average")
TOPICS = ("/truth", "/s2", "/s1", "/estimate", "/control")


@pytest.fixture(scope="module")
def script() -> ModuleType:
    """The script that makes them."""
    spec = importlib.util.spec_from_file_location("make_bags", BAGS / "make_bags.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def samples(path: Path, topic: str) -> np.ndarray:
    """Return stamps and numbers of a topic, shape (n, 2)."""
    with open_bag(path) as bag:
        return np.array([(each.log_ns, decoded(each).point.x) for each in bag.messages([topic])])


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(each, marks=() if each == "nominal" else pytest.mark.slow("as the first"))
        for each in SIMULATED
    ],
)
def test_a_simulated_bag_is_what_the_script_makes(
    script: ModuleType, tmp_path: Path, name: str
) -> None:
    """The last bits may differ: sines and exponentials are each C library's own."""
    recording = script.simulated()[name]
    for each in ("one", "two"):
        script.write_simulated(tmp_path / each, recording)
    for topic in TOPICS:
        made, kept = samples(tmp_path / "one", topic), samples(BAGS / name, topic)
        advice = "the defaults have changed; run: python bags/make_bags.py"
        assert made == pytest.approx(kept, rel=0.0, abs=1e-6), advice
    assert script.digest(tmp_path / "one") == script.digest(tmp_path / "two")


def test_the_readme_has_the_digests(script: ModuleType) -> None:
    text = (BAGS / "README.md").read_text(encoding="utf-8")
    assert script.table() in text, "run: python bags/make_bags.py"
    assert set(script.simulated()) == set(SIMULATED)


def test_the_real_bag_is_made_of_csv_files(script: ModuleType, tmp_path: Path) -> None:
    source = tmp_path / "car.csv"
    rows = "".join(f"{k / 100},{k},0,{2 * k if k else ''}\n" for k in range(5))
    source.write_text("t,s1,s2,ref\n" + rows)
    (tmp_path / "car_s2.csv").write_text("t,s2\n0.0,1.5\n0.02,2.5\n")
    for name in ("one", "two"):
        script.write_car(tmp_path / name, source)
    assert script.digest(tmp_path / "one") == script.digest(tmp_path / "two")
    with open_bag(tmp_path / "one") as bag:
        found = [(each.topic, each.log_ns) for each in bag.messages()]
    assert found == [
        ("/s2", 1_000_000_000),
        ("/s1", 1_000_000_000),
        ("/s1", 1_010_000_000),
        ("/truth", 1_020_000_000),
        ("/s2", 1_020_000_000),
        ("/s1", 1_020_000_000),
        ("/s1", 1_030_000_000),
        ("/truth", 1_040_000_000),
        ("/s1", 1_040_000_000),
    ]


def test_the_script_leaves_the_rest_of_the_readme_alone(
    script: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("nominal", "car_accel"):
        shutil.copytree(BAGS / name, tmp_path / name)
    shutil.copy(BAGS / "README.md", tmp_path)
    monkeypatch.setattr(script, "HERE", tmp_path)
    monkeypatch.setattr(script, "simulated", dict)
    script.main([])
    after = (tmp_path / "README.md").read_text(encoding="utf-8")
    before = (BAGS / "README.md").read_text(encoding="utf-8")
    kept = [line for line in before.splitlines() if not line.startswith("| `")]
    assert [line for line in after.splitlines() if not line.startswith("| `")] == kept
    assert "`car_accel`" in after
    assert "`nominal`" not in after


@pytest.mark.parametrize("name", [*SIMULATED, "car_accel"])
def test_it_is_whole_and_small(name: str) -> None:
    with open_bag(BAGS / name) as bag:
        assert sum(1 for _ in bag.messages()) == bag.message_count
        assert bag.problems == []
    size = sum(path.stat().st_size for path in (BAGS / name).iterdir())
    assert size < (3_000_000 if name == "car_accel" else 800_000)


@pytest.mark.slow("fits every baseline to two recordings")
def test_score_takes_them_with_its_defaults(tmp_path: Path) -> None:
    path = tmp_path / "score.json"
    assert score.main([str(BAGS / "car_accel"), "--json", str(path)]) == 0
    real = json.loads(path.read_text())
    assert (real["matched"], real["of"]) == (60000, 60000)
    assert real["estimators"]["s1"]["rmse"] == pytest.approx(0.834, abs=0.001)
    assert real["estimators"]["s2"]["rmse"] == pytest.approx(0.474, abs=0.001)
    assert score.main([str(BAGS / "nominal"), "--json", str(path)]) == 0
    found = json.loads(path.read_text())["estimators"]
    assert found["estimate"]["rmse"] < min(found["s1"]["rmse"], found["s2"]["rmse"])


LAG_AWARE = {"kalman_lag", "kalman_lag_cv", "error_state"}


def test_what_was_fitted_to_the_first_half_is_near_the_best_on_the_second(tmp_path: Path) -> None:
    path = tmp_path / "score.json"
    fitted = ["--params", str(BAGS / "car_accel.yaml"), "--start", "300"]
    assert score.main([str(BAGS / "car_accel"), *fitted, "--json", str(path)]) == 0
    document = json.loads(path.read_text())
    found = document["estimators"]
    estimate = found.pop("estimate")["rmse"]
    assert estimate <= 0.2
    assert estimate < 0.9 * min(found[name]["rmse"] for name in found.keys() - LAG_AWARE)
    assert document["best_baseline"] == min(found, key=lambda name: found[name]["rmse"])
    assert estimate < 1.1 * found[document["best_baseline"]]["rmse"]


def test_without_tuning_it_is_ahead_of_fitted_filters_that_ignore_the_lag(tmp_path: Path) -> None:
    """From the second minute on, and on the very span that these are fitted to with the truth.

    Filters that know the lag from the truth too are ahead of it: docs/tuning.md says by how much.
    """
    fitted = (BAGS / "car_accel.yaml").read_text(encoding="utf-8")
    key = "ros__parameters:\n"
    params, path = tmp_path / "self_tuning.yaml", tmp_path / "score.json"
    params.write_text(fitted.replace(key, key + "    self_tuning: true\n", 1), encoding="utf-8")
    window = ["--start", "60", "--end", "300"]
    options = ["--params", str(params), *window, "--json", str(path)]
    assert score.main([str(BAGS / "car_accel"), *options]) == 0
    found = {
        name: each["rmse"] for name, each in json.loads(path.read_text())["estimators"].items()
    }
    ignoring = found.keys() - LAG_AWARE - {"estimate"}
    assert {"s1", "s2", "average"} < ignoring
    assert found["estimate"] < min(found[name] for name in ignoring)
