"""Live figures: arrays in, arrays out after a fixed look-ahead."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from footfix.api.parameters import check_settings
from footfix.errors import ArgumentError
from footfix.formats.bvh.document import Document
from footfix.input_checks import check_frame_time
from footfix.motion.clip import Bools, Clip, Floats, Skeleton, frozen
from footfix.settings import Settings
from footfix.stream.engine import Shown
from footfix.stream.events import Event
from footfix.stream.session import Before, Live, StreamParams

__all__ = ["Event", "Frame", "Stream"]


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
        events: strikes and lifts that are reported with this frame.
    """

    number: int
    time: float
    values: Floats
    positions: Floats | None
    rotations: Floats | None
    contacts: Bools
    events: tuple[Event, ...]


class Stream:
    """A live figure in Python: arrays in, arrays out.

    Examples:
        >>> import footfix
        >>> walk = footfix.load("sample_data/walk_skate.bvh")
        >>> stream = footfix.Stream(walk, look_ahead=0.15)      # calibrated on the file's own frames
        >>> rows = walk.values[:40]                             # of the live figure, as they come
        >>> shown = [frame for row in rows for frame in stream.push(row)] + stream.close()
        >>> len(shown) == len(rows), shown[0].values.shape == rows[0].shape
        (True, True)

    Args:
        source: a file of the figure, or its skeleton. A file with a second of motion or more is calibrated on; with
            less, and with a skeleton, the first seconds of the stream are.
        look_ahead: for how long a frame waits for what follows it [s].
        frame_time: [s] between frames; that of the file where it is not given. Needed with a skeleton.
        settings: how the figure is found, and its contacts detected and enforced.
        calibrate_on: another clip of the same figure to calibrate on.
        calibration: first motion of the stream, on which legs and floor are measured where nothing else gives them [s].
        before: whether frames before that "pass" as they are, or "wait" to be corrected, too.

    Raises:
        ArgumentError: the source is neither of these, or the frame time is missing.
        NoLegsError: the figure has no legs.
        UsageError: settings or look-ahead ask for what only a whole clip can have.
    """

    def __init__(
        self, source: Document | Skeleton, look_ahead: float = StreamParams.look_ahead, *,
        frame_time: float | None = None, settings: Settings | None = None, calibrate_on: Clip | None = None,
        calibration: float = StreamParams.calibration, before: Before = StreamParams.before,
    ) -> None:  # fmt: skip
        if not isinstance(source, (Document, Skeleton)):
            raise ArgumentError(f"source must be a loaded BVH file or a skeleton, not {type(source).__name__}")
        given = source.frame_time if frame_time is None and isinstance(source, Document) else frame_time
        if given is None:
            raise ArgumentError("a stream of a skeleton needs frame_time, the seconds from frame to frame")
        check_frame_time(given)
        enough = isinstance(source, Document) and source.frames * source.frame_time >= 1.0
        known: Document | Clip | None = calibrate_on
        if known is None and enough and isinstance(source, Document):
            known = source
        params = StreamParams(look_ahead=look_ahead, calibration=calibration, before=before)
        self._source, self._frame_time = source, given
        self._live = Live(source, given, check_settings(settings), params, known=known)

    @property
    def delay(self) -> float:
        """Get the longest time that a frame waits [s]: the look-ahead and a thirtieth of a second."""
        return self._live.delay * self._frame_time

    @property
    def effectors(self) -> tuple[str, ...]:
        """List the names of the sole points whose contacts frames carry; none before calibration."""
        return self._live.effectors

    def push(self, frames: Clip | tuple[ArrayLike, ArrayLike] | ArrayLike) -> list[Frame]:
        """Take the next frames, and give out those that are due: as many as came in, after the first.

        Args:
            frames: of a stream of a file, its rows (n, C) or one row (C,); of a skeleton, a clip, or positions
                (n, J, 3) [m] and rotations (n, J, 4).

        Raises:
            ArgumentError: they are of another shape, or hold NaN or infinity.
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
