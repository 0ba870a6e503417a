"""The progress of a run on stderr: a bar on a terminal, plain lines elsewhere."""

from __future__ import annotations

import shutil
import sys
import time
from typing import TextIO

_LINES_EVERY = 10.0  # [s] between lines where there is no terminal
_BAR_EVERY = 0.1  # [s] between drawings of the bar


class Progress:
    """The progress of a run: clips done, failed, rate and time left.

    Args:
        total: clips of the run; for a single one, nothing is shown.
        shown: False for quiet.
        stream: where it is shown; standard error by default.
    """

    def __init__(self, total: int, *, shown: bool = True, stream: TextIO | None = None) -> None:
        self._stream = stream or sys.stderr
        self._total, self._shown = total, shown and total > 1
        self._terminal = self._shown and self._stream.isatty()
        self._begun = self._drawn = time.monotonic()
        self._done = self._failed = self._skipped = 0
        self._width = 0

    def step(self, *, failed: bool, skipped: bool) -> None:
        """Count a clip that has ended."""
        self._done += 1
        self._failed += failed
        self._skipped += skipped
        now = time.monotonic()
        if self._shown and now - self._drawn >= (_BAR_EVERY if self._terminal else _LINES_EVERY):
            self._drawn = now
            self._draw()

    def say(self, text: str) -> None:
        """Print a message above the bar."""
        self._wipe()
        print(text, file=self._stream, flush=True)
        if self._terminal:
            self._draw()

    def close(self) -> None:
        """Take the bar away."""
        self._wipe()
        self._terminal = False

    def _draw(self) -> None:
        line = self._line()
        if not self._terminal:
            print(line, file=self._stream, flush=True)
            return
        columns = shutil.get_terminal_size().columns - 1
        filled = round(20 * self._done / self._total)
        line = f"[{'#' * filled}{'.' * (20 - filled)}] {line}"[:columns]
        self._stream.write("\r" + line.ljust(self._width))
        self._stream.flush()
        self._width = len(line)

    def _line(self) -> str:
        passed = time.monotonic() - self._begun
        worked = self._done - self._skipped
        rate = worked / passed if passed > 0.0 else 0.0
        parts = [f"{self._done} of {self._total} clips"]
        if self._skipped:
            parts.append(f"{self._skipped} done before")
        if self._failed:
            parts.append(f"{self._failed} failed")
        if rate > 0.0:
            left = round((self._total - self._done) / rate)
            parts += [f"{rate:.1f} clips/s", f"{left // 3600}:{left // 60 % 60:02d}:{left % 60:02d} left"]
        return ", ".join(parts)

    def _wipe(self) -> None:
        if self._terminal and self._width:
            self._stream.write("\r" + " " * self._width + "\r")
            self._stream.flush()
            self._width = 0
