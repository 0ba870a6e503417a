"""Root motion: travel as a turn about the vertical and a horizontal shift, and removing it from a clip."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats
from footfix.motion.kinematics import forward
from footfix.rig.rig import Rig

_STRAIGHT = 1e-9  # [rad] a smaller turn is none


@dataclass(frozen=True)
class Travel:
    """A turn about the vertical axis through the origin, then a shift over the floor.

    Args:
        yaw: [rad].
        x, z: [m].
    """

    yaw: float = 0.0
    x: float = 0.0
    z: float = 0.0

    @property
    def shift(self) -> Floats:
        """Get the shift (3,) [m]."""
        return np.array([self.x, 0.0, self.z])

    @property
    def turn(self) -> Floats:
        """Convert the turn to a quaternion (4,)."""
        return rotation.about_vertical(self.yaw)

    def places(self, points: Floats) -> Floats:
        """Move points (..., 3) [m] by the travel."""
        return np.asarray(rotation.rotate(self.turn, points) + self.shift)

    def places_back(self, points: Floats) -> Floats:
        """Move points (..., 3) [m] back by the travel."""
        return rotation.rotate(rotation.inverse(self.turn), points - self.shift)

    def about(self, origin: Floats) -> Travel:
        """Express the travel for points relative to another origin (3,) [m]."""
        x, _, z = self.places(origin) - origin
        return Travel(self.yaw, float(x), float(z))

    def straight(self) -> Travel:
        """Straighten the travel: the length of its arc, in its initial direction."""
        half = 0.5 * self.yaw
        longer = half / np.sin(half) if abs(half) > _STRAIGHT else 1.0
        x, _, z = longer * rotation.rotate(rotation.about_vertical(-half), self.shift)
        return Travel(0.0, float(x), float(z))

    def share(self, part: Floats) -> tuple[Floats, Floats]:
        """Compute parts of the travel, along a circular arc or a straight line.

        Args:
            part: (F,) 0 for none of it, 1 for all.

        Returns:
            (F, 4) turns and (F, 3) [m] shifts.
        """
        turns = rotation.about_vertical(part * self.yaw)
        if abs(self.yaw) <= _STRAIGHT:
            return turns, part[:, None] * self.shift
        # the chord of a share of the arc, in the direction of the whole chord turned back by half of what is left
        size = np.sin(0.5 * part * self.yaw) / np.sin(0.5 * self.yaw)
        lean = rotation.about_vertical(0.5 * (part - 1.0) * self.yaw)
        return turns, size[:, None] * rotation.rotate(lean, self.shift)


def carrier(clip: Clip, rig: Rig) -> int:
    """Find the joint that carries the figure through the world: the root, or a moving joint above it."""
    for joint in reversed(clip.skeleton.ancestors(rig.root)):
        if any(len(track) and np.any(track != track[0]) for track in (clip.position(joint), clip.rotation(joint))):
            return joint
    return rig.root


def root_in_world(clip: Clip, root: int) -> tuple[Floats, Floats]:
    """Compute place (F, 3) [m] and rotation (F, 4) of the root in the world."""
    pose = forward(clip, [root])
    return pose.position(root), pose.rotation(root)


def with_root(clip: Clip, root: int, place: Floats, turn: Floats) -> Clip:
    """Replace the root's place and rotation in the world.

    Args:
        clip: F frames.
        root: what carries it (`carrier`).
        place: (F, 3) [m] in the world.
        turn: (F, 4) in the world.
    """
    parent = int(clip.skeleton.parents[root])
    if parent >= 0:
        above = forward(clip, [parent])
        back = rotation.inverse(above.rotation(parent))
        place = rotation.rotate(back, place - above.position(parent))
        turn = rotation.multiply(back, turn)
    return clip.with_joints({root: place}, {root: turn})


def _even(clip: Clip, until: float = 1.0) -> Floats:
    """Number the frames of a closed cycle from 0 to 1, (F,)."""
    return np.linspace(0.0, until, len(clip))


def taken_out(clip: Clip, root: int, travel: Travel, *, until: float = 1.0) -> Clip:
    """Remove travel and turn from a closed cycle at constant speed, so that its last frame is its first.

    Args:
        clip: L + 1 frames, the last of which is the first moved by `travel`.
        root: what carries it (`carrier`).
        travel: of one round.
        until: the share of a round at the last frame, where that does not repeat the first.
    """
    return _moved_back(clip, root, travel, _even(clip, until))


def without_drift(clip: Clip, root: int, travel: Travel) -> Clip:
    """Remove the drift of one round from a closed cycle in place, as on a belt, without turn.

    The middle of the round does not move, so that no frame moves by more than half of the drift.

    Args:
        clip: L + 1 frames, the last of which is the first moved by `travel`.
        root: what carries it (`carrier`).
        travel: of one round.

    Returns:
        The cycle, whose last frame is its first.
    """
    return _moved_back(clip, root, travel, _even(clip) - 0.5)


def _moved_back(clip: Clip, root: int, travel: Travel, part: Floats) -> Clip:
    """Remove parts (F,) of a travel from the frames of a clip."""
    place, turn = root_in_world(clip, root)
    origin = place[0] * [1.0, 0.0, 1.0]
    turns, shifts = travel.about(origin).share(part)
    back = rotation.inverse(turns)
    return with_root(clip, root, origin + rotation.rotate(back, place - origin - shifts), rotation.multiply(back, turn))


def put_in(clip: Clip, root: int, travel: Travel) -> Clip:
    """Add travel to a closed cycle on the spot: undoes `taken_out`."""
    place, turn = root_in_world(clip, root)
    origin = place[0] * [1.0, 0.0, 1.0]
    turns, shifts = travel.about(origin).share(_even(clip))
    moved = origin + rotation.rotate(turns, place - origin) + shifts
    return with_root(clip, root, moved, rotation.multiply(turns, turn))


def straightened(clip: Clip, root: int, travel: Travel) -> tuple[Clip, Travel]:
    """Remove the mean turn of a closed cycle's rounds: it travels as far, but straight.

    Args:
        clip: L + 1 frames, the last of which is the first moved by `travel`.
        root: what carries it (`carrier`).
        travel: of one round.

    Returns:
        The cycle and its travel.
    """
    spot = taken_out(clip, root, travel)
    origin = root_in_world(clip, root)[0][0] * [1.0, 0.0, 1.0]
    straight = travel.about(origin).straight()
    return put_in(spot, root, straight), straight
