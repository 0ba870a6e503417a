"""A run over many clips: who does the tasks, what is told on the way, and how it is interrupted."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from footfix.batch.files import STDIN, remove_leftovers
from footfix.batch.journal import Journal
from footfix.batch.processes import Results, Stop, Work, here, on_processes
from footfix.batch.task import FileResult, Task

# With fewer clips than this a worker process takes longer to start than it saves.
_WORTH_A_PROCESS = 4

# Clips that the journal names ahead: to wait for the disk before each of them would cost more than some clips do.
_ANNOUNCED_AT_ONCE = 32


@dataclass(frozen=True)
class Crew:
    """Who does the work.

    Args:
        workers: processes; 0 for as many as there are processors, where that pays.
        timeout: [s] for one clip, None for ever.
        dask: address of a Dask scheduler, "" for this machine.
    """

    workers: int = 0
    timeout: float | None = None
    dask: str = ""


@dataclass(frozen=True)
class Outcome:
    """The results of a run, in the order of its tasks, and whether it was cut short."""

    results: tuple[FileResult, ...]
    interrupted: bool = False


def run(
    work: Work, tasks: Sequence[Task], *, crew: Crew, told: Callable[[FileResult], None],
    journal: Journal | None = None, asked_to_stop: Callable[[int], None] = lambda running: None,
) -> Outcome:  # fmt: skip
    """Do all tasks; one that fails does not stop the others.

    Args:
        work: what is done with each.
        tasks: in the order of the results.
        crew: who does it.
        told: each result as it comes, in the order in which clips end.
        journal: told before a clip is begun and after it ended.
        asked_to_stop: told once, when the first interrupt comes.

    Raises:
        KeyboardInterrupt: the second one; what was finished till then stays.
    """
    journal = journal or Journal()
    stop = Stop()
    _clear_leftovers(tasks)

    announced = 0

    def starting(index: int) -> None:
        nonlocal announced
        while index >= announced:
            some = tasks[announced : announced + _ANNOUNCED_AT_ONCE]
            journal.begin([task.job.name for task in some if task.job.target is not None])
            announced += len(some)

    results: dict[int, FileResult] = {}
    with (
        _interrupts(stop, lambda: asked_to_stop(len(tasks) - len(results))),
        # closed at once where an interrupt comes in between: processes are killed and what they left is cleared
        closing(_done(work, tasks, crew, stop, starting)) as ended,
    ):
        for index, result in ended:
            results[index] = result
            journal.end(tasks[index].job.name, result)
            told(result)
    return Outcome(tuple(results[index] for index in sorted(results)), stop.soon and len(results) < len(tasks))


def _done(work: Work, tasks: Sequence[Task], crew: Crew, stop: Stop, starting: Callable[[int], None]) -> Results:
    # standard input is this process's own
    own = [index for index, task in enumerate(tasks) if task.job.source == STDIN]
    others = [index for index, task in enumerate(tasks) if task.job.source != STDIN]
    for mine in own:
        starting(mine)
        yield mine, work(tasks[mine])
    chosen = [tasks[index] for index in others]

    def begin(k: int) -> None:
        starting(others[k])

    if not chosen:
        return
    ended: Results
    workers = crew.workers or (_processors() if len(chosen) >= _WORTH_A_PROCESS else 1)
    if crew.dask:
        from footfix.batch.cluster import on_cluster

        ended = on_cluster(work, chosen, address=crew.dask, stop=stop, starting=begin)
    elif workers > 1 or crew.timeout is not None:
        ended = on_processes(work, chosen, workers=workers, timeout=crew.timeout, stop=stop, starting=begin)
    else:
        ended = here(work, chosen, stop=stop, starting=begin)
    with closing(ended):
        for k, result in ended:
            yield others[k], result


def _processors() -> int:
    """Count the processors that are ours to use: a job of a cluster's queue has fewer than the machine."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _clear_leftovers(tasks: Sequence[Task]) -> None:
    """Remove temporary files of the killed run that is being resumed; without --resume they may be a live one's."""
    folders = {
        (Path(task.folder, task.job.target).parent, task.tag)
        for task in tasks
        if task.resume and task.job.target is not None and not task.dry_run
    }
    for folder, tag in folders:
        remove_leftovers(folder, tag=tag)


@contextmanager
def _interrupts(stop: Stop, first: Callable[[], None]) -> Iterator[None]:
    """Take the first Ctrl-C (or SIGTERM, as schedulers send it) as a wish to end, and the second one as the end."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def asked(number: int, frame: Any) -> None:
        stop.asked += 1
        if stop.asked > 1:
            raise KeyboardInterrupt
        first()

    before = {number: signal.signal(number, asked) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
