"""Tasks on a running Dask cluster: workers read and write the files on paths that all machines share.

Only names, settings and small results pass through the scheduler, never motion data. When a worker is lost, the
scheduler itself gives its clip to another one, and gives the clip up after three.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any

from footfix.batch.processes import Results, Stop, Work
from footfix.batch.task import FileResult, Task
from footfix.errors import UsageError

_AHEAD = 4  # tasks submitted per thread of the cluster; few, so that a stop does not leave thousands
_LOOKS = 0.05  # [s] between looks for a result
_COUNTS = 5.0  # [s] between counts of the workers, while there is none
_ALONE = 600.0  # [s] without any worker after which the tasks are given up; a queue may take minutes to start one


def on_cluster(
    work: Work, tasks: Sequence[Task], *, address: str, stop: Stop, starting: Callable[[int], None]
) -> Results:
    """Do the tasks on the cluster at an address, and yield each result as it comes.

    Raises:
        UsageError: `distributed` is not installed, or nothing answers at the address.
    """
    client = _connect(address)
    try:
        yield from _feed(client, work, tasks, stop, starting)
    finally:
        client.close()


def _connect(address: str) -> Any:
    try:
        import distributed
    except ImportError:
        raise UsageError("--dask needs the package distributed: pip install distributed") from None
    try:
        dask: Any = distributed  # it declares no types
        return dask.Client(address, timeout=15, set_as_default=False)
    except (OSError, ValueError, TimeoutError) as error:
        raise UsageError(f"--dask {address}: no scheduler answers there ({error})") from None


def _feed(client: Any, work: Work, tasks: Sequence[Task], stop: Stop, starting: Callable[[int], None]) -> Results:
    threads = max(sum(client.nthreads().values()), 1)
    suspects: list[int] = []
    for index, end in _results(client, work, tasks, range(len(tasks)), _AHEAD * threads, stop, starting):
        if _was_lost(end):
            suspects.append(index)
        else:
            yield index, _result(end, tasks[index])
    # A lost worker also loses clips that only waited there: one at a time, each is judged by itself.
    for index, end in _results(client, work, tasks, suspects, 1, stop, lambda index: None):
        yield index, _result(end, tasks[index])


def _results(
    client: Any, work: Work, tasks: Sequence[Task], order: Iterable[int], ahead: int, stop: Stop,
    starting: Callable[[int], None],
) -> Iterator[tuple[int, FileResult | Exception]]:  # fmt: skip
    """Submit tasks, `ahead` of them at a time, and yield the end of each."""
    import distributed

    dask: Any = distributed
    waiting, at_work = iter(order), {}
    ended = dask.as_completed([], loop=client.loop, raise_errors=False)

    def submit() -> None:
        index = None if stop.soon else next(waiting, None)
        if index is not None:
            starting(index)
            # safe to repeat: the same work writes the same bytes, and each file whole
            future = client.submit(work, tasks[index], pure=False)
            at_work[future] = index
            ended.add(future)

    for _ in range(ahead):
        submit()
    while at_work:
        if not _ready(client, ended):
            lost = RuntimeError(f"no worker was left for {_ALONE / 60.0:.0f} minutes")
            yield from ((index, lost) for index in (*at_work.values(), *(() if stop.soon else waiting)))
            return
        future = next(ended)
        yield at_work.pop(future), _end(future)
        submit()


def _ready(client: Any, ended: Any) -> bool:
    """Wait for a result; give up where the cluster has had no worker for too long."""
    counted = seen = time.monotonic()
    while not ended.has_ready():
        time.sleep(_LOOKS)
        now = time.monotonic()
        if now - counted >= _COUNTS:
            counted = now
            seen = now if client.nthreads() else seen
            if now - seen >= _ALONE:
                return False
    return True


def _end(future: Any) -> FileResult | Exception:
    """Get the result, or the error, of a future that has ended.

    A result lost with its worker before it was fetched is computed again, and waited for.
    """
    try:
        result: FileResult = future.result()
    except asyncio.CancelledError as error:  # it is no subclass of Exception, and was not requested here
        return RuntimeError(f"cancelled {error}".strip())
    except Exception as error:
        return error
    return result


def _was_lost(end: FileResult | Exception) -> bool:
    return type(end).__name__ == "KilledWorker"


def _result(end: FileResult | Exception, task: Task) -> FileResult:
    if isinstance(end, FileResult):
        return end
    why = "its workers were lost, one after the other" if _was_lost(end) else f"the cluster gave it up ({end})"
    return FileResult(task.job.source, "failed", error=f"{task.job.source}: {why}")
