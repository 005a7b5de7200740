# SPDX-License-Identifier: Apache-2.0
"""How commands end."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import threading
from collections.abc import Sequence
from pathlib import Path
from typing import IO

import pytest

from fuzzy_fusion_ros.cli.status import DONE, FAILED, UNUSABLE, command, say
from fuzzy_fusion_ros.parameters.errors import UsageError

ROOT = Path(__file__).resolve().parents[2]


def ended(
    main_body: str,
    *,
    stdout: int | IO[str] | None = subprocess.PIPE,
    closed: str = "",
    ignored: str = "",
) -> subprocess.Popen[str]:
    """Start a command with this body in a process of its own, some of its streams closed."""
    program = f"""
import hashlib, os, signal, sys
{ignored}
for number in {closed!r}: os.close(int(number))
sys.stdout = None if "1" in {closed!r} else sys.stdout
sys.stderr = None if "2" in {closed!r} else sys.stderr
from fuzzy_fusion_ros.cli import status
from fuzzy_fusion_ros.cli.status import command, say, show
from fuzzy_fusion_ros.parameters.arguments import Parser
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
        ("mcap.records", "tool: mcap is not installed: in a workspace, run src/fuzzy_fusion_ros/"),
        (
            "rclpy",
            "tool: needs ROS 2, but rclpy was not found: source ROS 2, for example /opt/ros/",
        ),
        ("geometry_msgs.msg", "tool: needs ROS 2, but geometry_msgs was not found: source ROS 2"),
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


@pytest.mark.parametrize("body", ["show('x' * 100)", "show('x' * 100_000)", "HELP"])
@pytest.mark.parametrize(("closed", "reason"), [("", "No space left on device"), ("1", "Bad file")])
def test_results_that_cannot_be_written_are_an_error(body: str, closed: str, reason: str) -> None:
    body = body.replace("HELP", "Parser('tool', 'about').parse_args(['--help'])")
    with open("/dev/full", "w") as full:
        process = ended(f"    {body}; return 0", stdout=full, closed=closed)
    _, said = process.communicate()
    assert process.returncode == 2
    assert re.fullmatch(f"tool: stdout cannot be written: {reason}.*\n", said)


def test_without_stderr_the_work_is_done() -> None:
    process = ended("    say('tool', 'x' * 10); show('done'); return 1", closed="2")
    assert (*process.communicate(), process.returncode) == ("done\n", "", 1)


def test_no_file_takes_the_place_of_a_closed_stream(tmp_path: Path) -> None:
    file = tmp_path / "file"
    body = f"""
    with open({str(file)!r}, "w") as target:
        for number in (0, 1, 2):
            try: os.write(number, b"x")
            except OSError: pass
        print(target.fileno() > 2, file=target)
    return 0"""
    process = ended(body, closed="012")
    process.communicate()
    assert process.returncode == 0
    assert file.read_text() == "True\n"


def test_what_the_encoding_lacks_is_an_escape(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PYTHONIOENCODING", "ascii")
    process = ended("    show('\u00b1 1'); say('tool', '\u00b5'); return 0")
    assert process.communicate() == ("\\xb1 1\n", "tool: \\xb5\n")


SWALLOWED = """
    status.GRACE = {grace}
    try: os.kill(os.getpid(), signal.{signal}); signal.pause()
    except BaseException: print("swallowed", flush=True)
    while True:
        os.kill(os.getpid(), {second}); signal.pause()"""


@pytest.mark.parametrize(("number", "status"), [("SIGINT", 130), ("SIGTERM", 143)])
def test_what_swallows_the_first_signal_ends_after_a_while(number: str, status: int) -> None:
    process = ended(SWALLOWED.format(grace=0.1, signal=number, second=0))
    assert process.communicate()[0] == "swallowed\n"
    assert process.returncode == status


def test_the_second_signal_ends_at_once() -> None:
    process = ended(SWALLOWED.format(grace=1e6, signal="SIGTERM", second="signal.SIGTERM"))
    process.communicate()
    assert process.returncode == -signal.SIGTERM


def test_compiled_code_does_not_outlive_a_signal() -> None:
    process = ended(
        """
    import threading
    status.GRACE = 0.1
    threading.Timer(0.2, os.kill, (os.getpid(), signal.SIGTERM)).start()
    hashlib.pbkdf2_hmac("sha256", b"", b"", 2**31 - 1)  # minutes without any Python code
    return 0"""
    )
    process.communicate()
    assert process.returncode == 143


def test_an_ignored_signal_stays_ignored() -> None:
    process = ended(
        """
    os.kill(os.getpid(), signal.SIGINT)
    return 0""",
        ignored="signal.signal(signal.SIGINT, signal.SIG_IGN)",
    )
    process.communicate()
    assert process.returncode == 0


def test_an_interrupt_leaves_no_traceback() -> None:
    process = ended("    os.kill(os.getpid(), signal.SIGINT); signal.pause(); return 0")
    _, said = process.communicate()
    assert (process.returncode, said) == (130, "tool: interrupted\n")


def test_sigterm_unwinds() -> None:
    process = ended(
        """
    try:
        os.kill(os.getpid(), signal.SIGTERM)
        signal.pause()
    finally:
        print("closed", flush=True)
    return 0"""
    )
    out, said = process.communicate()
    assert (process.returncode, out, said) == (143, "closed\n", "tool: terminated\n")


@pytest.mark.parametrize("amount", [10, 1_000_000])
def test_a_reader_that_goes_away_is_no_error(amount: int) -> None:
    reading, writing = os.pipe()
    process = ended(f"    show('x' * {amount}); return 0", stdout=writing)
    os.close(writing)
    os.close(reading)
    _, said = process.communicate()
    assert (process.returncode, said) == (128 + signal.SIGPIPE, "")
