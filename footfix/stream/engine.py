"""The steps of a stream, hop by hop: detection as frames come in, enforcement a little later, frames out one by one.

    hop                     1/30 s of frames: kinematics of them, and what they show of contacts
    a frame later           contacts, and the window that ends with the hop is solved; its oldest frames are settled
    another frame later     their rows are written, where the rate is high and the look-ahead long
                            (where it is higher still, contacts are found a frame before the window is solved)
    with every frame        one that is settled is given out, as late as agreed on

So no frame takes the time of all steps, and each waits as long as the others.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from footfix.detect.tracks import tracks_of
from footfix.enforce.correction import Correction, apply
from footfix.enforce.leg import LEG, ROOT, LegTracks, tracks
from footfix.enforce.task import pose_of
from footfix.enforce.whole_clip import correction
from footfix.motion.clip import Bools, Clip, Floats
from footfix.settings import Settings
from footfix.stream.detection import Detector, Seen
from footfix.stream.events import Event, Kind
from footfix.stream.part import Part
from footfix.stream.ring import Ring
from footfix.stream.tracks import LegRing
from footfix.stream.window import BEFORE, Window

HOP = 1.0 / 30.0  # [s]
_LOOKS_BACK = 0.3  # [s] over which contacts are looked at again, for gaps that are none
_LONG = 0.12  # [s] of look-ahead of which a frame more can be spared
_NEAR = 0.1  # [s] a landing this near to the first frame of a contact is when it began


@dataclass(frozen=True, eq=False)
class Shown:
    """A frame that is settled.

    Args:
        number: of the frame.
        row: (C,) as it came in, with what is corrected.
        contacts: (E,) which effectors are planted.
        events: what begins or ends with it.
    """

    number: int
    row: Floats
    contacts: Bools
    events: tuple[Event, ...]


def frames_of(seconds: float, frame_time: float) -> int:
    """Count the whole frames of a time [s]."""
    return int(seconds / frame_time + 1e-6)


@dataclass(frozen=True, eq=False)
class _Settled:
    """Frames of a window that are settled, from number `first` on, and what was found of them."""

    first: int
    legs: Sequence[LegTracks]
    x: Floats
    lift: Floats
    shown: slice
    on: Bools
    events: Sequence[Event]


class Codec(Protocol):
    """What rows of numbers say of the part's joints."""

    def read(self, rows: Floats) -> Clip:
        """The motion of the part's joints of rows (n, C)."""

    def write(self, rows: Floats, before: Clip, after: Clip) -> Floats:
        """(n, C) the rows with the motion `after` in place of `before`."""


class Engine:
    """Detection and enforcement of one figure, with a fixed delay."""

    def __init__(
        self, part: Part, codec: Codec, columns: int, frame_time: float, settings: Settings, look_ahead: float,
        shown: int = 0,
    ) -> None:  # fmt: skip
        """Begin.

        Args:
            part: the figure.
            codec: what rows say of it.
            columns: numbers in a row.
            frame_time: [s].
            settings: how contacts are found and enforced.
            look_ahead: [s] that a frame waits for what follows it.
            shown: how many of the first frames are given out by others, as they are.
        """
        self._part, self._codec, self._frame_time = part, codec, frame_time
        self._rig = part.known.rig
        self.hop = max(1, frames_of(HOP, frame_time))
        ahead = frames_of(look_ahead, frame_time)
        self.delay = ahead + self.hop - 1
        self._late = self.hop >= 3 and look_ahead >= _LONG
        self._parted = self._late and self.hop >= 4
        self._ahead = max(ahead - (0 if self.hop == 1 else 1 + self._late + self._parted), 0)
        self._seen: Seen | None = None  # to be solved for
        self._pending: _Settled | None = None  # to be written
        self._detector = Detector(
            [leg.side for leg in self._rig.legs], part.known.mates, part.known.jitter, self._rig.leg_length, frame_time,
            look_ahead, settings.detect.auto,
        )  # fmt: skip
        moves = bool(part.skeleton.translates[self._rig.root])
        self._window = Window(part.known, moves, frame_time, settings.enforce, shown)
        self._order = [2 * sole.leg + (sole.part == "toe") for sole in self._rig.soles]
        self._capacity = self.delay + 4 * self.hop + BEFORE + 4
        self._rows = Ring((columns,), self._capacity)
        self._legs: LegRing | None = None
        self._hop: list[Floats] = []
        self._arrived, self._settled, self._due = 0, shown, False
        self._told = np.zeros((BEFORE, 2 * len(self._rig.legs)), dtype=np.bool_)  # of the last frames that are settled
        self._ready: deque[Shown] = deque()

    def push(self, rows: Floats) -> list[Shown]:
        """Take the next rows (n, C); give out those that are due."""
        out = []
        for row in rows:
            self._hop.append(row)
            self._arrived += 1
            if self._pending is not None:
                self._write(self._pending)
            elif self._due and self._parted and self._seen is None:
                self._seen = self._see(self._rows.end - self._ahead)
            elif self._due:
                self._settle(self._rows.end - self._ahead)
            if len(self._hop) == self.hop:
                self._take_hop()
                self._due = True
                if self.hop == 1:
                    self._settle(self._rows.end - self._ahead)
            while self._ready and self._ready[0].number < self._arrived - self.delay:
                out.append(self._ready.popleft())
        return out

    def close(self) -> list[Shown]:
        """Give out all that is left; no frames follow."""
        if self._pending is not None:
            self._write(self._pending)
        self._seen = None
        if self._hop:
            self._take_hop()
        if self._arrived > self._settled:
            self._settle(self._arrived, last=True)
        left = list(self._ready)
        self._ready.clear()
        return left

    def _take_hop(self) -> None:
        """Kinematics of the newest frames, and what they show."""
        rows = np.stack(self._hop)
        self._hop.clear()
        self._rows.append(rows)
        clip = self._codec.read(rows)
        pose = pose_of(clip, self._rig)
        legs = tracks(clip, self._rig, pose, self._part.known.legs)
        if self._legs is None:
            self._legs = LegRing(legs, pose, self._capacity)
        self._legs.append(legs, pose)
        self._detector.add(tracks_of(clip, self._rig, pose))

    def _see(self, stop: int) -> Seen | None:
        """What is planted in the newest frames; None where none up to number `stop` is to be settled."""
        if stop <= self._settled:
            return None
        return self._detector.see(max(self._settled - frames_of(_LOOKS_BACK, self._frame_time), 0))

    def _settle(self, stop: int, *, last: bool = False) -> None:
        """Settle the frames up to number `stop`."""
        seen = self._see(stop) if self._seen is None else self._seen
        self._due, self._seen = False, None
        assert self._legs is not None
        if seen is None:
            return
        first = max(self._settled - BEFORE, 0)
        before = self._settled - first
        down = seen.down[self._settled - seen.first :]
        told = self._told[BEFORE - before :]
        on = np.concatenate([told, down])
        legs, lift = self._window.lifted(self._legs.legs(first), first)
        x = self._window.solve(legs, on, first, stop, last=last)
        shown = slice(before, stop - first)
        events = self._events(seen, stop)
        found = _Settled(self._settled, legs, x, lift, shown, on, events)
        self._told = np.concatenate([self._told, down[: stop - self._settled]])[-BEFORE:]
        self._settled = stop
        if self._late and not last:
            self._pending = found
        else:
            self._write(found)

    def _write(self, found: _Settled) -> None:
        """Make ready the rows of frames that are settled."""
        self._pending = None
        assert self._legs is not None
        shown, first = found.shown, found.first
        stop = first + shown.stop - shown.start
        rows = self._rows.view(first, stop)
        some = [leg.frames(shown) for leg in found.legs]
        state = np.ascontiguousarray(found.x[:, shown])
        columns = [slice(ROOT + LEG * k, ROOT + LEG * (k + 1)) for k in range(len(some))]
        shift = state[:ROOT].T + found.lift[shown, None] * np.array([0.0, 1.0, 0.0])
        clip = self._codec.read(rows)
        done = correction(clip, self._rig, self._legs.pose(first, stop), some, state, columns, shift)
        done = Correction(done.root, done.root_shift, done.joints, done.rotations, self._part.known.followers)
        rows = self._codec.write(rows, clip, apply(clip, done)) if done.joints or np.any(shift) else rows.copy()
        for k, number in enumerate(range(first, stop)):
            own = tuple(event for event in found.events if self._due_with(event, number, first, stop))
            self._ready.append(Shown(number, rows[k], found.on[shown][k, self._order], own))

    @staticmethod
    def _due_with(event: Event, number: int, first: int, stop: int) -> bool:
        return min(max(event.frame, first), stop - 1) == number

    def _events(self, seen: Seen, stop: int) -> list[Event]:
        """What begins or ends in the frames that are settled now, up to `stop`."""
        begin = self._settled - seen.first
        down = np.concatenate([self._told[-1:], seen.down[begin : begin + stop - self._settled]])
        found = []
        for sole, column in zip(self._rig.soles, self._order, strict=True):
            for k in np.flatnonzero(down[1:, column] != down[:-1, column]).tolist():
                kind: Kind = "strike" if down[k + 1, column] else "lift"
                frame = self._settled + k
                moments = (seen.lands if kind == "strike" else seen.leaves)[sole.leg]
                contact = seen.sure[:, column][seen.down[:, column]]
                sure = float(contact.mean()) if len(contact) else 0.5
                at = self._moment(moments, frame)
                found.append(Event(kind, sole.name, frame, at * self._frame_time, round(sure, 3)))
        return sorted(found, key=lambda event: event.frame)

    def _moment(self, moments: tuple[float, ...], frame: int) -> float:
        """[frames] when it happened: the moment that is nearest to the frame, if one is near."""
        near = min(moments, key=lambda moment: abs(moment - frame), default=np.inf)
        return near if abs(near - frame) * self._frame_time < min(_NEAR, 2.0 * self._frame_time) else float(frame)
