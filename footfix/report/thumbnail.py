"""A figure at one frame as a small drawing: lines of an SVG, before and after in one frame of reference."""

from __future__ import annotations

import numpy as np

from footfix.motion.clip import Floats
from footfix.report.web.motion import Motion

SIZE = 100  # of the drawing, in its own units
LAYERS = ("was", "bone", "left", "right")
_MARGIN = 6.0
_TURN, _TILT = 0.9, 0.2  # [rad] from the front, and from above
_SMALLEST = 0.02  # of the figure's size: shorter bones (fingers) are left out

Thumbnail = tuple[str, ...]


def thumbnail(motion: Motion, index: int) -> Thumbnail:
    """Draw a figure at a shown frame, in three-quarter view.

    Args:
        motion: the figure before and after.
        index: which of the shown frames.

    Returns:
        The path data of each of `LAYERS`: the figure before; and after, the body, the left legs and the right legs.
    """
    if not motion.bones:
        return ()
    bones = np.array(motion.bones)
    before, after = (_seen(places[index], _heading(motion, index)) for places in _both(motion))
    inside = np.concatenate([before[np.unique(bones)], after[np.unique(bones)]])
    low, high = inside.min(axis=0), inside.max(axis=0)
    size = float((high - low).max()) or 1.0
    scale = (SIZE - 2.0 * _MARGIN) / size
    before, after = ((each - (low + high) / 2.0) * scale + SIZE / 2.0 for each in (before, after))
    long = np.linalg.norm(after[bones[:, 0]] - after[bones[:, 1]], axis=1) > _SMALLEST * SIZE
    sides = _sides(motion)
    of = {side: [bone for bone, keep in zip(motion.bones, long, strict=True) if keep and sides[bone[1]] == side]
          for side in ("", "left", "right")}  # fmt: skip
    drawn = [bone for bone, keep in zip(motion.bones, long, strict=True) if keep]
    return (_path(before, drawn), *(_path(after, of[side]) for side in ("", "left", "right")))


def _both(motion: Motion) -> tuple[Floats, Floats]:
    return motion.joints_before, motion.joints_after


def _heading(motion: Motion, index: int) -> float:
    """Find the heading [rad]: perpendicular to the line between the hips; along z without a left and a right hip."""
    sides = {side: joint for joint, side in motion.hips}
    if not {"left", "right"} <= set(sides):
        return 0.0
    places = motion.joints_after[index]
    across = places[sides["left"]] - places[sides["right"]]
    return float(np.arctan2(-across[2], across[0]))


def _seen(places: Floats, heading: float) -> Floats:
    """Project places (J, 3) orthographically to (J, 2), y downwards."""
    yaw = heading + _TURN
    right = np.array([np.cos(yaw), 0.0, -np.sin(yaw)])
    up = np.array([-np.sin(_TILT) * np.sin(yaw), np.cos(_TILT), -np.sin(_TILT) * np.cos(yaw)])
    return np.stack([places @ right, -(places @ up)], axis=1)


def _sides(motion: Motion) -> list[str]:
    """Find for each joint the side of the leg it belongs to: "left", "right" or "" (parents precede children)."""
    own = dict(motion.hips)
    sides: list[str] = []
    for joint, parent in enumerate(motion.parents):
        sides.append(own.get(joint) or (sides[parent] if parent >= 0 else ""))
    return sides


def _path(places: Floats, bones: list[tuple[int, int]]) -> str:
    """Write bones as path data; a bone that begins where the last one ended continues its line."""
    parts: list[str] = []
    last = -1
    for parent, child in bones:
        x, y = places[child]
        if parent != last:
            parts.append(f"M{places[parent][0]:.0f} {places[parent][1]:.0f}")
        parts.append(f"L{x:.0f} {y:.0f}")
        last = child
    return "".join(parts)
