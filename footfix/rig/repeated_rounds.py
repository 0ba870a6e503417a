"""Rounds of a cycle end to end, so that frames before and after the clip are known; and the way back to the clip."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

import numpy as np

from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats, Ints
from footfix.motion.contacts import Contact, Contacts, Effector
from footfix.motion.kinematics import Pose, forward
from footfix.notes import Note
from footfix.rig.cyclic_clip import Cycle, find_cycle, may_be_cycle, said_to_be_one
from footfix.rig.rig import Rig

_BESIDE = 2.0  # [s] before and after the clip: long enough for effects of the ends on a correction to fade
_IN_PLACE = 1.0  # of the root's usual step: a round whose open end goes no farther than this stays in place
_FEWEST = 4  # least number of frames of a round where the user says that the clip is a cycle


@dataclass(frozen=True, eq=False)
class Rounds:
    """A clip that is a cycle, with further rounds before and after it.

    Each round starts where the one before it ended. Where the clip's last frame repeats its first, it is used as the
    first of the next round, so that the clip is contained in the rounds exactly.

    Args:
        whole: the clip, F frames.
        cycle: its round.
        root: the joint that carries the travel.
        pose: of the clip, with the root.
    """

    whole: Clip
    cycle: Cycle
    root: int
    pose: Pose

    @property
    def within(self) -> slice:
        """Get the clip's frames among those of all rounds."""
        beside = self.cycle.frames + round(_BESIDE / self.whole.frame_time)
        return slice(beside, beside + len(self.whole))

    @cached_property
    def _at(self) -> Ints:
        """Number the frames of the rounds from the clip's first, (N,)."""
        beside = self.within.start
        return np.arange(-beside, len(self.whole) + beside)

    @cached_property
    def _turns(self) -> Ints:
        """Compute by how many rounds each frame is after its place in the clip, (N,)."""
        return np.asarray(self._at // self.cycle.frames - self._repeated)

    @property
    def _repeated(self) -> Ints:
        """Mark with 1 (N,) first frames of a round that are the last of the round before."""
        closed = len(self.whole) > self.cycle.frames
        return np.asarray(((self._at % self.cycle.frames == 0) & (self._at > 0) & closed).astype(np.intp))

    @cached_property
    def clip(self) -> Clip:
        """Make a clip of N frames of all rounds."""
        n = self.cycle.frames
        laid = self.whole.frames(self._at % n + n * self._repeated)
        top = self.root
        while self.whole.skeleton.parents[top] >= 0:
            top = int(self.whole.skeleton.parents[top])
        place, turn = np.array(laid.position(top)), np.array(laid.rotation(top))
        for k in np.unique(self._turns[self._turns != 0]).tolist():
            there = self._turns == k
            about, way = self._lead(k)
            place[there] = rotation.rotate(about, place[there]) + way
            turn[there] = rotation.multiply(about, turn[there])
        return laid.with_joints({top: place}, {top: turn})

    def _lead(self, rounds: int) -> tuple[Floats, Floats]:
        """Compute the travel of some rounds: a turn (4,) about the vertical, then a horizontal shift (3,) [m]."""
        place, n = self.pose.position(self.root), self.cycle.frames
        turn = rotation.about_vertical(self.cycle.yaw)
        after = place[n] if len(place) > n else place[-1] + self._over(turn)
        one = (after - rotation.rotate(turn, place[0])) * [1.0, 0.0, 1.0]
        if len(place) == n and np.linalg.norm(one) < _IN_PLACE * np.linalg.norm(np.diff(place, axis=0), axis=1).mean():
            one[:] = 0.0
        way = np.zeros(3)
        for _ in range(abs(rounds)):
            way = rotation.rotate(turn, way) + one if rounds > 0 else rotation.rotate(rotation.inverse(turn), way - one)
        return rotation.about_vertical(rounds * self.cycle.yaw), way

    def _over(self, turn: Floats) -> Floats:
        """Compute the root's step (3,) [m] across the seam, by the cubic through two steps on either side."""
        place = self.pose.position(self.root)
        first, later = rotation.rotate(turn, np.diff(place[:3], axis=0))
        earlier, last = np.diff(place[-3:], axis=0)
        return np.asarray(0.5 * (first + last) + (first - later + last - earlier) / 6.0)

    def contacts(self, own: Contacts) -> Contacts:
        """Repeat the contacts of the clip in all rounds; a contact across the seam becomes one.

        Args:
            own: of the clip, F frames.
        """
        effectors = tuple(self._laid(effector) for effector in own.effectors)
        return replace(own, frames=len(self._at), effectors=effectors)

    def _laid(self, effector: Effector) -> Effector:
        n, beside, frames = self.cycle.frames, self.within.start, len(self._at)
        one = [replace(c, end=min(c.end, n)) for c in effector.contacts if c.start < n]
        laid: list[Contact] = []
        for k in range(int(self._at[0]) // n, int(self._at[-1]) // n + 1):
            for c in one:
                seam = k * n + beside
                moved = replace(c, start=c.start + seam, end=c.end + seam, position=self._led(c.position, k))
                if laid and c.start == 0 and laid[-1].end == seam and _may_join(laid[-1], moved):
                    laid[-1] = _as_one(laid[-1], moved)
                else:
                    laid.append(moved)
        inside = (replace(c, start=max(c.start, 0), end=min(c.end, frames)) for c in laid)
        return replace(effector, contacts=tuple(c for c in inside if c.end > c.start))

    def _led(self, place: tuple[float, float, float] | None, rounds: int) -> tuple[float, float, float] | None:
        """Move a requested place on by some rounds."""
        if place is None or rounds == 0:
            return place
        turn, way = self._lead(rounds)
        x, y, z = (rotation.rotate(turn, np.array(place)) + way).tolist()
        return x, y, z

    def contacts_back(self, found: Contacts) -> Contacts:
        """Cut contacts of all rounds to the clip.

        Args:
            found: of all rounds, N frames.
        """
        start, stop = self.within.start, self.within.stop
        effectors = []
        for effector in found.effectors:
            inside = (
                replace(c, start=max(c.start, start) - start, end=min(c.end, stop) - start) for c in effector.contacts
            )
            effectors.append(replace(effector, contacts=tuple(c for c in inside if c.end > c.start)))
        notes = self.notes_back(found.notes)
        return replace(found, frames=len(self.whole), effectors=tuple(effectors), notes=notes)

    def notes_back(self, notes: Iterable[Note]) -> tuple[Note, ...]:
        """Keep the notes without frames, and those on frames of the clip."""
        start, stop, kept = self.within.start, self.within.stop, []
        for each in notes:
            if each.start is None or each.end is None:
                kept.append(each)
            elif start <= each.start < stop:
                kept.append(replace(each, start=each.start - start, end=min(each.end, stop) - start))
        return tuple(kept)

    def track_back(self, track: Floats) -> Floats:
        """Cut a track (N, ...) of all rounds to the clip (F, ...)."""
        own = track[self.within]
        return own - own[:1]


def rounds_of(clip: Clip, rig: Rig, cycle: Literal["find", "likely", "yes", "no"]) -> Rounds | None:
    """Make the rounds of a clip that is a cycle; None where it is not.

    Args:
        clip: F frames, all of them motion.
        rig: its legs and root.
        cycle: whether it is one, or whether to find out.
    """
    if cycle == "no" or len(clip) < _FEWEST or (cycle in ("find", "likely") and not may_be_cycle(clip)):
        return None
    pose = forward(clip, [rig.root])
    found = find_cycle(clip, rig, pose, likely=cycle == "likely")
    if found is None and cycle == "yes":
        found = said_to_be_one(pose, rig)
    return None if found is None else Rounds(clip, found, rig.root, pose)


def _may_join(before: Contact, after: Contact) -> bool:
    return (before.wish == "forbid") == (after.wish == "forbid")


def _as_one(before: Contact, after: Contact) -> Contact:
    """Join two contacts that the seam separates."""
    long = [before.end - before.start, after.end - after.start]
    sure = (before.confidence * long[0] + after.confidence * long[1]) / sum(long)
    if before.confidence == after.confidence:
        sure = before.confidence
    wish = before.wish or after.wish
    return replace(before, end=after.end, confidence=sure, position=before.position or after.position, wish=wish)
