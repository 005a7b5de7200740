"""How commands end."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
from collections.abc import Sequence
from pathlib import Path

import pytest

from fuzzy_fusion_ros.cli.status import DONE, FAILED, UNUSABLE, command, say
from fuzzy_fusion_ros.parameters.errors import UsageError

ROOT = Path(__file__).resolve().parents[2]


def ended(main_body: str, *, stdout: int | None = subprocess.PIPE) -> subprocess.Popen[str]:
    """Start a command with this body in a process of its own."""
    program = f"""
import os, signal, sys, time
from fuzzy_fusion_ros.cli.status import command
from fuzzy_fusion_ros.parameters.errors import BagError
@command("tool")
def main(arguments=None):
{main_body}
sys.exit(main())
"""
    return subprocess.Popen(
        [sys.executable, "-c", program], stdout=stdout, stderr=subprocess.PIPE, text=True, cwd=ROOT
    )


@pytest.mark.parametrize("status", [DONE, FAILED])
def test_a_status_is_passed_on(status: int) -> None:
    @command("tool")
    def main(arguments: Sequence[str] | None = None) -> int:
        return status

    assert main() == status


def test_an_error_of_the_users_is_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    @command("tool")
    def main(arguments: Sequence[str] | None = None) -> int:
        raise UsageError("got 3,\n  expected 4")

    assert main([]) == UNUSABLE
    assert capsys.readouterr() == ("", "tool: got 3, expected 4\n")


@pytest.mark.parametrize(
    ("module", "said"),
    [
        ("mcap.records", "tool: mcap is not installed: in a workspace, src/fuzzy_fusion_ros/"),
        ("rclpy", "tool: rclpy is not found: source ROS 2, for example /opt/ros/jazzy/setup.bash"),
        ("geometry_msgs.msg", "tool: geometry_msgs is not found: source ROS 2"),
    ],
)
def test_a_library_that_is_missing_is_named_with_what_brings_it(
    capsys: pytest.CaptureFixture[str], module: str, said: str
) -> None:
    @command("tool")
    def main(arguments: Sequence[str] | None = None) -> int:
        raise ModuleNotFoundError(f"No module named {module!r}", name=module)

    assert main([]) == UNUSABLE
    shown = capsys.readouterr().err
    assert shown.startswith(said)
    assert shown.count("\n") == 1


def test_a_part_of_ours_that_is_missing_is_not_hidden() -> None:
    @command("tool")
    def main(arguments: Sequence[str] | None = None) -> int:
        raise ModuleNotFoundError(name="fuzzy_fusion_ros.gone")

    with pytest.raises(ModuleNotFoundError):
        main()


def test_an_error_of_ours_is_not_hidden() -> None:
    @command("tool")
    def main(arguments: Sequence[str] | None = None) -> int:
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        main([])


def test_arguments_are_passed_on() -> None:
    seen: list[Sequence[str] | None] = []

    @command("tool")
    def main(arguments: Sequence[str] | None = None) -> int:
        seen.append(arguments)
        return DONE

    main(["a"])
    main()
    assert seen == [["a"], None]


def test_messages_are_single_lines(capsys: pytest.CaptureFixture[str]) -> None:
    say("tool", "one\ntwo")
    assert capsys.readouterr().err == "tool: one two\n"


def test_sigterm_is_left_as_it_was() -> None:
    before = signal.getsignal(signal.SIGTERM)

    @command("tool")
    def main(arguments: Sequence[str] | None = None) -> int:
        assert signal.getsignal(signal.SIGTERM) != before
        return DONE

    assert main() == DONE
    assert signal.getsignal(signal.SIGTERM) == before


def test_it_runs_in_a_thread_too() -> None:
    statuses: list[int] = []

    @command("tool")
    def main(arguments: Sequence[str] | None = None) -> int:
        return FAILED

    thread = threading.Thread(target=lambda: statuses.append(main()))
    thread.start()
    thread.join()
    assert statuses == [FAILED]


def test_an_interrupt_leaves_no_traceback() -> None:
    process = ended("    os.kill(os.getpid(), signal.SIGINT); time.sleep(60); return 0")
    _, said = process.communicate()
    assert (process.returncode, said) == (130, "tool: interrupted\n")


def test_sigterm_unwinds() -> None:
    process = ended(
        """
    try:
        os.kill(os.getpid(), signal.SIGTERM)
        time.sleep(60)
    finally:
        print("closed", flush=True)
    return 0"""
    )
    out, said = process.communicate()
    assert (process.returncode, out, said) == (143, "closed\n", "")


@pytest.mark.parametrize("amount", [10, 1_000_000])
def test_a_reader_that_goes_away_is_no_error(amount: int) -> None:
    reading, writing = os.pipe()
    process = ended(f"    print('x' * {amount}); return 0", stdout=writing)
    os.close(writing)
    os.close(reading)
    _, said = process.communicate()
    assert (process.returncode, said) == (128 + signal.SIGPIPE, "")
