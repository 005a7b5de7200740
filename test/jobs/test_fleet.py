# SPDX-License-Identifier: Apache-2.0
"""Many tasks: here, in processes, and on a real Dask cluster on loopback."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from bag.recorded import swing, write_scalars
from faults.waiting import wait_until
from jobs.fleet_tasks import (
    gated,
    interrupted_twice,
    lost_in_a_lock,
    noted,
    square,
    waiting,
)

from fuzzy_fusion_ros.cli.score import main as score
from fuzzy_fusion_ros.jobs.fleet import Failure, Interrupted, outcomes
from fuzzy_fusion_ros.parameters.errors import FusionError

ROOT = Path(__file__).parents[2]


@pytest.mark.parametrize("jobs", [1, 2])
def test_outcomes_are_in_order_and_a_failure_is_one_of_them(jobs: int) -> None:
    refused = Failure("got 3, expected anything else")
    assert list(outcomes(square, [1, 3, 2, 5], jobs)) == [1, refused, 4, 25]


def test_one_task_needs_no_process() -> None:
    assert list(outcomes(lambda x: -x, [7], jobs=4)) == [-7]  # a lambda cannot be pickled


def test_a_process_that_is_killed_loses_its_task_only_by_name() -> None:
    killed = list(outcomes(square, [4, 4], jobs=2))
    assert [isinstance(each, Failure) for each in killed] == [True, True]
    assert "a process ended before its task was done" in str(killed[0])


class Cluster:
    """A scheduler and two workers, each a process."""

    def __init__(self, folder: Path) -> None:
        """Prepare them.

        Args:
            folder: For what they write.
        """
        self._folder = folder
        self._file = folder / "scheduler.json"
        self._processes: list[subprocess.Popen[bytes]] = []

    def start(self) -> None:
        """Start them; return once both workers can be given tasks."""
        loopback = ["--host", "127.0.0.1"]
        self._start("scheduler", *loopback, "--port", "0", "--no-dashboard")
        wait_until(self._is_listening, "the scheduler")
        for _ in range(2):
            one = ["--nworkers", "1", "--nthreads", "1", "--no-nanny", "--no-dashboard"]
            self._start("worker", *loopback, *one)
        from distributed import Client  # which takes half a second to load

        connect: Any = Client
        with connect(self.address, set_as_default=False) as client:
            client.wait_for_workers(2, timeout=60)  # a late one might never get a task

    @property
    def address(self) -> str:
        """Where the scheduler listens."""
        found: str = json.loads(self._file.read_text())["address"]
        return found

    def _is_listening(self) -> bool:
        written = self._file.read_text() if self._file.exists() else ""
        return written.endswith("}")  # it is not written at once

    def close(self) -> None:
        """End all processes."""
        for process in self._processes:
            process.kill()
            process.wait()

    def _start(self, kind: str, *options: str) -> None:
        module = [sys.executable, "-W", "ignore", "-m", "dask", kind]
        paths = os.pathsep.join([str(ROOT), str(ROOT / "test")])
        with (self._folder / "log").open("ab") as log:
            process = subprocess.Popen(
                [*module, "--scheduler-file", str(self._file), *options],
                cwd=self._folder,
                env={**os.environ, "PYTHONPATH": paths},
                stdout=log,
                stderr=log,
            )
        self._processes.append(process)


@pytest.fixture
def cluster(tmp_path: Path) -> Iterator[Cluster]:
    """A cluster on loopback."""
    folder = tmp_path / "cluster"
    folder.mkdir()
    with contextlib.closing(Cluster(folder)) as running:
        running.start()
        yield running


@pytest.mark.filterwarnings("ignore")  # of distributed's own
def test_a_worker_that_is_killed_midway_loses_nothing(cluster: Cluster, tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "gate")
    started = tmp_path / "started"
    found: list[int | Failure] = []
    items = [(k, str(tmp_path)) for k in range(6)]

    def run() -> None:
        found.extend(outcomes(gated, items, scheduler=cluster.address))

    thread = threading.Thread(target=run)
    thread.start()

    def working() -> set[str]:
        return set(started.read_text().split()) if started.exists() else set()

    wait_until(lambda: len(working()) == 2, "both workers")
    os.kill(int(min(working())), signal.SIGKILL)
    gate = os.open(tmp_path / "gate", os.O_RDWR)
    thread.join()
    os.close(gate)
    assert found == [0, 1, 4, 9, 16, 25]
    assert len(started.read_text().split()) >= 7  # the task that was lost ran twice


@pytest.mark.filterwarnings("ignore")
def test_a_cluster_gives_the_same_document(cluster: Cluster, tmp_path: Path) -> None:
    bags = [str(write_scalars(tmp_path / name, swing())) for name in ("one", "two")]
    bags.append(str(tmp_path / "missing"))
    params = tmp_path / "params.yaml"
    params.write_text((ROOT / "bags" / "nominal.yaml").read_text())
    given = [*bags, "--params", str(params), "--json"]
    assert score([*given, str(tmp_path / "here.json")]) == 1
    there = str(tmp_path / "there.json")
    assert score([*given, there, "--scheduler", cluster.address]) == 1
    assert (tmp_path / "here.json").read_text() == (tmp_path / "there.json").read_text()


@pytest.mark.filterwarnings("ignore")
def test_no_scheduler_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("fuzzy_fusion_ros.jobs.fleet.PATIENCE", 0.5)
    with pytest.raises(FusionError, match="no Dask scheduler answers at"):
        list(outcomes(square, [1, 2], scheduler="tcp://127.0.0.1:9"))


def test_what_has_not_begun_is_dropped_once_the_outcomes_are_not_wanted(tmp_path: Path) -> None:
    items = [(2 * k, str(tmp_path)) for k in range(2000)]
    with contextlib.closing(outcomes(noted, items, jobs=2)) as found:
        assert next(found) == 0
    assert len(list(tmp_path.iterdir())) < 2000


def waits_for(folder: Path, *numbers: int) -> list[int]:
    """Wait until tasks wait; return their processes."""
    wait_until(lambda: all([*folder.glob(f"waits_{number}_*")] for number in numbers), "tasks")
    found = [[*folder.glob(f"waits_{number}_*")] for number in numbers]
    return [int(each.name.split("_")[2]) for (each,) in found]


@pytest.mark.parametrize("others", [None, signal.SIGINT, signal.SIGTERM])
def test_an_interrupt_of_this_process_is_one_of_all(
    tmp_path: Path, others: signal.Signals | None
) -> None:
    """Also where the processes get a signal themselves, as from a terminal."""

    def interrupt() -> None:
        workers = waits_for(tmp_path, 1, 3)
        for each in workers if others else ():
            os.kill(each, others)
        os.kill(os.getpid(), signal.SIGINT)

    threading.Thread(target=interrupt).start()
    found: list[int | Failure | Interrupted] = []
    with pytest.raises(KeyboardInterrupt):
        found.extend(outcomes(waiting, [(k, str(tmp_path)) for k in (2, 1, 3, 5, 7)], jobs=2))
    assert found[:3] == [4, Interrupted("1 has waited"), Interrupted("3 has waited")]
    for number, last in zip((5, 7), found[3:], strict=True):  # they may just have begun
        assert last in {Interrupted(""), Interrupted(f"{number} has waited")}


def test_a_task_is_interrupted_once() -> None:
    """Also where both signals come: a second would tear what the first one unwinds."""
    assert list(outcomes(interrupted_twice, [1, 2], jobs=2)) == [Interrupted("unwound")] * 2


def test_whatever_an_interrupt_becomes_is_one() -> None:
    """As in a lock's wait, which it can leave without the lock."""
    assert list(outcomes(lost_in_a_lock, [1, 2], jobs=2)) == [Interrupted("")] * 2


def test_what_this_process_ignores_interrupts_no_task(tmp_path: Path) -> None:
    """SIGINT to all processes of a terminal, where a shell has started this one without."""
    os.mkfifo(tmp_path / "gate")
    started = tmp_path / "started"
    started.touch()

    def signal_all() -> None:
        wait_until(lambda: len(started.read_text().split()) == 2, "both tasks")
        for each in started.read_text().split():
            os.kill(int(each), signal.SIGINT)
        gates.append(os.open(tmp_path / "gate", os.O_RDWR))

    gates: list[int] = []
    threading.Thread(target=signal_all).start()
    assert list(outcomes(gated, [(2, str(tmp_path)), (3, str(tmp_path))], jobs=2)) == [4, 9]
    os.close(gates[0])


def test_after_an_interrupt_in_this_process_no_task_begins(tmp_path: Path) -> None:
    def interrupted(number: int) -> int:
        if number == 2:
            raise KeyboardInterrupt("half", "done")
        return number

    assert list(outcomes(interrupted, [1, 2, 3])) == [1, Interrupted("half: done"), Interrupted("")]


def test_processes_end_with_this_one(tmp_path: Path) -> None:
    script = f"""
from jobs.fleet_tasks import waiting
from fuzzy_fusion_ros.jobs.fleet import outcomes
if __name__ == "__main__":
    list(outcomes(waiting, [(1, {str(tmp_path)!r}), (3, {str(tmp_path)!r})], jobs=2))
"""
    (tmp_path / "script.py").write_text(script)
    paths = os.pathsep.join([str(ROOT), str(ROOT / "test")])
    process = subprocess.Popen(
        [sys.executable, str(tmp_path / "script.py")], env={**os.environ, "PYTHONPATH": paths}
    )
    workers = waits_for(tmp_path, 1, 3)
    process.kill()
    process.wait()
    wait_until(lambda: not any(is_running(each) for each in workers), "the end of the processes")


def is_running(process: int) -> bool:
    """Return whether a process runs: it is there and has not ended."""
    try:
        status = Path(f"/proc/{process}/stat").read_text()
    except OSError:
        return False
    return status.rpartition(")")[2].split()[0] != "Z"
