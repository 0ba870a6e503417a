"""Processes that die, take too long or are interrupted: what that costs, and what it leaves."""

from __future__ import annotations

import multiprocessing
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import artefacts
import batch_tasks
import exports
import pytest
from batch_tasks import task
from conftest import ROOT, Run
from walker import make
from walker_plan import Gait

from footfix import cli
from footfix.batch import processes
from footfix.batch.processes import Stop, on_processes
from footfix.batch.run import Crew
from footfix.batch.run import run as run_all
from footfix.batch.task import FileResult

POSIX = pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX systems")
ENVIRONMENT = {**os.environ, "PYTHONPATH": str(ROOT), "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}


@pytest.fixture(params=["spawn", "fork"])
def way(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> str:
    """Both ways in which workers start, whichever this process would choose."""
    if request.param not in multiprocessing.get_all_start_methods():
        pytest.skip(f"no {request.param} on this system")
    monkeypatch.setattr(processes, "_way", lambda: request.param)
    return str(request.param)


def results(names: list[str], *, workers: int = 2, timeout: float | None = None) -> dict[str, FileResult]:
    tasks = [task(name) for name in names]
    outcome = run_all(batch_tasks.act, tasks, crew=Crew(workers, timeout), on_result=lambda each: None)
    assert [each.source for each in outcome.results] == names  # in the order of the tasks
    return {each.source: each for each in outcome.results}


@POSIX
@pytest.mark.usefixtures("way")
def test_a_killed_worker_costs_its_clip_alone_and_is_named() -> None:
    found = results(["a", "die1", "b", "leave", "c"])
    assert [name for name, each in found.items() if each.status == "failed"] == ["die1", "leave"]
    assert "die1" in found["die1"].error and "SIGKILL" in found["die1"].error and "memory" in found["die1"].error
    assert "exit code 7" in found["leave"].error


@pytest.mark.usefixtures("forking")
def test_a_clip_that_takes_too_long_is_stopped() -> None:
    begun = time.monotonic()
    found = results(["a", "sleep", "b", "c"], timeout=0.5)
    assert time.monotonic() - begun < 30.0
    assert found["sleep"].status == "failed" and "longer than 0.5 s" in found["sleep"].error
    assert all(found[name].status == "done" for name in "abc")


@pytest.mark.usefixtures("forking")
def test_a_stop_lets_running_clips_finish_and_begins_no_others() -> None:
    stop, begun = Stop(), []

    def starting(index: int) -> None:
        begun.append(index)
        stop.asked = 1

    tasks = [task(f"nap{k}") for k in range(6)]
    ended = list(on_processes(batch_tasks.act, tasks, workers=2, timeout=None, stop=stop, starting=starting))
    assert 1 <= len(begun) <= 2 and sorted(index for index, _ in ended) == begun
    assert all(result.status == "done" for _, result in ended)


@POSIX
def test_workers_end_when_their_parent_is_killed(way: str, tmp_path: Path) -> None:
    program = (
        "import sys, batch_tasks\n"
        "from footfix.batch import processes\n"
        f"processes._way = lambda: {way!r}\n"
        "tasks = [batch_tasks.task(name) for name in ('a', 'b', 'c', 'stand', 'stand')]\n"
        "if __name__ == '__main__':\n"
        "    ended = processes.on_processes(batch_tasks.act, tasks, workers=3, timeout=None, stop=processes.Stop(),\n"
        "                                   starting=lambda index: None)\n"
        "    for index, result in ended:\n"
        "        print(index, flush=True)\n"
    )
    script = tmp_path / "parent.py"
    script.write_text(program)
    environment = {**ENVIRONMENT, "PYTHONPATH": os.pathsep.join([str(ROOT), str(ROOT / "tests")])}
    command = [sys.executable, str(script)]
    process = subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, start_new_session=True)
    assert process.stdout is not None
    for _ in range(3):
        process.stdout.readline()
    process.kill()
    process.wait()
    process.stdout.read()  # until nobody holds its other end


@pytest.fixture(scope="module")
def clips(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("clips") / "in"
    (folder / "sub").mkdir(parents=True)
    for k, name in enumerate(("a", "b", "sub/c")):
        walk = make(Gait(name="walk", duration=1.3, fps=30, seed=k))
        (folder / f"{name}.bvh").write_bytes(exports.bvh(artefacts.wander(walk.clip, 0.05, seed=k)))
    (folder / "broken.bvh").write_bytes(b"HIERARCHY\n")
    return folder


def contents(folder: Path) -> dict[str, bytes]:
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.fixture(scope="module")
def alone(clips: Path) -> dict[str, bytes]:
    """What one process makes of them."""
    out = clips.parent / "alone"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys, "argv", ["footfix", "clean", str(clips), "-o", str(out), "--report", "json", "-j1"])
        assert cli.run() == 3
    return contents(out)


@pytest.mark.usefixtures("forking")  # spawned ones give the same where they are killed and interrupted
def test_two_processes_give_the_same_bytes_as_one(
    clips: Path, alone: dict[str, bytes], tmp_path: Path, run: Run
) -> None:
    out = clips.parent / tmp_path.name  # pages say where their clip lies from there, so it is as near as `alone`
    code, _, err = run("clean", clips, "-o", out, "--report", "json", "-j2")
    assert code == 3 and "Traceback" not in err
    assert contents(out) == alone


@POSIX
def test_a_killed_batch_is_resumed_to_the_same_bytes(
    clips: Path, alone: dict[str, bytes], tmp_path: Path, run: Run
) -> None:
    out = clips.parent / tmp_path.name
    command = [sys.executable, "-m", "footfix", "clean", str(clips), "-o", str(out), "--report", "json", "-j2"]
    # a session of its own, so that its workers can be killed with it, as a power cut would
    process = subprocess.Popen(command, env=ENVIRONMENT, stderr=subprocess.DEVNULL, start_new_session=True)
    deadline = time.monotonic() + 60.0
    while not list(out.rglob("*.contacts.json")) and time.monotonic() < deadline and process.poll() is None:
        time.sleep(0.005)
    os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    for name, data in contents(out).items():  # whatever stands under its own name is whole
        if not name.startswith(".footfix") and "/.footfix" not in name:
            assert alone[name] == data, name
    assert run("clean", clips, "-o", out, "--report", "json", "-j1")[0] == 2 or not contents(out)
    code, _, err = run("clean", clips, "-o", out, "--report", "json", "-j1", "--resume")
    assert code == 3, err
    assert contents(out) == alone


@POSIX
@pytest.mark.parametrize("workers", ["-j1", "-j2"])
def test_an_interrupt_finishes_what_runs_and_keeps_it(
    clips: Path, alone: dict[str, bytes], tmp_path: Path, workers: str, run: Run
) -> None:
    out = clips.parent / tmp_path.name
    command = [sys.executable, "-m", "footfix", "clean", str(clips), "-o", str(out), "--report", "json", workers]
    process = subprocess.Popen(command, env=ENVIRONMENT, stderr=subprocess.PIPE, text=True, start_new_session=True)
    deadline = time.monotonic() + 60.0
    while not list(out.rglob("*.bvh")) and time.monotonic() < deadline and process.poll() is None:
        time.sleep(0.002)
    os.killpg(process.pid, signal.SIGINT)  # a terminal sends it to all of them
    _, err = process.communicate(timeout=60)
    assert process.returncode == 130 and "Traceback" not in err and "once more" in err
    found = contents(out)
    assert not [name for name in found if name.endswith(".tmp")]
    assert all(alone[name] == data for name, data in found.items() if not name.startswith(".footfix"))
    for name in found:  # no clip is there in part
        if name.endswith(".bvh"):
            assert name.removesuffix(".bvh") + ".report.json" in found
    assert run("clean", clips, "-o", out, "--report", "json", "--resume", "-j1")[0] == 3
    assert contents(out) == alone


@POSIX
def test_a_second_interrupt_ends_it_at_once(clips: Path, tmp_path: Path) -> None:
    out = clips.parent / tmp_path.name
    command = [sys.executable, "-m", "footfix", "clean", str(clips), "-o", str(out), "--report", "json", "-j2"]
    process = subprocess.Popen(command, env=ENVIRONMENT, stderr=subprocess.PIPE, text=True, start_new_session=True)
    while not (out / ".footfix").exists() and process.poll() is None:
        time.sleep(0.002)
    time.sleep(0.3)
    for _ in range(2):
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGINT)
        time.sleep(0.05)
    _, err = process.communicate(timeout=30)
    assert process.returncode in (130, 3) and "Traceback" not in err  # 3: it was done before
    assert not [name for name in contents(out) if name.endswith(".tmp")]
