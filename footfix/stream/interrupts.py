"""Interrupts of a stream: the first ends it in an orderly way and in bounded time, the second at once.

An exception could be raised in the middle of a step, and would be lost inside a callback of Python itself. So the first
signal only sets a flag; a waiting thread ends the process if the orderly end takes too long.
"""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from footfix.errors import ExitCode

ENDING = 5.0  # [s] longest time for the end, whatever its reader or its threads wait for


class Interrupted:
    """Whether a stream was interrupted."""

    def __init__(self) -> None:
        self.came = False


@contextmanager
def interrupts(ending: float = ENDING) -> Iterator[Interrupted]:
    """Record Ctrl-C and SIGTERM (which schedulers send) instead of raising.

    Args:
        ending: [s] after which the process is ended from the first one on.
    """
    state = Interrupted()
    if threading.current_thread() is not threading.main_thread():
        yield state
        return
    # Only locks: other means to wake a thread may be held by the code that the signal interrupts.
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
