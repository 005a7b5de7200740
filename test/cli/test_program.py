# SPDX-License-Identifier: Apache-2.0
"""fuzzy-fusion, and what ros2cli makes of it: verbs, help and completion."""

from __future__ import annotations

import argparse
import importlib
import os
import subprocess
import sys
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any

import pytest
from bag.recorded import swing, write_scalars

from fuzzy_fusion_ros.cli import COMMANDS, replay
from fuzzy_fusion_ros.cli.program import main
from fuzzy_fusion_ros.parameters.arguments import called

CLI = Path(replay.__file__).parent


def test_every_command_is_a_verb() -> None:
    files = {path.stem for path in CLI.glob("*.py") if "@command(" in path.read_text()}
    assert files == {*COMMANDS, "program"}
    for name in COMMANDS:
        parser = importlib.import_module(f"fuzzy_fusion_ros.cli.{name}").command_line()
        assert parser.prog == f"fuzzy-fusion {name}"


def test_help_lists_the_verbs(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([]) == 0
    shown = capsys.readouterr().out
    assert shown.startswith("usage: fuzzy-fusion ")
    assert all(f"\n  {name} " in shown for name in COMMANDS)
    assert max(map(len, shown.splitlines())) <= 80


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["rply"], "fuzzy-fusion: argument VERB: invalid choice: 'rply' (choose from "),
        (["replay"], "replay: the following arguments are required: BAG; see fuzzy-fusion replay"),
        (["replay", "--bogus", "bag"], "replay: unrecognized arguments: --bogus; see fuzzy-fusion"),
    ],
)
def test_what_is_wrong_is_said_in_one_line(
    capsys: pytest.CaptureFixture[str], arguments: list[str], said: str
) -> None:
    assert main(arguments) == 2
    assert capsys.readouterr().err.startswith(said)


def ros2(*arguments: str) -> tuple[argparse.ArgumentParser, argparse.Namespace, Any]:
    """Parse a command line as ros2cli does; return its extension too."""
    (entry,) = entry_points(group="ros2cli.command", name="fusion")
    extension = entry.load()()
    root = argparse.ArgumentParser(prog="ros2")
    parser = root.add_subparsers().add_parser("fusion", description=extension.__doc__)
    parser.set_defaults(_command=extension)
    extension.add_arguments(parser, "ros2 fusion")
    return root, root.parse_args(["fusion", *arguments]), extension


def test_ros2_fusion_runs_a_verb(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "argv", ["/opt/ros/jazzy/bin/ros2", "fusion", "replay", "--help"])
    root, given, extension = ros2("replay", "--help")
    assert given._command is not None
    with pytest.raises(SystemExit, match="0"):
        extension.main(parser=root, args=given)
    assert capsys.readouterr().out.startswith("usage: ros2 fusion replay [-h]")
    root, given, extension = ros2()
    assert extension.main(parser=root, args=given) == 0
    assert capsys.readouterr().out.startswith("usage: ros2 fusion [-h]")
    assert called("tune") == "ros2 fusion tune"


def test_arguments_for_ros_reach_the_verb() -> None:
    _, given, _ = ros2("fusion_node", "--ros-args", "-r", "s1:=/imu", "--", "--params", "p.yaml")
    assert given.verb == "fusion_node"
    assert given.arguments == ["--ros-args", "-r", "s1:=/imu", "--", "--params", "p.yaml"]


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("fuzzy-fusion re", {"replay", "reproduce"}),
        ("fuzzy-fusion replay --l", {"--live", "--loop"}),
        ("fuzzy-fusion fusion_node --p", {"--params", "--params-file"}),
    ],
)
def test_a_shell_completes_verbs_and_options(tmp_path: Path, line: str, words: set[str]) -> None:
    answer = tmp_path / "completions"
    asked = {
        "_ARGCOMPLETE": "1",
        "_ARGCOMPLETE_IFS": " ",
        "_ARGCOMPLETE_STDOUT_FILENAME": str(answer),
        "COMP_LINE": line,
        "COMP_POINT": str(len(line)),
    }
    program = "from fuzzy_fusion_ros.cli.program import main; main()"
    subprocess.run([sys.executable, "-c", program], env={**os.environ, **asked}, check=True)
    assert set(answer.read_text().split()) == words


ONLY_UNIX_HAS = """
import os, sys
for name in ("fcntl", "grp", "numba", "pwd", "resource", "termios"):
    sys.modules[name] = None
for name in ("getuid", "sched_getaffinity"):
    delattr(os, name)
from fuzzy_fusion_ros.cli.program import main
sys.exit(main(sys.argv[1:]))
"""


@pytest.mark.parametrize("verb", ["check", "score"])
def test_programs_run_on_what_windows_has(verb: str, tmp_path: Path) -> None:
    """Without numba, which has its own ways on Windows."""
    bag = write_scalars(tmp_path / "bag", swing(estimate=False))
    command = [sys.executable, "-c", ONLY_UNIX_HAS, verb, str(bag)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert "Traceback" not in done.stderr
    assert "s1" in done.stdout
