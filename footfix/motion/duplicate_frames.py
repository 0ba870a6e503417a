"""Duplicate frames: motion at 30 fps in a file at 60, animation on twos or threes, or single repeats.

Such a clip moves and stops in alternate frames, which real motion never does. It is processed without its repeated
frames, at the original frame rate; results are extended so that repeated frames stay equal.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from footfix.motion.clip import Bools, Clip, Floats, Ints
from footfix.motion.contacts import Contacts
from footfix.notes import Note

_SAME = 1e-7  # [m, quaternion] frames that differ by less are equal,
_NOISE = 0.02  # or by less than this share of the largest step both shortly before and shortly after: by rounding,
_NOISY = 0.02  # provided that so many frames do, as a share of the clip;
_NOISIER, _REGULAR = 0.06, 0.15  # or by less than this share of it, where so many frames are repeats in any case
_MOST = 5  # most equal frames in a row; more are a pause
_FEWEST, _SHARE = 3, 0.005  # number of repeated frames, and their share of the clip, from which a note is made
_FRAMES = 12  # shortest clip in which repeated frames are searched


@dataclass(frozen=True, eq=False)
class DuplicateFrames:
    """Maps a clip to its copy without repeated frames, and back.

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
        """Compute the share of frames that repeat the one before."""
        return 1.0 - len(self.kept) / max(self.frames, 1)

    @cached_property
    def owner(self) -> Ints:
        """Find for each frame (F,) its index among the kept frames."""
        return np.asarray(np.searchsorted(self.kept, np.arange(self.frames), side="right") - 1)

    def among(self, start: int, frames: int) -> DuplicateFrames:
        """Make the same map for a longer clip, in which this one begins at frame `start`."""
        if not self:
            return DuplicateFrames(np.arange(frames), frames)
        kept = np.concatenate([np.arange(start), start + self.kept, np.arange(start + self.frames, frames)])
        return DuplicateFrames(kept, frames)

    def track(self, whole: Floats) -> Floats:
        """Take a track of the clip (F, ...) on the frames that are kept (n, ...)."""
        return whole[self.kept] if self else whole

    def clip(self, whole: Clip) -> Clip:
        """Take the clip without repeated frames, at its original rate; the same clip where there are none."""
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
        """Extend contacts of the kept frames, and their notes, to all frames."""
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
        """Renumber the frames of notes for all frames."""
        return tuple(
            each
            if each.start is None or each.end is None
            else replace(each, start=self.first(each.start), end=self.first(each.end))
            for each in notes
        )

    def track_back(self, track: Floats) -> Floats:
        """Extend a track of the kept frames (n, ...) to all frames (F, ...)."""
        return track[self.owner] if self else track

    def first(self, kept: int) -> int:
        """Find the first frame equal to a kept one; for the index after the last, the clip's length."""
        return int(self.kept[kept]) if kept < len(self.kept) else self.frames

    def notes(self, clip: Clip) -> tuple[Note, ...]:
        """Make a note where frames are repeated."""
        if not self:
            return ()
        rate = clip.fps * len(self.kept) / self.frames
        text = (
            f"{100.0 * self.share:.0f} % of the frames repeat the one before: motion of {rate:.4g} fps in a file of "
            f"{clip.fps:.4g}; contacts and correction are as at {rate:.4g} fps, and what is repeated stays so"
        )
        return (Note("frames-doubled", text),)


def _at_rate(clip: Clip, frame_time: float) -> Clip:
    """Change the frame rate of a clip, keeping its frames."""
    joints = range(len(clip.skeleton))
    positions, rotations = [clip.position(joint) for joint in joints], [clip.rotation(joint) for joint in joints]
    return Clip.from_tracks(clip.skeleton, positions, rotations, frame_time)


def doubled(clip: Clip) -> DuplicateFrames:
    """Find the frames of a clip that repeat the one before.

    Two to five equal frames in a row are repeats; more are a pause, of which as many frames are kept as there would be
    at the clip's original rate.

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
    """Mark the frames after the first that equal the one before but for rounding, (F - 1,)."""
    step = np.zeros(len(clip) - 1)  # [m, quaternion] of the joint that moves most
    with np.errstate(invalid="ignore"):  # frames that hold no finite numbers equal none
        for joint in range(len(clip.skeleton)):
            place, turn = clip.position(joint), clip.rotation(joint)
            if place.strides[0]:
                np.maximum(step, np.abs(np.diff(place, axis=0)).max(axis=1), out=step)
            if turn.strides[0]:
                apart = [np.abs(turn[1:] - sign * turn[:-1]).max(axis=1) for sign in (1.0, -1.0)]
                np.maximum(step, np.minimum(*apart), out=step)
    around = np.lib.stride_tricks.sliding_window_view(np.pad(step, _MOST, constant_values=np.inf), _MOST).max(axis=1)
    beside = np.minimum(around[: len(step)], around[_MOST + 1 :])  # the largest shortly before, and shortly after
    beside[~(beside > _SAME)] = 0.0  # a pause
    rounded = (step <= _NOISE * beside) & (beside > 0.0)
    share = float(np.mean(rounded))
    noise = _NOISIER if share >= _REGULAR else _NOISE if share >= _NOISY else 0.0
    return np.asarray(step <= np.maximum(_SAME, noise * beside))
