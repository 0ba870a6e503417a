"""A live session: frames in, frames out after a fixed delay, with planted feet held in place."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from footfix.errors import UsageError
from footfix.formats.bvh.channels import placed, position_base, to_clip
from footfix.formats.bvh.document import Document
from footfix.motion.clip import Clip, Floats, Skeleton, frozen
from footfix.notes import Note
from footfix.rig.units import infer_units
from footfix.settings import Settings
from footfix.stream.calibration import LEAST, calibrate
from footfix.stream.engine import Engine, Shown, paced
from footfix.stream.row_conversion import Arrays, Channels
from footfix.stream.subskeleton import Subskeleton, part_of

Before = Literal["pass", "wait"]
MOST = 5.0  # [s] longest look-ahead; for more, clean the whole file afterwards
_FEWEST = 12  # least number of frames to find a figure
_REMEMBERED = 2.0  # [s] of past frames that detection uses
_MEANWHILE = 0.5  # [s] allowed for calibration and for feeding past frames to the engine, while frames pass through
_RECALLED = 0.25  # [s] of past frames fed to the engine at a time


@dataclass(frozen=True, kw_only=True)
class StreamParams:
    """Delays of a stream.

    Args:
        look_ahead: how long a frame waits for the frames after it [s].
        calibration: duration of the first motion in which legs, floor and unit are found [s].
        before: whether frames before calibration "pass" uncorrected and at once, or "wait" and are corrected, too.
    """

    look_ahead: float = 0.15
    calibration: float = 2.0
    before: Before = "pass"


@dataclass(frozen=True, eq=False)
class _Figure:
    """A calibrated figure.

    Args:
        part: its legs.
        source: the header or joints of its rows, with the unit, axis and bones found for it.
        notes: from calibration.
    """

    part: Subskeleton
    source: Document | Skeleton
    notes: tuple[Note, ...] = ()


class Live:
    """A stream of rows of numbers, of a file's channels or of arrays."""

    def __init__(
        self, source: Document | Skeleton, frame_time: float, settings: Settings, params: StreamParams,
        *, known: Document | Clip | None = None, told: Callable[[Note], None] | None = None,
    ) -> None:  # fmt: skip
        """Start without rows.

        Args:
            source: the header of a file, or the joints that arrays are of.
            frame_time: [s].
            settings: how the figure is found, and its contacts detected and enforced.
            params: how frames wait.
            known: another recording of the same figure to calibrate on; by default the stream's first seconds.
            told: called with the notes of calibration.

        Raises:
            UsageError: a setting needs the whole clip.
        """
        enforce = settings.enforce
        if enforce.method == "root" or enforce.solver != "whole_clip":
            raise UsageError("a stream is corrected by enforce.method ik or both, with enforce.solver whole_clip")
        if settings.detect.method != "auto":
            raise UsageError("contacts of a stream are found by detect.method auto alone; the others need a whole clip")
        if not 0.0 <= params.look_ahead <= MOST:
            raise UsageError(f"look_ahead must be 0 to {MOST:g} seconds, not {params.look_ahead:g}")
        self._source, self._frame_time, self._settings, self._params = source, frame_time, settings, params
        self._told = told or (lambda note: None)
        self._columns = len(source.channels) if isinstance(source, Document) else 7 * len(source)
        self.effectors: tuple[str, ...] = ()
        self._engine: Engine | None = None
        self._next: Engine | None = None  # while it recalls what was given out already
        self._recalled = 0  # number of the row that it recalls next
        self._figure: _Figure | None = None
        self._coming: Future[_Figure] | None = None  # the figure, while it is calibrated
        self._held: list[Floats] = []  # rows before calibration; those that pass were given out already
        self._out = 0  # frames that were given out, in all
        self._base = self._offset = 0  # numbers of the first frame since the last start, and of the engine's
        self._paced()
        if known is not None:
            self._engine = self._made(self._measured(known))

    def _paced(self) -> None:
        """Convert delays to frames at the present rate."""
        _, self.delay = paced(self._params.look_ahead, self._frame_time)
        self._wanted = max(_FEWEST, round(self._params.calibration / self._frame_time))
        self._last = self._wanted + (round(_MEANWHILE / self._frame_time) if self._passes else 0)

    @property
    def _passes(self) -> bool:
        """Tell whether frames before calibration pass."""
        return self._params.before == "pass"

    def push(self, rows: Floats) -> list[Shown]:
        """Take the next rows (n, C); give out those that are due."""
        out = self._pushed(rows)
        self._out += len(out)
        return out

    def close(self) -> list[Shown]:
        """Give out all that is left; no frames follow."""
        out = self._closed()
        self._out += len(out)
        return out

    def _pushed(self, rows: Floats) -> list[Shown]:
        if self._engine is not None:
            return self._counted(self._engine.push(rows))
        out: list[Shown] = []
        for k, row in enumerate(rows):
            self._held.append(np.array(row))
            if self._passes:
                out.append(self._as_it_is(len(self._held) - 1))
                if len(self._held) == self._wanted:
                    self._coming = _meanwhile(self._found, np.stack(self._held))
                elif self._coming is not None and self._coming.done():
                    self._prepare(self._last)
            if len(self._held) >= self._last:
                return out + self._calibrated() + self._pushed(rows[k + 1 :])
        return out

    def _closed(self) -> list[Shown]:
        out: list[Shown] = []
        if self._engine is None and self._next is None and len(self._held) >= max(_FEWEST, LEAST / self._frame_time):
            out = self._calibrated()
        if self._engine is not None:
            return out + self._counted(self._engine.close())
        return [] if self._passes else [self._as_it_is(number) for number in range(len(self._held))]

    def restart(self, frame_time: float) -> list[Shown]:
        """Give out all that is left, and restart with another take, or another frame rate.

        Args:
            frame_time: [s] from now on.
        """
        out = self.close()
        self._base, self._frame_time, self._coming, self._next = self._out, frame_time, None, None
        self._held.clear()
        self._paced()
        if self._figure is not None:
            self._engine = self._made(self._figure)
        return out

    def _as_it_is(self, number: int) -> Shown:
        return Shown(self._base + number, self._held[number], np.zeros(len(self.effectors), dtype=np.bool_), ())

    def _calibrated(self) -> list[Shown]:
        """Start the engine on the held rows, calibrated on them."""
        given = len(self._held) if self._passes else 0
        while self._next is None or self._recalled < given:
            self._prepare(given)
        self._engine, self._next, self._coming = self._next, None, None
        rows = self._held[given:]
        self._held.clear()
        return self._counted(self._engine.push(np.stack(rows))) if rows else []

    def _prepare(self, given: int) -> None:
        """Make the engine that goes on after `given` rows, or let it recall some of those that are there.

        These are always the same at a time, so that nothing depends on how long calibration takes.
        """
        if self._next is None:
            figure = self._found(np.stack(self._held)) if self._coming is None else self._coming.result()
            self._recalled = max(given - round(_REMEMBERED / self._frame_time), 0)
            self._next = self._made(figure, since=self._recalled, given=given)
            return
        stop = min(self._recalled + max(round(_RECALLED / self._frame_time), 1), given)
        if stop <= len(self._held):
            self._next.recall(np.stack(self._held[self._recalled : stop]))
            self._recalled = stop

    def _found(self, rows: Floats) -> _Figure:
        """Calibrate on the first rows."""
        source = self._source
        if isinstance(source, Skeleton):
            joints, n = len(source), len(rows)
            places, turns = rows[:, : 3 * joints], rows[:, 3 * joints :]
            return self._of(
                Clip(source, places.reshape(n, joints, 3), turns.reshape(n, joints, 4), self._frame_time), source
            )
        base = position_base(source.skeleton, source.channels, lambda column: rows[:, column], len(rows))
        in_file = to_clip(source.skeleton, source.channels, rows, base, self._frame_time)
        found = infer_units(in_file, self._settings.rig)
        document = replace(source, base=frozen(base)).placed(unit_m=found.unit_m, up=found.up)
        return self._of(placed(in_file, document.unit_m, document.up), document, found.notes)

    def _measured(self, known: Document | Clip) -> _Figure:
        """Calibrate on another recording of the figure, and take unit, axis and bones as there."""
        if isinstance(known, Clip):
            return self._of(known, self._source)
        if not isinstance(self._source, Document):
            return self._of(known.clip, self._source)
        found = infer_units(known.clip, self._settings.rig) if known.unit_m == 1.0 and known.up == "y" else known
        document = known.placed(unit_m=found.unit_m, up=found.up)
        source = replace(self._source, base=document.base).placed(unit_m=found.unit_m, up=found.up)
        return self._of(document.clip, source)

    def _of(self, clip: Clip, source: Document | Skeleton, notes: Sequence[Note] = ()) -> _Figure:
        """Calibrate on a clip of the figure, with notes that are made of it already."""
        found = calibrate(clip, self._settings)
        return _Figure(part_of(clip.skeleton, found), source, (*notes, *found.notes))

    def _made(self, figure: _Figure, *, since: int = 0, given: int = 0) -> Engine:
        """Make an engine that begins with frame `since` of those that are held; some are given out as they are."""
        if figure is not self._figure:
            for note in figure.notes:
                self._told(note)
        self._figure, part = figure, figure.part
        self.effectors = tuple(sole.name for sole in part.known.rig.soles)
        codec: Channels | Arrays
        if isinstance(figure.source, Document):
            codec = Channels(figure.source, part, self._frame_time)
        else:
            codec = Arrays(figure.source, part, self._frame_time)
        self._offset = self._base + since
        return Engine(
            part, codec, self._columns, self._frame_time, self._settings, self._params.look_ahead, given - since
        )

    def _counted(self, shown: Sequence[Shown]) -> list[Shown]:
        """Number the engine's frames from the start of the stream."""
        if not self._offset:
            return list(shown)
        return [
            replace(
                each, number=each.number + self._offset,
                events=tuple(event.moved(self._offset, self._frame_time) for event in each.events),
            )
            for each in shown
        ]  # fmt: skip


def _meanwhile(find: Callable[[Floats], _Figure], rows: Floats) -> Future[_Figure]:
    """Calibrate on rows while more of them come in."""
    worker = ThreadPoolExecutor(1)
    coming = worker.submit(find, rows)
    worker.shutdown(wait=False)
    return coming
