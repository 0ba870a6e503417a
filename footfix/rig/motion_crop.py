"""Cut a clip to its motion range, and extend results from there to all frames."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from footfix.motion.clip import Clip, Floats
from footfix.motion.contacts import Contacts
from footfix.motion.lead_in import motion_range
from footfix.notes import Note
from footfix.rig.rig import Rig

_JUMP = 0.01  # [leg lengths] a larger step of the legs from frame to frame is a jump


@dataclass(frozen=True)
class Crop:
    """The frames `[start, end)` of a clip.

    Args:
        start, end: the first frame of the motion, and the first after it.
        frames: of the whole clip.
    """

    start: int
    end: int
    frames: int

    @property
    def cut(self) -> tuple[bool, bool]:
        """Tell whether there are frames before the motion, and after it."""
        return self.start > 0, self.end < self.frames

    @property
    def within(self) -> slice:
        """Get the motion as a slice of the clip."""
        return slice(self.start, self.end)

    def clip(self, whole: Clip) -> Clip:
        """Cut the motion out of a clip; the same clip where all of it is motion."""
        return whole.frames(self.within) if any(self.cut) else whole

    def contacts(self, whole: Contacts) -> Contacts:
        """Cut contacts to the motion; those that lie outside it are left out."""
        if not any(self.cut):
            return whole
        effectors = []
        for effector in whole.effectors:
            inside = (
                replace(c, start=max(c.start, self.start) - self.start, end=min(c.end, self.end) - self.start)
                for c in effector.contacts
            )
            effectors.append(replace(effector, contacts=tuple(c for c in inside if c.end > c.start)))
        return replace(whole, frames=self.end - self.start, effectors=tuple(effectors))

    def contacts_back(self, found: Contacts) -> Contacts:
        """Renumber contacts of the motion, and their notes, for all frames."""
        effectors = []
        for effector in found.effectors:
            moved = (replace(c, start=c.start + self.start, end=c.end + self.start) for c in effector.contacts)
            effectors.append(replace(effector, contacts=tuple(moved)))
        return replace(found, frames=self.frames, effectors=tuple(effectors), notes=self.notes_back(found.notes))

    def notes_back(self, notes: Iterable[Note]) -> tuple[Note, ...]:
        """Renumber the frames of notes for all frames."""
        return tuple(
            each
            if each.start is None or each.end is None
            else replace(each, start=each.start + self.start, end=each.end + self.start)
            for each in notes
        )

    def track_back(self, track: Floats) -> Floats:
        """Extend a track of the motion (n, ...) to all frames (F, ...), constant before and after."""
        around = ((self.start, self.frames - self.end), *((0, 0),) * (track.ndim - 1))
        return np.pad(track, around, mode="edge") if any(self.cut) else track


def crop(clip: Clip, rig: Rig, frame_range: slice | None = None) -> Crop:
    """Find the frames of a clip in which a figure's legs move.

    These are the motion range, and frames beside it in which the legs are continuous though other joints jump, such as
    a first frame in which only the arms are in T-pose.

    Args:
        clip: metres, y up.
        rig: the figure's legs.
        frame_range: the motion range of the clip; found where it is not given.
    """
    frame_range = motion_range(clip) if frame_range is None else frame_range
    start, end = frame_range.start, frame_range.stop
    while start > 0 and _legs_go_on(clip, rig, start):
        start -= 1
    while end < len(clip) and _legs_go_on(clip, rig, end):
        end += 1
    return Crop(start, end, len(clip))


def _legs_go_on(clip: Clip, rig: Rig, frame: int) -> bool:
    """Tell whether no leg joint jumps from the frame before to this one."""
    pose = rig.pose(clip.frames(slice(frame - 1, frame + 1)))
    places = np.stack([pose.position(joint) for leg in rig.legs for joint in (leg.hip, leg.knee, leg.ankle)])  # [m]
    return float(np.linalg.norm(places[:, 1] - places[:, 0], axis=1).max()) <= _JUMP * rig.leg_length
