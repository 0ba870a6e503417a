"""Clips that are cycles: the last frame leads to the first, moved on by the travel of one round.

A cycle is solved as one: several rounds of it are laid end to end, the middle one is taken, and its seam is closed.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from footfix.enforce.leg import LEG, ROOT, LegTracks
from footfix.enforce.pins import Pins
from footfix.enforce.problem import Problem
from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats
from footfix.motion.kinematics import Pose
from footfix.rig.rig import Rig

_SAME = 0.3  # of the clip's usual step, root mean square over the joints: poses that differ by less are one
_MOVES = 0.2  # of the usual step: less than this at the seam is a pause, not a stride
_TILT = 3.0  # [degrees] by which the root may lean otherwise
_HEIGHT = 0.02  # [leg lengths] by which its height may differ
_LONGEST = 12.0  # [s] of one round
_FEWEST = 8  # frames of one round
_BESIDE = 1.5  # [s] of rounds on either side of the middle one: a correction dies out in less


@dataclass(frozen=True)
class Cycle:
    """One round of a cycle.

    Args:
        frames: of one round; the clip has one more where its last frame repeats the first.
        yaw: [rad] by which a round turns the figure.
    """

    frames: int
    yaw: float


def find_cycle(clip: Clip, rig: Rig, pose: Pose) -> Cycle | None:
    """Find whether a clip is a cycle.

    Its last frame is the first one, moved over the floor and turned about the vertical; or a step before that, and
    the figure steps on as it does in its first step. It moves at the seam: two pauses are no cycle.

    Args:
        clip: F frames.
        rig: its root.
        pose: of the clip, with the root.
    """
    frames = len(clip)
    if frames < _FEWEST or frames * clip.frame_time > _LONGEST:
        return None
    joints = [joint for joint in range(len(clip.skeleton)) if joint not in clip.skeleton.ancestors(rig.root)]
    turns = np.stack([clip.turn(joint) for joint in joints], axis=1)  # (F, J, 4)
    height = pose.position(rig.root)[:, 1]

    def step(a: int, b: int) -> Floats:  # (J, 3) [rad]
        return rotation.to_rotation_vector(rotation.multiply(rotation.inverse(turns[a]), turns[b]))

    usual = _size(rotation.to_rotation_vector(rotation.multiply(rotation.inverse(turns[:-1]), turns[1:])))
    first, last, over = step(0, 1), step(frames - 2, frames - 1), step(frames - 1, 0)
    moves = usual > 1e-6 and min(_size(first), _size(last)) >= _MOVES * usual
    if not moves or _tilt(pose.rotation(rig.root)[[0, -1]]) > np.radians(_TILT):
        return None
    yaw, low = _yaw(pose.rotation(rig.root)), _HEIGHT * rig.leg_length
    if _size(over) < _SAME * usual and abs(height[-1] - height[0]) < low:
        return Cycle(frames - 1, yaw)
    if _size(over - first) < _SAME * usual and abs(height[0] - height[-1] - (height[1] - height[0])) < low:
        return Cycle(frames, yaw + _yaw(pose.rotation(rig.root)[:2]))
    return None


def _size(turns: Floats) -> float:
    """[rad] root mean square of rotation vectors (..., 3)."""
    return float(np.sqrt(np.mean(np.sum(turns**2, axis=-1))))


def _tilt(turns: Floats) -> float:
    """[rad] by which the vertical of the last of some frames (n, 4) differs from the first's."""
    up = rotation.rotate(rotation.inverse(turns), np.array([0.0, 1.0, 0.0]))
    return float(np.arccos(np.clip(up[0] @ up[-1], -1.0, 1.0)))


def _yaw(turns: Floats) -> float:
    """[rad] about the vertical from the first to the last of some frames (n, 4)."""
    q = rotation.multiply(turns[-1], rotation.inverse(turns[0]))
    yaw = 2.0 * np.arctan2(q[1], q[3])
    return float(yaw - 2.0 * np.pi * np.round(yaw / (2.0 * np.pi)))


def solved_as_cycle(problem: Problem, cycle: Cycle, solve: Callable[[Problem], Floats]) -> Floats:
    """Find the state (U, F) of a cycle, closed at its seam.

    Args:
        problem: of the clip as it is, F frames.
        cycle: its round.
        solve: what finds the state of an open clip.
    """
    beside = max(1, int(np.ceil(_BESIDE / (cycle.frames * problem.frame_time))))
    rounds = range(-beside, beside + 1)
    legs = tuple(_laid(leg, cycle, rounds) for leg in problem.legs)
    pins = tuple(
        tuple(_pins_laid(pin, leg.place(point), cycle, rounds) for point, pin in enumerate(own))
        for own, leg in zip(problem.pins, problem.legs, strict=True)
    )
    fault = np.tile(problem.fault[: cycle.frames], len(rounds))
    x = solve(replace(problem, legs=legs, pins=pins, fault=fault, cut=(False, False)))
    own = x[:, beside * cycle.frames : (beside + 1) * cycle.frames]
    if problem.frames == cycle.frames:
        return own
    return np.concatenate([own, _state_turned(own[:, :1], cycle.yaw)], axis=1)


def _turned(vectors: Floats, yaw: float) -> Floats:
    """Vectors (3, n), turned about the vertical."""
    c, s = np.cos(yaw), np.sin(yaw)
    return np.stack([c * vectors[0] + s * vectors[2], vectors[1], c * vectors[2] - s * vectors[0]])


def _state_turned(x: Floats, yaw: float) -> Floats:
    """A state (U, n) of a figure that is turned about the vertical."""
    out = x.copy()
    out[:ROOT] = _turned(x[:ROOT], yaw)
    for base in range(ROOT, len(x), LEG):
        for start in (base, base + 4):  # q and w
            out[start : start + 3] = _turned(x[start : start + 3], yaw)
    return out


def _laid(leg: LegTracks, cycle: Cycle, rounds: range) -> LegTracks:
    """A leg over some rounds. Where it is over the floor means nothing to the objective, so travel is left out."""
    one = leg.frames(slice(0, cycle.frames))
    turned = ("hip", "ankle", "line", "thigh", "shank", "axis", "toe_hinge")
    parts = {
        name: np.concatenate([_turned(getattr(one, name), k * cycle.yaw) for k in rounds], axis=1) for name in turned
    }
    flexion, least, reach = (np.tile(each, len(rounds)) for each in (one.flexion, one.least, one.reach))
    points = tuple(np.concatenate([_turned(each, k * cycle.yaw) for k in rounds], axis=1) for each in one.points)
    # travel: each round goes on where the one before it ended
    ends = [_turned(_travel(leg, cycle), k * cycle.yaw) for k in rounds]
    shift = np.cumsum(np.concatenate([np.zeros((3, 1)), *ends[:-1]], axis=1), axis=1)
    shift -= shift[:, [len(rounds) // 2]]  # the middle round stays where it is
    moved = np.repeat(shift, cycle.frames, axis=1)
    parts["hip"], parts["ankle"] = parts["hip"] + moved, parts["ankle"] + moved
    return LegTracks(
        leg.leg, **parts, flexion=flexion, least=least, reach=reach, points=points, bends=leg.bends, turns=leg.turns
    )


def _travel(leg: LegTracks, cycle: Cycle) -> Floats:
    """(3, 1) [m] from where a turned round would begin to where the next one does, over the floor."""
    last = leg.hip[:, -1:]
    if leg.hip.shape[1] == cycle.frames:  # the last frame is a step before the next round
        last = last + _turned(leg.hip[:, 1:2] - leg.hip[:, :1], cycle.yaw)
    travel = last - _turned(leg.hip[:, :1], cycle.yaw)
    travel[1] = 0.0
    return travel


def _pins_laid(pin: Pins, track: Floats, cycle: Cycle, rounds: range) -> Pins:
    """A point's pins over some rounds; what stands at the clip's end goes on standing at its start."""
    n, closed = cycle.frames, len(pin.stands) > cycle.frames
    hold, slip = pin.hold, pin.slip
    if not closed:  # the step over the seam
        both = pin.stands[0] and pin.stands[-1]
        hold = np.append(hold, min(hold[-1], hold[0]) if both else 0.0)
        slip = np.concatenate([slip, _turned(slip[:, :1], cycle.yaw)], axis=1)
    hold, slip = hold[:n], slip[:, :n]
    count = len(rounds)
    spans = tuple((a + k * n, min(b, n) + k * n) for k in range(count) for a, b in pin.spans if a < n)
    return Pins(
        np.tile(hold, count)[:-1],
        np.concatenate([_turned(slip, k * cycle.yaw) for k in rounds], axis=1)[:, :-1],
        np.tile(pin.stands[:n], count), np.tile(pin.level[:n], count), np.tile(pin.draw[:n], count),
        np.tile(pin.lowest[:n], count), np.tile(pin.place[:, :n], (1, count)),
        _middle_only(pin.placed[:n], count), spans,
    )  # fmt: skip


def _middle_only(placed: Floats, count: int) -> Floats:
    """Places are asked for on the clip's own ground: in the middle round."""
    out = np.zeros(len(placed) * count)
    out[count // 2 * len(placed) : (count // 2 + 1) * len(placed)] = placed
    return out
