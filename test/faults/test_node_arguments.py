# SPDX-License-Identifier: Apache-2.0
"""Command lines of the nodes that cannot be used: refused before there is a graph, in one line."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from faults.commands import mannerly
from fuzzy_fusion_ros.cli import fusion_node, pendulum_node, sensor_subscriber

MAINS = {
    "fusion_node": fusion_node.main,
    "pendulum_node": pendulum_node.main,
    "sensor_subscriber": sensor_subscriber.main,
}


@pytest.mark.parametrize("main", MAINS.values(), ids=MAINS)
@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--nonsense"], "unrecognized arguments: --nonsense; see fuzzy-fusion {name} --help"),
        (["file.yaml"], "unrecognized arguments: file.yaml; see fuzzy-fusion {name} --help"),
        (["--params"], "expected one argument; see fuzzy-fusion {name} --help"),
        (["--ros-args", "--nonsense"], "invalid ROS arguments"),
        (["--ros-args", "-r", "a"], "invalid ROS arguments"),
        (["--ros-args", "-p", "rate"], "invalid ROS arguments"),
        (["--ros-args", "-p", "nonsense:=1"], "nonsense"),
        (["--params", "/nowhere.yaml"], "cannot be read: No such file or directory"),
    ],
)
def test_refused_in_one_line(main: Callable[..., int], words: list[str], said: str) -> None:
    end = mannerly(main, words)
    name = next(each for each, other in MAINS.items() if other is main)
    assert end.status == 2
    assert end.stderr.startswith(f"{name}: ")
    assert said.format(name=name) in end.stderr


def test_a_file_that_is_no_parameter_file_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "some.yaml"
    for text in ("", "[", "a: b: c", "- 1", "fusion_node: {ros__parameters: 3}", "\x00"):
        path.write_text(text)
        assert mannerly(fusion_node.main, ["--params", str(path)]).status == 2
