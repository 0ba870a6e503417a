"""The steps of a stream, hop by hop: detection as frames come in, enforcement a little later, frames out one by one.

The work that a hop of frames (1/30 s) makes comes in parts, each of about the same time:

    kinematics of the frames, resampled to detection's grid
    features of detection
    probabilities of contact
    contacts
    the problem of the window that ends with the hop
    a round of its solution
    final poses of the window's oldest frames
    their rows

The parts are spread over the frames that come meanwhile, a few with each, as far as the look-ahead allows: so no frame
takes the time of all parts. Finished frames are put out one by one, with a fixed delay.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from footfix.enforce.leg import ANKLE
from footfix.enforce.task import posed_joints
from footfix.motion.clip import Bools, Clip, Floats
from footfix.settings import Settings
from footfix.stream.belt import Belt
from footfix.stream.detection import Detector, FoundContacts
from footfix.stream.events import Event, Kind
from footfix.stream.history import History
from footfix.stream.kinematics import Posing
from footfix.stream.leg_rotations import Turner
from footfix.stream.legs import LegMeasurer, Legs
from footfix.stream.scheduling import SpreadWork
from footfix.stream.sliding_window import BEFORE, Settled, Window
from footfix.stream.subskeleton import Subskeleton

HOP = 1.0 / 30.0  # [s]
_LOOKS_BACK = 0.3  # [s] over which contacts are checked again for gaps to fill
_PARTS = 8  # parts of a hop's work
_SPREAD = 5  # most frames over which they are spread, besides the hop's last one
_SPARED = 5  # and at most one frame for this many frames of look-ahead
_WORK = 0.020  # [s] of a frame's delay that are reserved for computation, input and output
_NEAR = 0.1  # [s] greatest distance between a contact's first frame and the landing that belongs to it


def frames_of(seconds: float, frame_time: float) -> int:
    """Count the whole frames of a time [s]; files round the time of one, 0.016667 for a sixtieth of a second."""
    return int(seconds / frame_time + 1e-2)


def paced(look_ahead: float, frame_time: float) -> tuple[int, int]:
    """Count the frames of a hop, and for how many a frame waits: a little less than look-ahead and hop [s] together."""
    hop, ahead = max(1, frames_of(HOP, frame_time)), frames_of(look_ahead, frame_time)
    return hop, max(hop - 1, min(ahead + hop - 1, frames_of(look_ahead + HOP - _WORK, frame_time)))


@dataclass(frozen=True, eq=False)
class Shown:
    """A finished frame.

    Args:
        number: of the frame.
        row: (C,) as it came in, with corrected values.
        contacts: (E,) which effectors are planted.
        events: strikes and lifts in it.
    """

    number: int
    row: Floats
    contacts: Bools
    events: tuple[Event, ...]


class Codec(Protocol):
    """Converts rows of numbers to motion of the part's joints, and back."""

    def read(self, rows: Floats) -> Clip:
        """Convert rows (n, C) to the motion of the part's joints."""

    def write(self, rows: Floats, before: Clip, after: Clip) -> Floats:
        """Make the rows (n, C) with the motion `after` in place of `before`."""


class Engine:
    """Detection and enforcement of one figure, with a fixed delay."""

    def __init__(
        self, part: Subskeleton, codec: Codec, columns: int, frame_time: float, settings: Settings, look_ahead: float,
        shown: int = 0,
    ) -> None:  # fmt: skip
        """Start without frames.

        Args:
            part: the figure.
            codec: converts rows to its motion.
            columns: numbers in a row.
            frame_time: [s].
            settings: how contacts are found and enforced.
            look_ahead: [s] that a frame waits for what follows it.
            shown: how many of the first frames were given out already, as they are; pass them to `recall`.
        """
        self._part, self._codec, self._columns, self._frame_time = part, codec, columns, frame_time
        self._rig = part.known.rig
        self.hop, self.delay = paced(look_ahead, frame_time)
        ahead = self.delay - self.hop + 1
        spread = min(self.hop - 1, _SPREAD, ahead // _SPARED)  # frames that a hop's parts wait for at most
        self._work, self._ahead = SpreadWork(_PARTS, spread + 1), ahead - spread
        self._detector = Detector(
            [leg.side for leg in self._rig.legs], part.known.mates, part.known.jitter, self._rig.leg_length, frame_time,
            look_ahead, settings.detect.auto,
        )  # fmt: skip
        moves = bool(part.skeleton.translates[self._rig.root])
        self._belt = Belt(part.known.belt, frame_time, self._rig.leg_length, settings.enforce.ground)
        self._order = [2 * sole.leg + (sole.part == "toe") for sole in self._rig.soles]
        self._joints = posed_joints(part.skeleton, self._rig)
        self._posing, self._measure = Posing(part.skeleton, self._joints), LegMeasurer(part, self._joints)
        self._turner = Turner(part, self._joints, self._measure.kinds, frame_time, goes_on=shown > 0)
        self._window = Window(part.known, moves, self._turner, frame_time, settings.enforce, shown)
        kept = self.delay + 4 * self.hop + BEFORE + 4  # frames
        self._past = History(self._measure.kinds, self._joints, part.skeleton, frame_time, columns, kept)
        self._hop: list[Floats] = []
        self._arrived, self._settled = 0, shown
        self._told = np.zeros((BEFORE, 2 * len(self._rig.legs)), dtype=np.bool_)  # of the last frames that are settled
        self._ready: deque[Shown] = deque()

    def recall(self, rows: Floats) -> None:
        """Take rows (n, C) that were given out already."""
        if len(rows):
            self._arrived += len(rows)
            self._take(rows)
            self._detector.compute_evidence()
            self._detector.compute_probabilities()

    def push(self, rows: Floats) -> list[Shown]:
        """Take the next rows (n, C); give out those that are due."""
        out = []
        for row in rows:
            self._hop.append(row)
            self._arrived += 1
            if len(self._hop) == self.hop:
                self._work.begin(self._parts(self._taken()))
            self._work.advance()
            while self._ready and self._ready[0].number < self._arrived - self.delay:
                out.append(self._ready.popleft())
        return out

    def close(self) -> list[Shown]:
        """Give out all that is left; no frames follow."""
        self._work.finish()
        self._work.begin(self._parts(self._taken(), last=True))
        self._work.finish()
        left = list(self._ready)
        self._ready.clear()
        return left

    def _taken(self) -> Floats:
        """Take the rows (n, C) of the newest hop."""
        rows = np.stack(self._hop) if self._hop else np.zeros((0, self._columns))
        self._hop.clear()
        return rows

    def _parts(self, rows: Floats, *, last: bool = False) -> Iterator[None]:
        """Do the parts of the work for rows (n, C), yielding after each; with `last`, finish all frames."""
        if len(rows):
            self._take(rows)
            yield
            self._detector.compute_evidence()
            yield
            self._detector.compute_probabilities()
            yield
        stop = self._past.end - (0 if last else self._ahead)
        if stop <= self._settled:
            return
        seen = self._detector.find_contacts(max(self._settled - frames_of(_LOOKS_BACK, self._frame_time), 0))
        yield
        settled, first = self._settled, max(self._settled - BEFORE, 0)
        before, count = settled - first, stop - settled
        found = seen.down[settled - seen.first :]
        on = np.concatenate([self._told[BEFORE - before :], self._standing(found, count)])
        legs, lift = self._window.lifted(self._past.legs(first), first)
        done = yield from self._window.solve(legs, self._past.pose(settled, stop), on, first, last=last)
        shown = slice(before, before + count)
        self._learn(legs.frames(shown), found[:count])
        events = self._events(seen, done.on)
        self._told = np.concatenate([self._told, done.on])[-BEFORE:]
        self._settled = stop
        yield
        self._write(settled, done, lift[shown], events)

    def _learn(self, legs: Legs, down: Bools) -> None:
        """Update the belt by the frames finished now, with contacts (n, 2 legs) as detected."""
        self._belt.follow(legs.places()[:, :ANKLE], legs.hip.mean(axis=1), down, self._settled)
        self._window.belt = self._belt.velocity

    def _take(self, rows: Floats) -> None:
        """Compute the kinematics of the newest frames."""
        clip = self._codec.read(rows)
        pose = self._posing(clip)
        legs, tracks = self._measure(pose, self._frame_time)
        self._past.append(rows, clip, legs, pose)
        self._detector.add(tracks)

    def _write(self, first: int, done: Settled, lift: Floats, events: Sequence[Event]) -> None:
        """Make the rows of n finished frames, from number `first` on, raised by (n,) [m]."""
        stop = first + len(lift)
        rows, clip = self._past.rows.view(first, stop), self._past.clip(first, stop)
        shift = done.shift + lift[:, None] * np.array([0.0, 1.0, 0.0])
        changes = np.any(done.turned.changed) or np.any(shift)
        rows = (
            self._codec.write(rows, clip, self._turner.corrected(clip, done.turned, shift)) if changes else rows.copy()
        )
        for k, number in enumerate(range(first, stop)):
            own = tuple(event for event in events if self._due_with(event, number, first, stop))
            self._ready.append(Shown(number, rows[k], done.on[k, self._order], own))

    @staticmethod
    def _due_with(event: Event, number: int, first: int, stop: int) -> bool:
        return min(max(event.frame, first), stop - 1) == number

    def _standing(self, down: Bools, settled: int) -> Bools:
        """Remove the contacts (n, 2 legs) of released feet until these leave the floor or have caught up.

        Args:
            down: (n, 2 legs) contacts as detected.
            settled: of these frames, how many are to be settled now.
        """
        if not any(self._window.left):
            return down
        down = down.copy()
        for k, left in enumerate(self._window.left):
            own = down[:, 2 * k : 2 * k + 2]
            stays = int(np.argmin(np.append(own.any(axis=1), False)))
            if left:
                own[:stays] = False
            if stays < settled:
                self._window.left[k] = False
        return down

    def _events(self, seen: FoundContacts, on: Bools) -> list[Event]:
        """List the strikes and lifts in the frames finished now, by their contacts (n, 2 legs)."""
        down = np.concatenate([self._told[-1:], on])
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
        """Find the event time nearest to a frame [frames], if one is near."""
        near = min(moments, key=lambda moment: abs(moment - frame), default=np.inf)
        return near if abs(near - frame) * self._frame_time < min(_NEAR, 2.0 * self._frame_time) else float(frame)
