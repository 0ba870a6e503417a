"""Tasks on worker processes; a worker that dies costs only the clip that it worked on.

Python's own process pool breaks as a whole when one worker is killed, and can't stop a task that takes too long.
Here every worker has a pipe of its own, so that its task is known, and its end costs that task alone.
"""

from __future__ import annotations

import gc
import os
import signal
import sys
import time
from collections import deque
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from footfix.batch.file_io import remove_leftovers
from footfix.batch.task import FileResult, Task
from footfix.errors import FootfixError

if TYPE_CHECKING:
    from multiprocessing.connection import Connection
    from multiprocessing.process import BaseProcess

Work = Callable[[Task], FileResult]
Results = Generator[tuple[int, FileResult], None, None]  # index and result, as they come

_LOOK = 0.25  # [s] how often a stop is checked for while no worker reports
_MOST_STILLBORN = 3  # workers that may die before their first task; more can't be the fault of a clip


class Stop:
    """The user's wish to stop: after one interrupt running clips finish, after a second they are killed."""

    def __init__(self) -> None:
        self.asked = 0

    @property
    def soon(self) -> bool:
        return self.asked > 0


@dataclass(eq=False)
class _Worker:
    process: BaseProcess
    pipe: Connection
    ready: bool = False
    task: int | None = None
    since: float = 0.0


def here(work: Work, tasks: Sequence[Task], *, stop: Stop, starting: Callable[[int], None]) -> Results:
    """Do the tasks one after the other in this process."""
    for index, task in enumerate(tasks):
        if stop.soon:
            return
        starting(index)
        yield index, work(task)


def on_processes(
    work: Work, tasks: Sequence[Task], *, workers: int, timeout: float | None, stop: Stop,
    starting: Callable[[int], None],
) -> Results:  # fmt: skip
    """Do the tasks on several processes, and yield each result as it comes.

    Args:
        work: a function of a module, for each task.
        tasks: what is to be done.
        workers: how many processes.
        timeout: [s] after which a task is given up and its process killed.
        stop: checked before each task is handed out.
        starting: called with the index of each task just before it is handed out.

    Yields:
        Index and result of each task, in the order in which they end.

    Raises:
        FootfixError: processes can't be started here.
    """
    waiting = deque(range(len(tasks)))
    crew: list[_Worker] = []
    for _ in range(max(min(workers, len(tasks)), 1)):
        crew.append(_hire(work, crew))
    stillborn = 0
    try:
        while waiting or any(worker.task is not None for worker in crew):
            if stop.soon:
                waiting.clear()
            for worker in crew:
                if waiting and worker.ready and worker.task is None:
                    _hand_out(worker, waiting, tasks, starting)
            for worker in _heard(crew, timeout):
                index, result = _outcome(worker, tasks, timeout)
                if result is not None and index is not None:
                    yield index, result
                if not worker.process.is_alive() or worker.pipe.closed:
                    stillborn += not worker.ready
                    if stillborn >= _MOST_STILLBORN:
                        raise FootfixError("worker processes end as soon as they start; -j1 works without them")
                    crew.remove(worker)
                    if waiting:
                        crew.append(_hire(work, crew))
    finally:
        for worker in crew:
            _dismiss(worker, tasks)


def _way() -> Literal["fork", "spawn"]:
    """Choose how workers start: "fork" or "spawn".

    A forked process has all modules loaded; a spawned one needs half a second of processor time to load them, as long
    as ten clips of 300 frames take. A fork copies no threads, so it is chosen only where there are none; and only on
    Linux, where they can be counted and the system libraries support it.
    """
    tasks = Path("/proc/self/task")
    alone = sys.platform == "linux" and tasks.is_dir() and len(list(tasks.iterdir())) == 1
    return "fork" if alone else "spawn"


def _hire(work: Work, crew: Sequence[_Worker]) -> _Worker:
    import multiprocessing  # needed for several clips only, and slow to import

    ours, theirs = multiprocessing.Pipe()
    process: BaseProcess
    if _way() == "fork":
        import footfix.jobs.clean  # noqa: F401  # what all workers need is loaded once, before they part

        gc.freeze()  # keeps the garbage collector from touching, and so copying, shared memory
        not_theirs = (ours, *(worker.pipe for worker in crew))
        process = multiprocessing.get_context("fork").Process(
            target=_serve, args=(theirs, work, not_theirs), daemon=True
        )
    else:
        process = multiprocessing.get_context("spawn").Process(target=_serve, args=(theirs, work), daemon=True)
        if os.name == "posix":
            from multiprocessing import resource_tracker

            resource_tracker.ensure_running()  # its start unblocks interrupts: started before they are blocked
    with _no_interrupts():
        process.start()
    theirs.close()
    return _Worker(process, ours)


@contextmanager
def _no_interrupts() -> Iterator[None]:
    """Block Ctrl-C in processes started within, also before they can ignore it themselves."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _serve(pipe: Connection, work: Work, not_mine: Sequence[Connection] = ()) -> None:
    """Run a worker: receive a task, send its result, until the pipe closes."""
    # Ctrl-C reaches every process of a terminal; only the parent decides what stops
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)  # not the parent's handler
    for other in not_mine:  # a pipe counts as open while any process holds its other end
        other.close()
    with suppress(EOFError, OSError):
        pipe.send(None)
        while True:
            task = pipe.recv()
            pipe.send(work(task))


def _hand_out(
    worker: _Worker, waiting: deque[int], tasks: Sequence[Task], starting: Callable[[int], None]
) -> None:  # fmt: skip
    index = waiting[0]
    starting(index)
    try:
        worker.pipe.send(tasks[index])
    except OSError:  # it has just died, which is noticed later; the task remains
        return
    waiting.popleft()
    worker.task, worker.since = index, time.monotonic()


def _heard(crew: Sequence[_Worker], timeout: float | None) -> list[_Worker]:
    """Wait for workers that have a result, have died, or are out of time."""
    from multiprocessing.connection import wait

    by_handle: dict[Any, _Worker] = {}
    for worker in crew:
        by_handle[worker.pipe] = worker
        by_handle[worker.process.sentinel] = worker
    now = time.monotonic()
    rest = [worker.since + timeout - now for worker in crew if worker.task is not None] if timeout else []
    spoke = wait(list(by_handle), timeout=max(min([_LOOK, *rest]), 0.0))
    heard = list(dict.fromkeys(by_handle[handle] for handle in spoke))
    if timeout:
        now = time.monotonic()
        heard += [
            worker for worker in crew
            if worker.task is not None and now - worker.since >= timeout and worker not in heard
        ]  # fmt: skip
    return heard


def _outcome(worker: _Worker, tasks: Sequence[Task], timeout: float | None) -> tuple[int | None, FileResult | None]:
    """Find the task of a worker and its result; None for a worker that has only reported its start."""
    index = worker.task
    try:
        if worker.pipe.poll():
            said = worker.pipe.recv()
            worker.ready, worker.task = True, None
            return index, said
    except (EOFError, OSError):
        pass
    in_time = timeout is None or time.monotonic() - worker.since < timeout
    if worker.process.is_alive() and index is not None and not in_time:
        _kill(worker, tasks)
        return index, _lost(tasks[index], f"took longer than {timeout:g} s and was stopped")
    worker.process.join(5.0)
    _kill(worker, tasks)
    return index, None if index is None else _lost(tasks[index], _end(worker.process.exitcode))


def _lost(task: Task, why: str) -> FileResult:
    return FileResult(task.job.source, "failed", error=f"{task.job.source}: {why}")


def _end(code: int | None) -> str:
    if code is not None and code < 0:
        name = signal.Signals(-code).name if -code in set(signal.Signals) else str(-code)
        memory = ", most often for want of memory" if name == "SIGKILL" else ""
        return f"its process was killed by the system ({name}{memory})"
    return f"its process ended by itself (exit code {code})"


def _dismiss(worker: _Worker, tasks: Sequence[Task]) -> None:
    """End an idle worker; kill one that is still working."""
    if worker.task is None:
        worker.pipe.close()
        worker.process.join(2.0)
    _kill(worker, tasks)


def _kill(worker: _Worker, tasks: Sequence[Task]) -> None:
    process = worker.process.pid
    if worker.process.is_alive():
        worker.process.kill()
        worker.process.join()
    worker.pipe.close()
    if worker.task is not None:
        task = tasks[worker.task]
        if task.job.target is not None:
            remove_leftovers(Path(task.folder, task.job.target).parent, tag=task.tag, process=process)
    worker.task = None
