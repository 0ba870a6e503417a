"""Independent parts of the work on one clip, on several processors."""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Callable, Sequence
from contextvars import ContextVar
from typing import TypeVar

LONG = 2000  # from this length of arrays on most of the time goes into numpy, which lets other threads run
_MOST = 4  # threads; more of them mostly wait for each other's Python

Result = TypeVar("Result")
_shared = ContextVar("_shared", default=False)  # whether this thread is one of those that share the work on a clip


def at_once(tasks: Sequence[Callable[[], Result]], size: int) -> list[Result]:
    """Do tasks that do not depend on each other, side by side where that is faster.

    Args:
        tasks: what to do.
        size: how long the arrays are that they work on.

    Returns:
        What each returned; the same as if they were done one after the other.
    """
    count = min(len(tasks), _MOST, processors() if size >= LONG else 1)
    if count < 2:
        return [task() for task in tasks]
    import numpy as np  # slow to load, and a batch only counts processors

    done: dict[int, Result] = {}
    faults: list[BaseException] = []
    errors = np.geterr()

    def some(first: int) -> None:
        token = _shared.set(True)
        try:
            with np.errstate(**errors):
                for k in range(first, len(tasks), count):
                    done[k] = tasks[k]()
        except BaseException as fault:  # raised again below, in the caller's thread
            faults.append(fault)
        finally:
            _shared.reset(token)

    # The caller's thread takes a share, unlike with an executor of the standard library: one more thread would keep
    # tens of megabytes of its own.
    threads = [threading.Thread(target=some, args=(k,)) for k in range(1, count)]
    for thread in threads:
        thread.start()
    some(0)
    for thread in threads:
        thread.join()
    if faults:
        raise faults[0]
    return [done[k] for k in range(len(tasks))]


def halves(count: int) -> tuple[slice, slice]:
    """Divide `count` frames into two spans."""
    return slice(0, count // 2), slice(count // 2, count)


def processors() -> int:
    """Count the processors that this thread may use: one where others have work of their own.

    So it is in the workers of a batch, and in the threads of a program that cleans several clips at once.
    """
    if _shared.get() or threading.current_thread() is not threading.main_thread():
        return 1
    processes = sys.modules.get("multiprocessing")  # where it is not loaded, this is nobody's worker
    return 1 if processes and processes.parent_process() else available()


def available() -> int:
    """Count the processors that this process may use: a job in a cluster's queue has fewer than the machine."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
