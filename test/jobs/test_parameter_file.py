# SPDX-License-Identifier: Apache-2.0
"""The parameter file that tune writes and score reads."""

from __future__ import annotations

from pathlib import Path

import pytest

from fuzzy_fusion_ros.baselines import BaselineParameters
from fuzzy_fusion_ros.jobs.parameter_file import (
    baseline_parameters,
    fusion_parameters,
    text,
    text_of,
)
from fuzzy_fusion_ros.parameters.errors import ParameterError
from fuzzy_fusion_ros.parameters.file import dumps
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import replace


def test_parameters_are_given_as_such_as_a_file_or_not_at_all(tmp_path: Path) -> None:
    parameters = replace(Parameters(), {"trigger": "pair"})
    baselines = replace(BaselineParameters(), {"kalman.s1_noise": 3.0})
    path = tmp_path / "tuned.yaml"
    path.write_text(text(parameters, {"": baselines}, ["Made by hand."]))
    assert path.read_text().startswith("# Made by hand.")
    assert text_of(path) == path.read_text()
    with pytest.raises(ParameterError, match="cannot be read: "):
        text_of(tmp_path / "missing.yaml")
    for source in (path, str(path)):
        assert fusion_parameters(source) == parameters
        assert baseline_parameters(source) == baselines
    assert fusion_parameters(parameters) is parameters
    assert baseline_parameters(parameters) is None
    assert fusion_parameters(None) == Parameters()
    path.write_text(text_of(parameters))
    assert fusion_parameters(path) == parameters
    with pytest.raises(ParameterError, match="cannot be read"):
        fusion_parameters(tmp_path)


def test_baselines_are_read_from_their_own_entry(tmp_path: Path) -> None:
    path = tmp_path / "params.yaml"
    path.write_text("fusion_node:\n  ros__parameters:\n    trigger: pair\n")
    assert baseline_parameters(None) is None
    assert baseline_parameters(str(path)) is None
    path.write_text("/**/baselines:\n  ros__parameters:\n    kalman: {s1_noise: 3.0}\n")
    assert baseline_parameters(str(path)) is None  # of an older version: all are fitted again
    own = dumps(replace(BaselineParameters(), {"kalman.s1_noise": 3.0}), node_name="baselines")
    path.write_text(own)
    found = baseline_parameters(str(path))
    assert found is not None
    assert found.kalman.s1_noise == 3.0
    path.write_text(own.replace("s1_noise: 3.0", "s1_noise: -3.0"))
    with pytest.raises(ParameterError, match=r"kalman\.s1_noise: got -3\.0"):
        baseline_parameters(str(path))
