"""Bounded queues between the reader, the worker and the writer of a stream."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from typing import Any

WAITING = 512  # most items that wait


class Backlog:
    """Items on their way from one thread to another."""

    def __init__(self, *, drops: bool, droppable: Callable[[Any], bool] = lambda item: True) -> None:
        """Begin empty.

        Args:
            drops: whether the oldest item is dropped, and counted, where too many wait; otherwise `put` blocks.
            droppable: tells which items may be dropped.
        """
        self._items: deque[Any] = deque()
        self._changed = threading.Condition()
        self._drops, self._droppable = drops, droppable
        self._closed = False
        self.dropped = 0

    def put(self, item: Any) -> bool:
        """Add an item; return False where the queue is closed."""
        with self._changed:
            while len(self._items) >= WAITING and not self._closed:
                if not self._drops:
                    self._changed.wait()
                elif not self._drop():
                    break
            if not self._closed:
                self._items.append(item)
                self._changed.notify_all()
            return not self._closed

    def _drop(self) -> bool:
        for k, item in enumerate(self._items):
            if self._droppable(item):
                del self._items[k]
                self.dropped += 1
                return True
        return False

    def get(self, timeout: float | None = None) -> Any:
        """Take the oldest item; None after `timeout` [s], or where all is closed and taken."""
        with self._changed:
            if not self._items and not self._closed:
                self._changed.wait(timeout)
            item = self._items.popleft() if self._items else None
            self._changed.notify_all()
            return item

    def close(self, *, now: bool = False) -> None:
        """Take no more items; with `now`, forget those that wait."""
        with self._changed:
            self._closed = True
            if now:
                self._items.clear()
            self._changed.notify_all()

    @property
    def empty(self) -> bool:
        """Tell whether nothing waits."""
        return not self._items


class Outlet:
    """Bytes for a reader that may be slow: the oldest frames are then dropped and counted."""

    def __init__(self, write: Callable[[bytes], None]) -> None:
        """Start the thread that writes.

        Args:
            write: blocks until the bytes are written; raises OSError where the reader has gone.
        """
        self._write, self._backlog = write, Backlog(drops=True)
        self.gone = False
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    @property
    def dropped(self) -> int:
        """Count the writes that were dropped."""
        return self._backlog.dropped

    def put(self, data: bytes) -> None:
        """Send bytes, later."""
        self._backlog.put(data)

    def _run(self) -> None:
        try:
            while (data := self._backlog.get()) is not None:
                self._write(data)
        except (OSError, ValueError):
            self.gone = True
            self._backlog.close(now=True)

    def close(self, patience: float = 2.0) -> None:
        """Send what waits, for no longer than `patience` [s]."""
        self._backlog.close()
        self._thread.join(patience)
