"""Tasks on a Dask cluster that is there already: workers read and write the files on paths that all machines share.

Through the scheduler go names and settings, and small results; never motion data. A worker that is lost is made up
for by the scheduler itself: it gives the clip to another one, and gives up after three.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

from footfix.batch.processes import Stop, Work
from footfix.batch.work import FileResult, Task
from footfix.errors import UsageError

_AHEAD = 4  # tasks a thread of the cluster has in hand or waiting, so that a stop does not leave thousands


def on_cluster(
    work: Work, tasks: Sequence[Task], *, address: str, stop: Stop, starting: Callable[[int], None]
) -> Iterator[tuple[int, FileResult]]:
    """Does the tasks on the cluster at an address, and gives each result as it comes.

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
        raise UsageError("--dask needs the package distributed: pip install 'footfix[dask]'") from None
    try:
        dask: Any = distributed  # it declares no types
        return dask.Client(address, timeout=15, set_as_default=False)
    except (OSError, ValueError, TimeoutError) as error:
        raise UsageError(f"--dask {address}: no scheduler answers there ({error})") from None


def _feed(
    client: Any, work: Work, tasks: Sequence[Task], stop: Stop, starting: Callable[[int], None]
) -> Iterator[tuple[int, FileResult]]:
    import distributed

    dask: Any = distributed
    at_work: dict[Any, int] = {}
    waiting = iter(enumerate(tasks))
    ended = dask.as_completed([], with_results=False, raise_errors=False)

    def submit() -> bool:
        index, task = next(waiting, (-1, None))
        if task is None or stop.soon:
            return False
        starting(index)
        # the same work twice gives the same bytes, each file whole: a second try is safe
        future = client.submit(work, task, pure=False, retries=0)
        at_work[future] = index
        ended.add(future)
        return True

    threads = sum(client.nthreads().values())
    for _ in range(max(_AHEAD * threads, 2)):
        if not submit():
            break
    while at_work:
        future = next(ended)
        index = at_work.pop(future)
        yield index, _result(future, tasks[index])
        submit()


def _result(future: Any, task: Task) -> FileResult:
    if future.status == "finished":
        result: FileResult = future.result()
        return result
    error = future.exception() if future.status == "error" else None
    lost = type(error).__name__ == "KilledWorker"
    why = "its workers were lost, one after the other" if lost else f"the cluster gave it up ({error or future.status})"
    return FileResult(task.job.source, "failed", error=f"{task.job.source}: {why}")
