"""Interrupts of a stream: the first one ends it softly and in bounded time, the second one at once.

An exception would come in the midst of a step, and is lost where it comes within a callback of Python's own. So the
first signal only says that it came; a thread that waited for it sees to it that the end takes no longer than it may.
"""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from footfix.errors import ExitCode

ENDING = 5.0  # [s] that the end may take, whatever its reader or its threads wait for


class Interrupted:
    """Whether a stream was interrupted."""

    def __init__(self) -> None:
        self.came = False


@contextmanager
def interrupts(ending: float = ENDING) -> Iterator[Interrupted]:
    """Tell of Ctrl-C, and of SIGTERM, as schedulers send it, instead of raising.

    Args:
        ending: [s] after which the process is ended from the first one on.
    """
    state = Interrupted()
    if threading.current_thread() is not threading.main_thread():
        yield state
        return
    # Locks alone: what else wakes a thread may be held by the very code that a signal interrupts.
    come, over = threading.Lock(), threading.Lock()
    come.acquire()
    over.acquire()

    def bound() -> None:
        come.acquire()
        if not over.acquire(timeout=ending):
            os._exit(ExitCode.INTERRUPTED)

    def asked(number: int, frame: Any) -> None:
        if state.came:
            os._exit(ExitCode.INTERRUPTED)
        state.came = True
        come.release()

    threading.Thread(target=bound, daemon=True).start()
    before = {number: signal.signal(number, asked) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield state
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        over.release()
        if not state.came:
            come.release()
