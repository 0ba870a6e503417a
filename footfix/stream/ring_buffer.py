"""The last frames of a track, by their number since the stream began."""

from __future__ import annotations

import numpy as np

from footfix.motion.clip import Floats


class Ring:
    """The newest rows of a growing array; older ones are dropped, so that memory stays constant.

    Rows lie side by side: half of the memory is spent so that a stretch of them is a view, not a copy.
    """

    def __init__(self, shape: tuple[int, ...], capacity: int) -> None:
        """Make an empty one.

        Args:
            shape: of a row.
            capacity: rows that are remembered at least.
        """
        self._rows = np.zeros((2 * capacity, *shape))
        self._capacity = capacity
        self._start = 0  # number of the first row that is remembered
        self._length = 0

    @property
    def start(self) -> int:
        """Number of the first row that is remembered."""
        return self._start

    @property
    def end(self) -> int:
        """Number of the row that comes next."""
        return self._start + self._length

    def append(self, rows: Floats) -> None:
        """Add rows (n, ...) at the end."""
        for first in range(0, len(rows), self._capacity):
            part = rows[first : first + self._capacity]
            if self._length + len(part) > len(self._rows):
                keep = self._capacity - len(part)
                self._rows[:keep] = self._rows[self._length - keep : self._length].copy()
                self._start += self._length - keep
                self._length = keep
            self._rows[self._length : self._length + len(part)] = part
            self._length += len(part)

    def replace(self, first: int, rows: Floats) -> None:
        """Put rows (n, ...) from number `first` on, in place of those that stand there and after the last."""
        self._length = min(self._length, first - self._start)
        self.append(rows)

    def view(self, first: int, stop: int | None = None) -> Floats:
        """Get the rows `[first, stop)`, as far as they are remembered."""
        stop = self.end if stop is None else stop
        return self._rows[max(first - self._start, 0) : stop - self._start]

    def last(self, count: int) -> Floats:
        """Get the newest rows, so many of them or all there are."""
        count = min(count, self._length)
        return self._rows[self._length - count : self._length]
