"""Planted feet on a curved path: remove slide and turn, except the captured roll."""

from __future__ import annotations

import numpy as np

from footfix.locomotion.follow.blend_weight import ease
from footfix.locomotion.follow.footsteps import Steps
from footfix.locomotion.follow.stride import smoothed
from footfix.motion import rotation
from footfix.motion.clip import Bools, Floats, Ints
from footfix.motion.contacts import runs
from footfix.motion.vectors import cross, norm, unit

_TURNS = 0.05  # [rad/m] curvature from which planted feet do not turn
_STRAYS = 0.012  # [m] a planted toe that strays farther is left to enforcement over the whole clip
_ROLLS = 0.025  # [m] the same for a heel before its toe comes down
_EDGE = 0.015  # [s] at both ends of a contact in which the toe may still land or leave
_EASE = 0.16  # [s] over which a foot returns to its captured motion
_SMOOTH = 0.1  # [s] smoothing window of the turn removed from a stance
_SLACK = np.radians(1.0)  # greatest increase of one measure of a foot's turn for the benefit of others
_UP = np.array([0.0, 1.0, 0.0])


def firmness(curvature: Floats) -> Floats:
    """Compute how firmly feet are held, (F,): 0 on straight paths, where they stand as captured, to 1 on curves."""
    return ease(np.abs(curvature) / _TURNS)


def yaws(turn: Floats, ahead: Floats, stands: Ints) -> Floats:
    """Measure a foot's turn about the vertical in several ways, (5, F) [rad].

    They agree while it lies flat, and differ while it rolls over its toes: its direction seen from above, which means
    little once the heel is high; the turn about the vertical of the whole rotation; and the direction of the axis
    across it, about which it rolls. The last two are relative to the middle of the stance, and to its flattest frame.

    Args:
        turn: (F, 4) of the ankle's frame.
        ahead: (F, 3) [m] from the ankle to the toe, in the world.
        stands: the frames in which its toe stands.
    """
    level = np.hypot(ahead[:, 0], ahead[:, 2]) / np.maximum(norm(ahead), 1e-9)
    middle = int(stands[len(stands) // 2])
    readings = [np.arctan2(ahead[:, 0], ahead[:, 2])]
    for flat in (middle, int(stands[np.argmax(level[stands])])):
        since = rotation.multiply(turn, rotation.inverse(turn[flat]))
        axis = rotation.rotate(since, unit(cross(_UP, ahead[flat])))
        readings += [rotation.yaw(since), np.arctan2(axis[:, 0], axis[:, 2])]
    whole = np.unwrap(readings, axis=1)
    return np.asarray(whole - whole[:, middle, None])


def fair(readings: Floats) -> Floats:
    """Find the turn (F,) [rad] that minimises the largest of measures (N, F), none growing by more than `_SLACK`."""
    most = np.maximum(np.abs(readings), _SLACK)
    centre = -0.5 * (readings.min(axis=0) + readings.max(axis=0))
    return np.asarray(np.clip(centre, (-readings - most).max(axis=0), (most - readings).min(axis=0)))


def unturned(
    turn: Floats, ankle: Floats, heel: Floats, toes: Bools, steps: Steps, share: Floats, frame_time: float
) -> tuple[Floats, Floats]:  # fmt: skip
    """Find the rotation about the vertical that keeps a foot from turning while it is planted.

    A stance is placed by one rigid frame of the path, so that a foot turns as in the straight walk. That turn is
    removed as far as all measures of it decrease: completely while the foot lies flat (K 7.1 gives a plant its mean
    swivel angle), little while it rolls over its toes. Before and after, this fades back to the captured foot. The
    foot turns about its toe; before that is down, about its heel.

    Args:
        turn: (F, 4) of the foot, walking along z.
        ankle: (F, 3) [m] from its toe to its ankle.
        heel: (F, 3) [m] from its toe to its heel.
        toes: (F,) whether the toe stands.
        steps: its stances.
        share: (F,) how much of that to apply: none on a straight path.
        frame_time: [s].

    Returns:
        (F,) [rad], and (F, 3) [m] by which the toe is moved.
    """
    F = len(turn)
    yaw, shift = np.zeros(F), np.zeros((F, 3))
    fade, wide = max(3, round(_EASE / frame_time)), max(3, round(_SMOOTH / frame_time))
    for k, (a, b) in enumerate(steps.stances):
        part = float(share[(a + b) // 2])
        if part == 0.0:
            continue
        stands = np.flatnonzero(toes[a:b]) if np.any(toes[a:b]) else np.arange(b - a)
        readings = yaws(turn[a:b], -ankle[a:b], stands)
        own = readings[:, stands]
        fix = part * smoothed(fair(readings - np.median(own, axis=1)[:, None]), wide)
        before = steps.stances[k - 1][1] if k else 0
        after = steps.stances[k + 1][0] if k + 1 < len(steps.stances) else F
        fore, aft = min(fade, a - before), min(fade, after - b)
        yaw[a:b] += fix
        yaw[b : b + aft] += _decay(fix[::-1], aft)
        yaw[a - fore : a] += _decay(fix, fore)[::-1]
        down = np.flatnonzero(toes[a:b])
        if len(down) and down[0] > 0:
            about_heel = _about_heel(yaw, heel, slice(a, a + int(down[0]) + 1))
            shift[a : a + len(about_heel)] += about_heel
            shift[a - fore : a] += _decay(about_heel, fore)[::-1]
    return yaw, shift


def _about_heel(yaw: Floats, heel: Floats, rolls: slice) -> Floats:
    """Compute the shift of the toe (n, 3) [m] that keeps the heel as far from its place as when the toe comes down."""
    moved = rotation.rotate(rotation.about_vertical(yaw[rolls]), heel[rolls]) - heel[rolls]
    return np.asarray(moved[-1] - moved)


def unslid(toe: Floats, toes: Bools, share: Floats, frame_time: float) -> Floats:
    """Find the horizontal shift (F, 3) [m] that keeps a planted toe in one place.

    Args:
        toe: (F, 3) [m] in the frame that carries it.
        toes: (F,) whether it stands.
        share: (F,) how much of that is wanted.
        frame_time: [s].
    """
    shift = np.zeros_like(toe)
    edge, fade = max(1, round(_EDGE / frame_time)), max(3, round(_EASE / frame_time))
    for start, end in runs(toes):
        a, b = start + edge, end - edge
        part = float(share[(start + end) // 2])
        if b - a < 3 or part == 0.0:
            continue
        off = part * (np.median(toe[a:b], axis=0) - toe[a:b]) * [1.0, 0.0, 1.0]
        if np.hypot(off[:, 0], off[:, 2]).max() > _STRAYS:
            continue
        fore, aft = min(fade, a), min(fade, len(toe) - b)
        shift[a:b] += off
        shift[b : b + aft] += _decay(off[::-1], aft)
        shift[a - fore : a] += _decay(off, fore)[::-1]
    return shift


def rolled(heel: Floats, heels: Bools, toes: Bools, mixed: Bools, frame_time: float) -> Floats:
    """Find the horizontal shift (F, 3) [m] that keeps a planted heel in one place until the toe comes down.

    Blended from a walk that lands on the heel and one that lands on the toe, a heel would slide by some millimetres.

    Args:
        heel: (F, 3) [m] in the frame that carries the foot.
        heels, toes: (F,) whether they stand.
        mixed: (F,) whether the foot is mixed.
        frame_time: [s].
    """
    shift = np.zeros_like(heel)
    edge, fade = max(1, round(_EDGE / frame_time)), max(3, round(_EASE / frame_time))
    for start, b in runs(heels & ~toes):
        a = start + edge
        if b - a < 2 or b == len(toes) or not toes[b] or not mixed[(a + b) // 2]:
            continue
        off = (heel[b] - heel[a:b]) * [1.0, 0.0, 1.0]
        if np.hypot(off[:, 0], off[:, 2]).max() > _ROLLS:
            continue
        fore = min(fade, a)
        shift[a:b] += off
        shift[a - fore : a] += _decay(off, fore)[::-1]
    return shift


def _decay(fix: Floats, frames: int) -> Floats:
    """Continue values and slopes that start as in `fix` (n, ...) until they come to rest at zero, (frames, ...)."""
    most = np.abs(fix[0]) / 2.0
    slope = np.clip((fix[0] - fix[2]) / 2.0 if len(fix) > 2 else 0.0 * most, -most, most)
    u = (np.arange(1, frames + 1) / (frames + 1)).reshape(-1, *(1,) * (fix.ndim - 1))
    return np.asarray((1.0 - u) ** 2 * ((1.0 + 2.0 * u) * fix[0] + u * (frames + 1) * slope * (1.0 - u) ** 2))
