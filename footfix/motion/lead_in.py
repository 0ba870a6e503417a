"""Lead-in frames at the start and the end of a clip: a T-pose, a bind pose, or a row of zeros.

Many files have such frames, alone or with one to three transition frames. They are recognised by a jump in pose far
larger than any in the clip itself. An actor who stands in T-pose and then moves off, as at both ends of many takes,
makes no jump: that is motion, and is kept.
"""

from __future__ import annotations

import numpy as np

from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats, Ints
from footfix.motion.segments import distinct

LONGEST = 4  # most transition steps; the held pose before them may be longer
_JUMP, _REST_JUMP = 4.0, 1.5  # a jump, as a multiple of the clip's fastest steps; less suffices from the rest pose
_CALM = 5.0  # and as a multiple of the usual steps that follow
_LEAST_TURN = 0.06  # [rad] root mean square over the joints
_LEAST_SHIFT = 0.08  # of the figure's size
_AT_REST = 0.02  # [rad] root mean square: no joint but the root is turned
_FEWEST = 12  # least number of frames of a clip to compare jumps with
_MOST_STEPS = 400  # steps sampled to measure the clip's own



def motion_range(clip: Clip) -> slice:
    """Find the frames of a clip without lead-in and lead-out frames.

    Args:
        clip: F frames, any units and axes.

    Returns:
        The slice `[start, stop)` of its motion; all of it where nothing jumps.
    """
    frames = len(clip)
    if frames < 3:
        return slice(0, frames)
    start = _lead(clip, np.arange(frames))
    stop = frames - _lead(clip, np.arange(frames)[::-1])
    return slice(start, stop) if stop - start >= 2 else slice(0, frames)


def _lead(clip: Clip, order: Ints) -> int:
    """Count the lead-in frames, with the frames in the order given."""
    frames = len(order)
    rest = _turned(clip, order[: LONGEST + 1]) < _AT_REST
    if frames < _FEWEST:
        return int(np.argmin(rest)) if rest[0] and not rest.all() else 0
    held = _held(clip, order)
    first = held if held < frames // 2 else 0  # the pose at the start may be held for a while
    turn, shift = _steps(clip, order[first : first + LONGEST + 13])
    inner = order[first + LONGEST : frames - LONGEST]
    if len(inner) < 4 or len(turn) <= LONGEST:
        return 0
    own_turn, own_shift = _own(clip, inner)
    ratio = _REST_JUMP if rest[0] else _JUMP
    usual = _CALM * float(np.median(turn[LONGEST:]))
    jumps = (turn > max(_LEAST_TURN, ratio * own_turn, usual)) | (
        shift > max(_LEAST_SHIFT * _size(clip), _JUMP * own_shift, _CALM * float(np.median(shift[LONGEST:])))
    )
    if not jumps[:LONGEST].any():
        return 0
    last = int(np.flatnonzero(jumps[:LONGEST])[-1])
    while last + 1 < LONGEST + 1 and turn[last + 1] > max(0.5 * _LEAST_TURN, 0.6 * usual):  # it fades out
        last += 1
    return first + last + 1


def _turned(clip: Clip, order: Ints) -> Floats:
    """Measure how far joints other than roots are turned from the rest pose [rad], root mean square of each frame."""
    turns = clip.rotations[order][:, clip.skeleton.parents >= 0]
    return (
        np.asarray(np.sqrt(np.mean(rotation.angle(turns) ** 2, axis=1)))
        if turns.shape[1]
        else np.full(len(order), np.inf)
    )


def _steps(clip: Clip, order: Ints) -> tuple[Floats, Floats]:
    """Measure from each frame to the next: turn of the joints [rad], root mean square, and shift of the roots."""
    return _between(clip, order[:-1], order[1:])


def _between(clip: Clip, firsts: Ints, seconds: Ints) -> tuple[Floats, Floats]:
    a, b = clip.rotations[firsts], clip.rotations[seconds]
    angles = np.nan_to_num(rotation.apart(a, b))
    both, roots = np.stack([firsts, seconds]), np.flatnonzero(clip.skeleton.parents < 0).tolist()
    places = np.nan_to_num(np.stack([clip.position(root)[both] for root in roots], axis=2), posinf=0.0, neginf=0.0)
    shifts = np.linalg.norm(places[1] - places[0], axis=-1).max(axis=1, initial=0.0)
    return np.sqrt(np.mean(angles**2, axis=1)), shifts


def _own(clip: Clip, inner: Ints) -> tuple[float, float]:
    """Measure the fastest steps within the clip: the 90th percentile, which glitches do not change."""
    firsts = inner[distinct(np.linspace(0, len(inner) - 2, min(_MOST_STEPS, len(inner) - 1)).astype(np.intp))]
    turns, shifts = _between(clip, firsts, firsts + int(inner[1] - inner[0]))
    return float(np.quantile(turns, 0.9)), float(np.quantile(shifts, 0.9))


def _held(clip: Clip, order: Ints) -> int:
    """Count the frames for which the first pose is held, beyond its first frame: up to two seconds."""
    longest = min(len(order) - 1, max(1, round(2.0 / clip.frame_time)))
    turns = clip.rotations[order[: longest + 1]]
    same = (np.abs(np.einsum("fji,fji->fj", turns, turns[:1])) > 1.0 - 1e-9).all(axis=1)
    return max(0, int(np.argmin(same)) - 1) if not same.all() else 0


def _size(clip: Clip) -> float:
    """Estimate the size of the figure, whatever kind of figure it is: the sum of its longest bones."""
    lengths = np.linalg.norm(clip.skeleton.offsets[clip.skeleton.parents >= 0], axis=-1)
    return float(np.sort(lengths)[-8:].sum()) if len(lengths) else 0.0
