"""Spread a hop's work over several frames, so that no frame pays for all of it."""

from __future__ import annotations

from collections.abc import Iterator

_OVER = object()  # no parts are left


class SpreadWork:
    """Work in parts, a few of which are done with each frame."""

    def __init__(self, parts: int, frames: int) -> None:
        """Begin without work.

        Args:
            parts: most parts of a work.
            frames: over which they are spread: that in which it begins, and those after it.
        """
        self._parts, self._frames = parts, frames
        self._work: Iterator[None] = iter(())
        self.done = self._since = 0  # parts that were done, and frames that came since the work began

    def begin(self, work: Iterator[None]) -> None:
        """Begin a work, a generator that yields after each part; the one before is finished first."""
        self._work, self.done, self._since = work, 0, 0

    def advance(self) -> None:
        """Do the parts that are due with the next frame."""
        self._since += 1
        due = self._parts * self._since // self._frames
        while self.done < due:
            self.done += 1
            if next(self._work, _OVER) is _OVER:
                self.done = due

    def finish(self) -> None:
        """Do all remaining parts."""
        for _ in self._work:
            pass
