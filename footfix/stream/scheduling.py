"""Work that is spread over frames, so that none of them takes the time of all."""

from __future__ import annotations

from collections.abc import Iterator

_OVER = object()  # no parts are left


class SpreadWork:
    """Work in parts, of which a few are done with each frame."""

    def __init__(self, parts: int, frames: int) -> None:
        """Begin without work.

        Args:
            parts: that a work has at most.
            frames: over which they are spread: that in which it begins, and those after it.
        """
        self._parts, self._frames = parts, frames
        self._work: Iterator[None] = iter(())
        self.done = self._since = 0  # parts that were done, and frames that came since the work began

    def begin(self, work: Iterator[None]) -> None:
        """Begin a work that pauses after each of its parts; what was before is done."""
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
        """Do all that are left."""
        for _ in self._work:
            pass
