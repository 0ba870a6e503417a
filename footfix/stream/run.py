"""Run a stream from its input to its outputs: corrected rows, events, and messages about faults."""

from __future__ import annotations

import gc
import json
import os
import stat
import time
from collections import Counter, deque
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from typing import IO

from footfix.errors import FootfixError, InputError
from footfix.formats.bvh.document import Document
from footfix.notes import Note
from footfix.settings import Settings
from footfix.stream.backlog import Backlog, Outlet
from footfix.stream.bvh_lines import Header, Row, Said, counted, header_of, with_room
from footfix.stream.engine import Shown
from footfix.stream.events import Event
from footfix.stream.interrupts import Interrupted
from footfix.stream.session import Live, StreamParams
from footfix.stream.sources import Came, Gone, Peer, Source

_OFTEN = 3  # faults of one kind that are reported in full
_RATE_SPAN = 2.0  # [s] over which the rate of incoming rows is measured
_PACED = 0.5  # least share of the time with an empty queue in a live stream
_POLL = 0.2  # [s] between checks for an interrupt while nothing comes in


def json_line(event: Event) -> bytes:
    """Write an event as a line of JSON."""
    entry = {
        "event": event.kind, "effector": event.effector, "frame": event.frame, "time": round(event.time, 4),
        "confidence": event.confidence,
    }  # fmt: skip
    return json.dumps(entry).encode() + b"\n"


@dataclass
class Talk:
    """Reports faults: the first ones of a kind in full, and the number of the others.

    Args:
        say: prints a line.
    """

    say: Callable[[str], None]
    counts: Counter[str] = field(default_factory=Counter)

    def fault(self, kind: str, text: str) -> None:
        """Report a fault, unless there were many of its kind."""
        self.counts[kind] += 1
        if self.counts[kind] <= _OFTEN:
            self.say(text)

    def total(self) -> None:
        """Report how many more there were of each kind."""
        for kind, count in self.counts.items():
            if count > _OFTEN:
                self.say(f"{count - _OFTEN} more of the kind: {kind}")


class Sink:
    """A file to which rows or events are written at once."""

    def __init__(self, stream: IO[bytes], *, drops: bool) -> None:
        """Prepare to write to it.

        Args:
            stream: open for writing.
            drops: whether frames are dropped where its reader is slow; else the stream waits for it.
        """
        self._number = stream.fileno()
        self.seekable = stat.S_ISREG(os.fstat(self._number).st_mode)
        self._start = os.lseek(self._number, 0, os.SEEK_CUR) if self.seekable else 0
        self._outlet = Outlet(self._all) if drops and not self.seekable else None

    def _all(self, data: bytes) -> None:
        left = memoryview(data)
        while left:
            left = left[os.write(self._number, left) :]

    def write(self, data: bytes) -> None:
        """Write now, or as soon as the reader takes it.

        Raises:
            BrokenPipeError: the reader has closed.
        """
        if self._outlet is None:
            self._all(data)
        elif self._outlet.gone:
            raise BrokenPipeError
        else:
            self._outlet.put(data)

    def correct(self, data: bytes, at: int) -> None:
        """Write over what stands `at` bytes after where it began."""
        if self.seekable:
            os.lseek(self._number, self._start + at, os.SEEK_SET)
            self._all(data)
            os.lseek(self._number, 0, os.SEEK_END)

    def close(self) -> int:
        """Write what waits; count the frames that were dropped."""
        if self._outlet is None:
            return 0
        self._outlet.close()
        return self._outlet.dropped


class Run:
    """One stream, whatever it comes from."""

    def __init__(
        self, settings: Settings, params: StreamParams, known: Document | None, rows: Sink | None, events: Sink | None,
        talk: Talk, peer: Peer | None = None, interrupted: Interrupted | None = None,
    ) -> None:  # fmt: skip
        """Keep the inputs and outputs; `run` starts.

        Args:
            settings: the parameters of all steps.
            params: how frames wait.
            known: another recording of the same figure.
            rows, events: where to write them; None for nowhere.
            talk: what to say.
            peer: a listener, to whom the rows go as well.
            interrupted: tells whether to end.
        """
        self._interrupted = interrupted or Interrupted()
        self._settings, self._params, self._known = settings, params, known
        self._rows, self._events, self._talk, self._peer = rows, events, talk, peer
        self._live: Live | None = None
        self._frame_time = 0.0
        self._header, self._padded, self._count_at = b"", b"", -1
        self._waiting: deque[Row] = deque()
        self.frames = 0  # that were written
        self._pace_from, self._pace_rows, self._idle = time.monotonic(), 0, 0.0
        if known is not None:
            self._frame_time = known.frame_time
        if peer is not None:
            peer.greeting = lambda: self._header

    def run(self, backlog: Backlog, sources: list[Source]) -> None:
        """Work until the input ends.

        Raises:
            InputError: it can't be used.
            KeyboardInterrupt: the stream was interrupted; all that came in until then was worked on.
        """
        gc.collect()
        gc.freeze()  # keep existing objects out of later collections; scanning them takes 20 ms
        try:
            while not self._interrupted.came:
                begun = time.monotonic()
                item = backlog.get(_POLL)
                self._idle += time.monotonic() - begun
                if isinstance(item, Gone) and item.last:
                    break
                if item is not None:
                    self._take(item)
        except BaseException:
            self._end(backlog, sources)
            raise
        if self._interrupted.came:
            with suppress(Exception):  # such as a reader that was interrupted, too
                self._end(backlog, sources)
            raise KeyboardInterrupt
        self._end(backlog, sources)
        if self._live is None:
            raise InputError("nothing came in", file="<stdin>")

    def _end(self, backlog: Backlog, sources: list[Source]) -> None:
        for source in sources:
            source.stop()
        self._finish(backlog)

    def _take(self, item: object) -> None:
        if isinstance(item, Row):
            self._row(item)
        elif isinstance(item, Header):
            self._begin(item)
        elif isinstance(item, Said):
            self._talk.fault(item.kind, item.text)
        elif isinstance(item, Came):
            self._talk.fault("peer", f"connected: {item.peer}")
        elif isinstance(item, Gone):
            self._talk.fault("peer", "the peer is gone; waiting for another")
            self._flush()
        elif isinstance(item, FootfixError):
            raise item

    def _begin(self, header: Header) -> None:
        """Start with a header, or continue with another frame rate."""
        document = header.document
        if self._live is not None:
            self._talk.fault("rate", f"after {self.frames} frames the header says {1.0 / document.frame_time:.4g} fps")
            self._give(self._live.restart(document.frame_time))
        else:
            self._live = Live(
                document, document.frame_time, self._settings, self._params, known=self._known, told=self._tell
            )
            self._write_header(header.text)
        self._frame_time = document.frame_time

    def _write_header(self, text: bytes) -> None:
        self._header = text
        if self._rows is not None:
            self._padded, self._count_at = with_room(text) if self._rows.seekable else (text, -1)
            self._rows.write(self._padded)
        if self._peer is not None and self._peer.outlet is not None:
            self._peer.outlet.put(text)

    def _tell(self, note: Note) -> None:
        if note.severity != "note":
            self._talk.fault(note.id, note.text)

    def _row(self, row: Row) -> None:
        if self._live is None:
            assert self._known is not None
            self._live = Live(
                self._known, self._known.frame_time, self._settings, self._params, known=self._known, told=self._tell
            )
            self._write_header(header_of(self._known))
        if row.broken:
            number = self.frames + len(self._waiting)
            self._talk.fault("no-number", f"frame {number} has a value that is no number; the last valid one is used")
        self._waiting.append(row)
        self._watch_pace()
        self._give(self._live.push(row.values[None]))

    def _watch_pace(self) -> None:
        """Report rows that come at another rate than the header says."""
        self._pace_rows += 1
        elapsed = time.monotonic() - self._pace_from
        if elapsed < _RATE_SPAN:
            return
        ratio = self._pace_rows / elapsed * self._frame_time
        if self._idle > _PACED * elapsed and not 0.75 < ratio < 1.33 and ratio > 0.1:
            came = f"{self._pace_rows / elapsed:.3g}"
            text = f"rows come at {came} a second, the header says {1.0 / self._frame_time:.4g}"
            self._talk.fault("pace", text)
        self._pace_from, self._pace_rows, self._idle = time.monotonic(), 0, 0.0

    def _give(self, shown: list[Shown]) -> None:
        """Write frames that are due."""
        lines, told, framed = [], [], []
        for each in shown:
            row = self._waiting.popleft()
            lines.append(row.written(each.row))
            if self._peer is not None:
                framed.append(row.written(each.row, bare=False))
            told += [json_line(event) for event in each.events]
        self.frames += len(shown)
        if lines and self._rows is not None:
            self._rows.write(b"".join(lines))
        if told and self._events is not None:
            self._events.write(b"".join(told))
        outlet = self._peer.outlet if self._peer is not None else None
        if framed and outlet is not None:
            outlet.put(b"".join(framed))

    def _flush(self) -> None:
        """Write the last frames of a peer; the next peer starts afresh."""
        if self._live is not None:
            self._give(self._live.restart(self._frame_time))

    def _finish(self, backlog: Backlog) -> None:
        backlog.close(now=True)
        if self._live is not None:
            self._give(self._live.close())
        if backlog.dropped:
            self._talk.say(f"{backlog.dropped} frames came faster than they could be worked on, and were dropped")
        if self._rows is not None and self._count_at >= 0:
            text = counted(self._padded, self._count_at, self.frames)
            if text is not None:
                self._rows.correct(text, self._count_at)
        for name, sink in (("frames", self._rows), ("events", self._events)):
            dropped = sink.close() if sink is not None else 0
            if dropped:
                self._talk.say(f"{dropped} {name} were dropped for a reader that is too slow")
        self._talk.total()
