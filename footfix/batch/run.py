"""A run over many clips: on which processes tasks are done, what is reported meanwhile, and how it is interrupted."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from footfix.batch.file_io import STDIN, remove_leftovers
from footfix.batch.journal import Journal
from footfix.batch.processes import Results, Stop, Work, here, on_processes
from footfix.batch.task import FileResult, Task
from footfix.motion.threads import available

# With fewer clips than this a worker process takes longer to start than it saves.
_WORTH_A_PROCESS = 4

# Clips that are recorded ahead in the journal: flushing it for each would take longer than some clips do.
_ANNOUNCED_AT_ONCE = 32


@dataclass(frozen=True)
class Crew:
    """Where the work is done.

    Args:
        workers: processes; 0 for one a processor, where there are enough clips.
        timeout: [s] for one clip, None for ever.
        dask: address of a Dask scheduler, "" for this machine.
    """

    workers: int = 0
    timeout: float | None = None
    dask: str = ""


@dataclass(frozen=True)
class Outcome:
    """The results of a run, in the order of its tasks, and whether it was interrupted."""

    results: tuple[FileResult, ...]
    interrupted: bool = False


def run(
    work: Work, tasks: Sequence[Task], *, crew: Crew, on_result: Callable[[FileResult], None],
    journal: Journal | None = None, on_interrupt: Callable[[int], None] = lambda running: None,
) -> Outcome:  # fmt: skip
    """Do all tasks; one that fails does not stop the others.

    Args:
        work: the function that does a task.
        tasks: in the order of the results.
        crew: where they are done.
        on_result: called with each result, in the order in which clips end.
        journal: records each clip before it begins and after it ends.
        on_interrupt: called once, at the first interrupt.

    Raises:
        KeyboardInterrupt: at the second interrupt; what was finished before it is kept.
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
        _interrupts(stop, lambda: on_interrupt(len(tasks) - len(results))),
        # closing it at an interrupt kills the processes and removes their temporary files
        closing(_done(work, tasks, crew, stop, starting)) as ended,
    ):
        for index, result in ended:
            results[index] = result
            journal.end(tasks[index].job.name, result)
            on_result(result)
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
    workers = crew.workers or (available() if len(chosen) >= _WORTH_A_PROCESS else 1)
    if crew.dask:
        from footfix.batch.dask_cluster import on_cluster

        ended = on_cluster(work, chosen, address=crew.dask, stop=stop, starting=begin)
    elif workers > 1 or crew.timeout is not None:
        ended = on_processes(work, chosen, workers=workers, timeout=crew.timeout, stop=stop, starting=begin)
    else:
        ended = here(work, chosen, stop=stop, starting=begin)
    with closing(ended):
        for k, result in ended:
            yield others[k], result


def _clear_leftovers(tasks: Sequence[Task]) -> None:
    """Remove temporary files of the run that is being resumed; without --resume they may be those of a running one."""
    folders = {
        (Path(task.folder, task.job.target).parent, task.tag)
        for task in tasks
        if task.resume and task.job.target is not None and not task.dry_run
    }
    for folder, tag in folders:
        remove_leftovers(folder, tag=tag)


@contextmanager
def _interrupts(stop: Stop, first: Callable[[], None]) -> Iterator[None]:
    """Stop softly at the first Ctrl-C (or SIGTERM, as schedulers send it), and at once at the second."""
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
