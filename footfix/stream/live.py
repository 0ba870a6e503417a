"""A live figure: frames in, frames out after a fixed look-ahead, its feet held where they are planted."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from footfix.errors import ArgumentError, UsageError
from footfix.formats.bvh.channels import position_base, to_clip
from footfix.formats.bvh.document import Document
from footfix.motion.clip import Bools, Clip, Floats, Skeleton, frozen
from footfix.notes import Note
from footfix.rig.units import infer_units
from footfix.settings import Settings
from footfix.stream.calibration import LEAST, Calibration, calibrate
from footfix.stream.codec import Arrays, Channels
from footfix.stream.engine import HOP, Engine, Shown, frames_of
from footfix.stream.events import Event
from footfix.stream.part import part_of

Before = Literal["pass", "wait"]
MOST = 5.0  # [s] of look-ahead; for more, wait for the end and clean the whole
_FEWEST = 12  # frames of which a figure can be told
_REMEMBERED = 2.0  # [s] that detection looks back


@dataclass(frozen=True, eq=False)
class Frame:
    """A frame as it comes out of a stream.

    Args:
        number: since the stream began, from 0.
        time: [s] since then.
        values: (C,) the numbers of its row in a file, (7 J,) where the stream is one of arrays.
        positions: (J, 3) [m] places of the joints in their parents' frames; None in a stream of rows.
        rotations: (J, 4) xyzw; likewise.
        contacts: (E,) which effectors are planted.
        events: strikes and lifts that are told with this frame.
    """

    number: int
    time: float
    values: Floats
    positions: Floats | None
    rotations: Floats | None
    contacts: Bools
    events: tuple[Event, ...]


@dataclass(frozen=True, kw_only=True)
class StreamParams:
    """How a stream waits.

    Args:
        look_ahead: for how long a frame waits for what follows it [s].
        calibration: of the figure's first motion by which legs, floor and unit are told [s].
        before: frames before that "pass" as they are, or "wait" and are corrected, too.
    """

    look_ahead: float = 0.15
    calibration: float = 2.0
    before: Before = "pass"


class Live:
    """A stream of rows of numbers, of a file's channels or of arrays."""

    def __init__(
        self, source: Document | Skeleton, frame_time: float, settings: Settings, params: StreamParams,
        *, known: Document | Clip | None = None, told: Callable[[Note], None] | None = None,
    ) -> None:  # fmt: skip
        """Begin.

        Args:
            source: the header of a file, or the joints that arrays are of.
            frame_time: [s].
            settings: how the figure is found, and its contacts detected and enforced.
            params: how frames wait.
            known: a motion of the same figure to calibrate on; else the first seconds of the stream are.
            told: is called with what calibration has to tell.

        Raises:
            UsageError: the settings ask for what only a whole clip can have.
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
        ahead, hop = frames_of(params.look_ahead, frame_time), max(1, frames_of(HOP, frame_time))
        self.delay = ahead + hop - 1  # [frames]
        self.effectors: tuple[str, ...] = ()
        self._engine: Engine | None = None
        self._offset = 0  # number of the engine's first frame
        self._held: list[Floats] = []  # rows before calibration, those that were given out among them
        self._given = 0  # of these
        self._wanted = max(_FEWEST, round(params.calibration / frame_time))
        if known is not None:
            self._begin(*self._measured(known))

    @property
    def calibrated(self) -> bool:
        """Whether the figure is known."""
        return self._engine is not None

    def push(self, rows: Floats) -> list[Shown]:
        """Take the next rows (n, C); give out those that are due."""
        if self._engine is not None:
            return self._counted(self._engine.push(rows))
        out: list[Shown] = []
        for k, row in enumerate(rows):
            self._held.append(np.array(row))
            if len(self._held) >= self._wanted:
                return out + self._calibrated() + self.push(rows[k + 1 :])
            if self._params.before == "pass" and len(self._held) - self._given > self.delay:
                out.append(self._as_it_is(self._given))
                self._given += 1
        return out

    def close(self) -> list[Shown]:
        """Give out all that is left; no frames follow."""
        out: list[Shown] = []
        if self._engine is None and len(self._held) >= max(_FEWEST, LEAST / self._frame_time):
            out += self._calibrated()
        if self._engine is not None:
            return out + self._counted(self._engine.close())
        out += [self._as_it_is(number) for number in range(self._given, len(self._held))]
        self._given = len(self._held)
        return out

    def _as_it_is(self, number: int) -> Shown:
        return Shown(number, self._held[number], np.zeros(len(self.effectors), dtype=np.bool_), ())

    def _calibrated(self) -> list[Shown]:
        """Calibrate on the rows that are held, and let the engine go on from there."""
        rows = np.stack(self._held)
        clip, source = self._clip(rows)
        since = max(self._given - round(_REMEMBERED / self._frame_time), 0)
        self._begin(clip, source, since)
        self._held.clear()
        assert self._engine is not None
        return self._counted(self._engine.push(rows[since:]))

    def _clip(self, rows: Floats) -> tuple[Clip, Document | Skeleton]:
        """The motion of rows [m], y up, and the source with the unit, axis and bones it is found to have."""
        source = self._source
        if isinstance(source, Skeleton):
            joints = len(source)
            places, turns = rows[:, : 3 * joints], rows[:, 3 * joints :]
            n = len(rows)
            return Clip(source, places.reshape(n, joints, 3), turns.reshape(n, joints, 4), self._frame_time), source
        base = position_base(source.skeleton, source.channels, lambda column: rows[:, column], len(rows))
        in_file = to_clip(source.skeleton, source.channels, rows, base, self._frame_time)
        found = infer_units(in_file, self._settings.rig)
        for note in found.notes:
            self._told(note)
        document = replace(source, base=frozen(base)).placed(unit_m=found.unit_m, up=found.up)
        from footfix.formats.bvh.channels import placed

        return placed(in_file, document.unit_m, document.up), document

    def _measured(self, known: Document | Clip) -> tuple[Clip, Document | Skeleton]:
        """The motion of another recording of the figure, and the source with unit, axis and bones as there."""
        if isinstance(known, Clip):
            return known, self._source
        if not isinstance(self._source, Document):
            return known.clip, self._source
        found = infer_units(known.clip, self._settings.rig) if known.unit_m == 1.0 and known.up == "y" else known
        document = known.placed(unit_m=found.unit_m, up=found.up)
        return document.clip, replace(self._source, base=document.base).placed(unit_m=found.unit_m, up=found.up)

    def _begin(self, clip: Clip, source: Document | Skeleton, since: int = 0) -> None:
        """Begin with the frames from `since` on, of a figure that moves as in a clip."""
        found = calibrate(clip, self._settings)
        for note in found.notes:
            self._told(note)
        part = part_of(clip.skeleton, found)
        codec: Channels | Arrays
        if isinstance(source, Document):
            codec = Channels(source, part, self._frame_time)
        else:
            codec = Arrays(source, part, self._frame_time)
        self.known: Calibration = found
        self.effectors = tuple(sole.name for sole in found.rig.soles)
        self._engine = Engine(
            part, codec, self._columns, self._frame_time, self._settings, self._params.look_ahead, self._given - since
        )
        self._offset = since

    def _counted(self, shown: Sequence[Shown]) -> list[Shown]:
        """Frames of the engine, counted since the stream began."""
        if not self._offset:
            return list(shown)
        return [
            replace(
                each, number=each.number + self._offset,
                events=tuple(event.moved(self._offset, self._frame_time) for event in each.events),
            )
            for each in shown
        ]  # fmt: skip


class Stream:
    """A live figure in Python: arrays in, arrays out.

    Examples:
        >>> import footfix
        >>> walk = footfix.load("sample_data/walk_skate.bvh")
        >>> stream = footfix.Stream(walk, look_ahead=0.15)      # calibrated on the file's own frames
        >>> shown = [frame for row in walk.values for frame in stream.push(row)] + stream.close()
        >>> len(shown) == walk.frames, shown[0].values.shape == walk.values[0].shape
        (True, True)

    Args:
        source: a file of the figure, or its skeleton. A file with a second of motion or more is calibrated on; with
            less, and with a skeleton, the first seconds of the stream are.
        look_ahead: for how long a frame waits for what follows it [s].
        frame_time: [s] between frames; that of the file where it is not given. Needed with a skeleton.
        settings: how the figure is found, and its contacts detected and enforced.
        calibrate_on: another clip of the same figure to calibrate on.
        calibration: of first motion by which legs and floor are told where nothing else does [s].
        before: whether frames before that "pass" as they are, or "wait" to be corrected, too.

    Raises:
        ArgumentError: the source is none, or the frame time is missing.
        NoLegsError: the figure has no legs.
        UsageError: settings or look-ahead ask for what only a whole clip can have.
    """

    def __init__(
        self, source: Document | Skeleton, look_ahead: float = StreamParams.look_ahead, *,
        frame_time: float | None = None, settings: Settings | None = None, calibrate_on: Clip | None = None,
        calibration: float = StreamParams.calibration, before: Before = StreamParams.before,
    ) -> None:  # fmt: skip
        if not isinstance(source, (Document, Skeleton)):
            raise ArgumentError(f"a stream is of a loaded BVH file or a skeleton, not {type(source).__name__}")
        given = source.frame_time if frame_time is None and isinstance(source, Document) else frame_time
        if given is None or not given > 0.0:
            raise ArgumentError("a stream of a skeleton needs frame_time, the seconds from frame to frame")
        enough = isinstance(source, Document) and source.frames * source.frame_time >= 1.0
        known: Document | Clip | None = calibrate_on
        if known is None and enough and isinstance(source, Document):
            known = source
        params = StreamParams(look_ahead=look_ahead, calibration=calibration, before=before)
        self._source, self._frame_time = source, given
        self._live = Live(source, given, settings or Settings(), params, known=known)

    @property
    def delay(self) -> float:
        """[s] that a frame waits at most: look-ahead and a thirtieth of a second."""
        return self._live.delay * self._frame_time

    @property
    def effectors(self) -> tuple[str, ...]:
        """Names of the sole points whose contacts frames tell; none before calibration."""
        return self._live.effectors

    def push(self, frames: Clip | tuple[ArrayLike, ArrayLike] | ArrayLike) -> list[Frame]:
        """Take the next frames, and give out those that are due: as many as came in, after the first.

        Args:
            frames: of a stream of a file, its rows (n, C) or one row (C,); of a skeleton, a clip, or positions
                (n, J, 3) [m] and rotations (n, J, 4).

        Raises:
            ArgumentError: they are of another shape, or hold numbers that are none.
        """
        return [self._frame(each) for each in self._live.push(self._rows(frames))]

    def close(self) -> list[Frame]:
        """Give out all that is left; no frames follow."""
        return [self._frame(each) for each in self._live.close()]

    def _rows(self, frames: Clip | tuple[ArrayLike, ArrayLike] | ArrayLike) -> Floats:
        if isinstance(self._source, Document):
            rows = np.atleast_2d(np.asarray(frames, dtype=np.float64))
            columns = len(self._source.channels)
            if rows.ndim != 2 or rows.shape[1] != columns:
                raise ArgumentError(f"rows must be (n, {columns}), one number a channel, not {rows.shape}")
        else:
            both = (frames.positions, frames.rotations) if isinstance(frames, Clip) else frames
            if not isinstance(both, tuple) or len(both) != 2:
                raise ArgumentError("frames of a skeleton are a clip, or positions (n, J, 3) and rotations (n, J, 4)")
            joints = len(self._source)
            places, turns = (np.asarray(each, dtype=np.float64) for each in both)
            places, turns = places.reshape(-1, *places.shape[-2:]), turns.reshape(-1, *turns.shape[-2:])
            if places.shape[1:] != (joints, 3) or turns.shape != (len(places), joints, 4):
                shapes = f"{places.shape} and {turns.shape}"
                raise ArgumentError(f"positions must be (n, {joints}, 3) and rotations (n, {joints}, 4), not {shapes}")
            rows = np.concatenate([places.reshape(len(places), -1), turns.reshape(len(turns), -1)], axis=1)
        if not np.isfinite(rows).all():
            raise ArgumentError("a frame holds NaN or an infinite number; give the last one again in its place")
        return rows

    def _frame(self, shown: Shown) -> Frame:
        positions = rotations = None
        if isinstance(self._source, Skeleton):
            joints = len(self._source)
            positions = frozen(shown.row[: 3 * joints].reshape(joints, 3))
            rotations = frozen(shown.row[3 * joints :].reshape(joints, 4))
        return Frame(
            shown.number, shown.number * self._frame_time, frozen(shown.row), positions, rotations,
            shown.contacts, shown.events,
        )  # fmt: skip
