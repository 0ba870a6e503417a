"""The same batch on a Dask cluster of two workers, one of which is killed in the middle of a clip."""

from __future__ import annotations

import asyncio
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import artefacts
import batch_tasks
import exports
import pytest
from walker import make
from walker_plan import Gait

from footfix.batch import dask_cluster as cluster_work
from footfix.batch.inputs import sources
from footfix.batch.one_file import clean_one
from footfix.batch.output_paths import plan
from footfix.batch.run import Crew, run
from footfix.batch.task import FileResult, Task
from footfix.errors import UsageError
from footfix.settings import ReportParams, Settings


@pytest.fixture(scope="module")
def cluster() -> Iterator[Any]:
    distributed = pytest.importorskip("distributed")
    import dask

    dask.config.set({"distributed.scheduler.allowed-failures": 1})
    if sys.platform == "linux":  # workers are forked from one process that has loaded everything, and never worked
        dask.config.set({"distributed.worker.multiprocessing-method": "forkserver"})
        distributed.utils.get_mp_context().set_forkserver_preload(
            ["distributed", "footfix.batch.one_file", "footfix.pipeline"]
        )
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None, silence_logs=50
    ) as cluster:
        # workers are other machines, as it were: what a test's work is, they have to be told
        with distributed.Client(cluster) as client:
            client.run(sys.path.extend, [str(Path(__file__).parents[1])])
        yield cluster


@pytest.fixture
def tasks(tmp_path: Path) -> list[Task]:
    for k, name in enumerate("abc"):
        walk = make(Gait(name="walk", duration=1.3, fps=30, seed=k))
        (tmp_path / "in").mkdir(exist_ok=True)
        (tmp_path / "in" / f"{name}.bvh").write_bytes(exports.bvh(artefacts.wander(walk.clip, 0.05)))
    (tmp_path / "in" / "broken.bvh").write_bytes(b"nothing")
    return [
        Task(job, Settings(report=ReportParams(kind="json")), folder=str(tmp_path))
        for job in plan(
            sources([str(tmp_path / "in")]), output=tmp_path / "out", in_place=False,
            suffixes=lambda source: (".contacts.json", ".report.json"), force=True,
        )
    ]  # fmt: skip


def contents(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()}


def test_a_cluster_gives_the_same_bytes_a_killed_worker_included(
    cluster: Any, tasks: list[Task], tmp_path: Path
) -> None:
    assert run(clean_one, tasks, crew=Crew(workers=1), on_result=lambda each: None).interrupted is False
    alone = contents(tmp_path / "out")
    for path in (tmp_path / "out").iterdir():
        path.unlink()
    crew = Crew(dask=cluster.scheduler_address)
    work = batch_tasks.clean_or_die_once if sys.platform != "win32" else clean_one
    outcome = run(work, tasks, crew=crew, on_result=lambda each: None)
    assert [each.status for each in outcome.results] == ["cleaned", "cleaned", "failed", "cleaned"]
    assert "broken.bvh" in outcome.results[2].error
    if sys.platform != "win32":
        assert (tmp_path / "died").exists()
    assert contents(tmp_path / "out") == alone


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX systems")
def test_a_clip_that_kills_every_worker_is_given_up_and_named(
    cluster: Any, tasks: list[Task], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cluster.scheduler, "allowed_failures", 0)  # one worker is every worker, and soon there again
    monkeypatch.setattr(cluster_work, "_ALONE", 60.0)
    deadly = replace(tasks[0], job=replace(tasks[0].job, source="die1", name="die1"))
    harmless = replace(tasks[0], job=replace(tasks[0].job, source="x", name="x"))
    crew = Crew(dask=cluster.scheduler_address)
    outcome = run(batch_tasks.act, [deadly, harmless], crew=crew, on_result=lambda each: None)
    assert [each.status for each in outcome.results] == ["failed", "done"], [each.error for each in outcome.results]
    assert "die1" in outcome.results[0].error and "lost" in outcome.results[0].error


def test_tasks_are_given_up_where_no_worker_comes_for_long(monkeypatch: pytest.MonkeyPatch, tasks: list[Task]) -> None:
    distributed = pytest.importorskip("distributed")
    monkeypatch.setattr(cluster_work, "_COUNTS", 0.1)
    monkeypatch.setattr(cluster_work, "_ALONE", 0.3)
    with distributed.LocalCluster(n_workers=0, processes=False, dashboard_address=None, silence_logs=50) as empty:
        crew = Crew(dask=empty.scheduler_address)
        outcome = run(clean_one, tasks, crew=crew, on_result=lambda each: None)
    assert [each.status for each in outcome.results] == ["failed"] * len(tasks)
    assert all("no worker was left" in (each.error or "") for each in outcome.results)


def test_an_address_where_nothing_answers_is_a_usage_error(tasks: list[Task], monkeypatch: pytest.MonkeyPatch) -> None:
    distributed = pytest.importorskip("distributed")
    real = distributed.Client
    monkeypatch.setattr(distributed, "Client", lambda address, **more: real(address, **{**more, "timeout": 0.3}))
    with pytest.raises(UsageError, match="no scheduler"):
        run(clean_one, tasks, crew=Crew(dask="tcp://127.0.0.1:9"), on_result=lambda each: None)


def test_a_result_lost_with_its_worker_is_waited_for_and_a_lost_clip_told_apart() -> None:
    killed = type("KilledWorker", (Exception,), {})  # named as the cluster's own

    class Ended:
        status = "pending"  # finished, and then its worker went: the scheduler makes it anew

        def __init__(self, end: object) -> None:
            self.end = end

        def result(self) -> object:
            if isinstance(self.end, BaseException):
                raise self.end
            return self.end

    done = FileResult("walk.bvh", "done")
    assert cluster_work._end(Ended(done)) is done
    assert cluster_work._was_lost(cluster_work._end(Ended(killed())))
    cancelled = cluster_work._end(Ended(asyncio.CancelledError()))
    assert isinstance(cancelled, Exception) and not cluster_work._was_lost(cancelled)
