"""Frames that stand twice: motion of 30 frames a second in a file of 60, on twos or threes, or one now and then.

Such a clip jumps and rests by turns, which no motion does. It is worked on without its repeated frames, at the rate
it was made at, and what is found is put back so that frames that were the same stay the same.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from footfix.motion.clip import Bools, Clip, Floats, Ints
from footfix.motion.contacts import Contacts
from footfix.notes import Note

_SAME = 1e-7  # [m, quaternion] frames that differ by less are one
_MOST = 5  # times that a frame stands in a row; one that stands more often is a pause
_FEWEST, _SHARE = 3, 0.005  # repeated frames, and their share of the clip, that are worth a word
_FRAMES = 12  # of a clip in which this can be told


@dataclass(frozen=True, eq=False)
class DuplicateFrames:
    """Which frames of a clip stand for all.

    Args:
        kept: (n,) the frames that are not repeated ones, in order.
        frames: F, of the clip.
    """

    kept: Ints
    frames: int

    def __bool__(self) -> bool:
        return len(self.kept) < self.frames

    @property
    def share(self) -> float:
        """How many of the frames repeat the one before."""
        return 1.0 - len(self.kept) / max(self.frames, 1)

    @cached_property
    def owner(self) -> Ints:
        """(F,) for each frame which of the kept ones it is."""
        return np.asarray(np.searchsorted(self.kept, np.arange(self.frames), side="right") - 1)

    def among(self, start: int, frames: int) -> DuplicateFrames:
        """Say the same of a longer clip of so many frames, in which this one's begin at `start`."""
        if not self:
            return DuplicateFrames(np.arange(frames), frames)
        kept = np.concatenate([np.arange(start), start + self.kept, np.arange(start + self.frames, frames)])
        return DuplicateFrames(kept, frames)

    def track(self, whole: Floats) -> Floats:
        """Take a track of the clip (F, ...) on the frames that are kept (n, ...)."""
        return whole[self.kept] if self else whole

    def clip(self, whole: Clip) -> Clip:
        """Take the clip without what is repeated, at the rate it was made at; the very clip where nothing is."""
        if not self:
            return whole
        return _at_rate(whole.frames(self.kept), whole.frame_time * self.frames / len(self.kept))

    def contacts(self, whole: Contacts) -> Contacts:
        """Take the contacts of the clip on the frames that are kept."""
        if not self:
            return whole
        effectors = tuple(
            replace(e, contacts=tuple(
                replace(c, start=int(self.owner[c.start]), end=int(self.owner[c.end - 1]) + 1)
                for c in e.contacts if c.end > c.start
            ))
            for e in whole.effectors
        )  # fmt: skip
        frame_time = whole.frame_time * self.frames / len(self.kept)
        return replace(whole, frames=len(self.kept), frame_time=frame_time, effectors=effectors)

    def contacts_back(self, found: Contacts) -> Contacts:
        """Put contacts of the kept frames, and their notes, back among all frames."""
        if not self:
            return found
        effectors = tuple(
            replace(e, contacts=tuple(replace(c, start=self.first(c.start), end=self.first(c.end)) for c in e.contacts))
            for e in found.effectors
        )
        frame_time = found.frame_time * len(self.kept) / self.frames
        notes = self.notes_back(found.notes)
        return replace(found, frames=self.frames, frame_time=frame_time, effectors=effectors, notes=notes)

    def notes_back(self, notes: Iterable[Note]) -> tuple[Note, ...]:
        """Put the frames that notes are about back among all frames."""
        return tuple(
            each
            if each.start is None or each.end is None
            else replace(each, start=self.first(each.start), end=self.first(each.end))
            for each in notes
        )

    def track_back(self, track: Floats) -> Floats:
        """Put a track of the kept frames (n, ...) back among all frames (F, ...)."""
        return track[self.owner] if self else track

    def first(self, kept: int) -> int:
        """Find the first of the frames that a kept one stands for; of one after the last, the clip's length."""
        return int(self.kept[kept]) if kept < len(self.kept) else self.frames

    def notes(self, clip: Clip) -> tuple[Note, ...]:
        """Say so, where frames are repeated."""
        if not self:
            return ()
        rate = clip.fps * len(self.kept) / self.frames
        text = (
            f"{100.0 * self.share:.0f} % of the frames repeat the one before: motion of {rate:.4g} fps in a file of "
            f"{clip.fps:.4g}; contacts and correction are as at {rate:.4g} fps, and what is repeated stays so"
        )
        return (Note("frames-doubled", text),)


def _at_rate(clip: Clip, frame_time: float) -> Clip:
    """The same frames at another rate."""
    joints = range(len(clip.skeleton))
    positions, rotations = [clip.position(joint) for joint in joints], [clip.rotation(joint) for joint in joints]
    return Clip.from_tracks(clip.skeleton, positions, rotations, frame_time)


def doubled(clip: Clip) -> DuplicateFrames:
    """Find the frames of a clip that repeat the one before.

    A frame that stands two to five times in a row does; one that stands longer is a pause, of which as many frames
    are kept as would be had at the rate the others were made at.

    Args:
        clip: F frames.
    """
    frames = len(clip)
    everything = DuplicateFrames(np.arange(frames), frames)
    if frames < _FRAMES:
        return everything
    same = _same(clip)
    starts = np.flatnonzero(np.append(True, ~same))
    lengths = np.diff(np.append(starts, frames))
    short = lengths <= _MOST
    repeated = int(np.sum(lengths[short] - 1))
    if repeated < max(_FEWEST, _SHARE * frames) or short.sum() < 2:
        return everything
    each = max(1, round(float(np.mean(lengths[short]))))
    kept = np.concatenate([
        np.arange(start, start + (1 if length <= _MOST else length), each)
        for start, length in zip(starts.tolist(), lengths.tolist(), strict=True)
    ])  # fmt: skip
    return DuplicateFrames(kept, frames)


def _same(clip: Clip) -> Bools:
    """(F - 1,) whether each frame but the first is the one before."""
    same = np.ones(len(clip) - 1, dtype=np.bool_)
    for joint in range(len(clip.skeleton)):
        for track in (clip.position(joint), clip.rotation(joint)):
            if track.strides[0]:
                same &= (np.abs(np.diff(track, axis=0)) <= _SAME).all(axis=1)
        if not same.any():
            break
    return same
