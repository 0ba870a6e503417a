"""Closing a cycle: its last frame becomes its first one, moved on by one round, with the velocity of the first."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from footfix.errors import InputError
from footfix.locomotion.cloud import fit
from footfix.locomotion.cuts import Cut
from footfix.locomotion.params import LoopParams
from footfix.locomotion.travel import Travel, root_in_world, with_root
from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats, Ints
from footfix.rig.rig import Rig

_BESIDE = 1.0 / 30.0  # [s] before and after a frame, over which its velocity is taken
_RATIO = 0.5  # of the gap that the start takes; the end takes the rest
_FEWEST = 4  # frames that K's blend needs to be one


@dataclass(frozen=True, eq=False)
class Closed:
    """A closed cycle.

    Args:
        clip: L + 1 frames; the last one is the first moved by `travel`.
        start: the frame of the captured clip that became the first.
        travel: of one round.
    """

    clip: Clip
    start: int
    travel: Travel


def close(clip: Clip, rig: Rig, cut: Cut, params: LoopParams) -> Closed:
    """Close a cut.

    Args:
        clip: F frames.
        rig: its root.
        cut: the cycle in it.
        params: by which method.

    Raises:
        InputError: the method finds no room for its blend.
    """
    travel = fit(clip, cut.start, cut.end, params.window)
    if params.method == "kim-neff":
        return _blended(clip, rig, cut, travel)
    tau = min(params.blend, 0.5 * (cut.end - cut.start) * clip.frame_time)
    return Closed(_offset(clip, rig, cut, travel, tau), cut.start, travel)


def decay(gap: Floats, speed: Floats, tau: float, time: Floats) -> Floats:
    """A cubic that begins with a value and a slope, and ends at rest at zero after `tau`.

    Args:
        gap: (..., 3) the value at first.
        speed: (..., 3) [1/s] the slope at first.
        tau: [s].
        time: (N,) [s].

    Returns:
        (N, ..., 3).
    """
    u = np.clip(time / tau, 0.0, 1.0)
    value, slope = (1.0 - u) ** 2 * (1.0 + 2.0 * u), (1.0 - u) ** 2 * u * tau
    return np.multiply.outer(value, gap) + np.multiply.outer(slope, speed)


def _offset(clip: Clip, rig: Rig, cut: Cut, travel: Travel, tau: float) -> Clip:
    """The gap of position, rotation and velocity is shared by both ends, and decays from either.

    A joint is so moved by half of what a blend on one side moves it. Rotations are offset by a rotation vector on
    the left, the root in the frame of the travel.

    Source: D. Holden, Creating looping animations from motion capture, theorangeduck.com 2022.
    """
    whole = slice(cut.start, cut.end + 1)
    out = clip.frames(whole)
    time = np.arange(len(out)) * clip.frame_time
    first, last = time < tau, time[-1] - time < tau
    places, turns = dict[int, Floats](), dict[int, Floats]()
    for joint in range(len(clip.skeleton)):
        if joint in clip.skeleton.ancestors(rig.root):
            continue
        place, turn = clip.place(joint), clip.turn(joint)
        x, v = _place_gap(place, cut, clip.frame_time)
        if np.any(x) or np.any(v):
            places[joint] = _shifted(place[whole], x, v, tau, time, first, last)
        x, v = _turn_gap(turn, cut, clip.frame_time)
        if np.any(x) or np.any(v):
            places_at = (x, v, tau, time, first, last)
            turns[joint] = _turned(turn[whole], *places_at)
    out = out.with_joints(places, turns)
    return _root_offset(clip, out, rig, cut, travel, tau)


def _root_offset(clip: Clip, out: Clip, rig: Rig, cut: Cut, travel: Travel, tau: float) -> Clip:
    held = _held_above(clip, rig, cut)
    place, turn = root_in_world(held, rig)
    whole = slice(cut.start, cut.end + 1)
    time = np.arange(cut.end - cut.start + 1) * clip.frame_time
    back = time[-1] - time
    x, v = _place_gap(place, cut, clip.frame_time, travel)
    q = travel.turn
    moved = place[whole] + decay(_RATIO * x, _RATIO * v, tau, time)
    moved += rotation.rotate(q, decay((_RATIO - 1.0) * x, (1.0 - _RATIO) * v, tau, back))
    x, v = _turn_gap(turn, cut, clip.frame_time, travel)
    ahead = rotation.from_rotation_vector(decay(_RATIO * x, _RATIO * v, tau, time))
    behind = decay((_RATIO - 1.0) * x, (1.0 - _RATIO) * v, tau, back)
    behind = rotation.from_rotation_vector(rotation.rotate(q, behind))
    turned = rotation.multiply(ahead, rotation.multiply(behind, turn[whole]))
    return _exactly(with_root(_with_above(out, held.frames(whole), rig), rig, moved, turned), rig, travel)


def _place_gap(place: Floats, cut: Cut, dt: float, travel: Travel | None = None) -> tuple[Floats, Floats]:
    """(3,) [m] and (3,) [m/s] from the start of a track to its end, moved back by the travel."""
    (a, b), (va, vb) = place[[cut.start, cut.end]], (_velocity(place, f, dt) for f in (cut.start, cut.end))
    if travel is not None:
        b, vb = travel.places_back(b), rotation.rotate(rotation.inverse(travel.turn), vb)
    return b - a, vb - va


def _velocity(place: Floats, frame: int, dt: float) -> Floats:
    low, high = _beside(frame, len(place), dt)
    return np.asarray((place[high] - place[low]) / ((high - low) * dt))


def _beside(frame: int, frames: int, dt: float) -> tuple[int, int]:
    """The frames between which the velocity of a frame is taken."""
    n = max(1, round(_BESIDE / dt))
    return max(frame - n, 0), min(frame + n, frames - 1)


def _turn_gap(turn: Floats, cut: Cut, dt: float, travel: Travel | None = None) -> tuple[Floats, Floats]:
    """(3,) [rad] and (3,) [rad/s], as rotation vectors on the left, from the start of a track to its end."""
    (a, b), (va, vb) = turn[[cut.start, cut.end]], (_spin(turn, f, dt) for f in (cut.start, cut.end))
    if travel is not None:
        back = rotation.inverse(travel.turn)
        b, vb = rotation.multiply(back, b), rotation.rotate(back, vb)
    return rotation.to_rotation_vector(rotation.multiply(b, rotation.inverse(a))), vb - va


def _spin(turn: Floats, frame: int, dt: float) -> Floats:
    low, high = _beside(frame, len(turn), dt)
    step = rotation.multiply(turn[high], rotation.inverse(turn[low]))
    return np.asarray(rotation.to_rotation_vector(step) / ((high - low) * dt))


def _shifted(
    place: Floats, x: Floats, v: Floats, tau: float, time: Floats, first: Floats, last: Floats
) -> Floats:  # fmt: skip
    out = np.array(place, order="F")
    out[first] += decay(_RATIO * x, _RATIO * v, tau, time[first])
    out[last] += decay((_RATIO - 1.0) * x, (1.0 - _RATIO) * v, tau, time[-1] - time[last])
    return out


def _turned(
    turn: Floats, x: Floats, v: Floats, tau: float, time: Floats, first: Floats, last: Floats
) -> Floats:  # fmt: skip
    out = np.array(turn, order="F")
    ahead = decay(_RATIO * x, _RATIO * v, tau, time[first])
    out[first] = rotation.multiply(rotation.from_rotation_vector(ahead), out[first])
    behind = decay((_RATIO - 1.0) * x, (1.0 - _RATIO) * v, tau, time[-1] - time[last])
    out[last] = rotation.multiply(rotation.from_rotation_vector(behind), out[last])
    return out


def _held_above(clip: Clip, rig: Rig, cut: Cut) -> Clip:
    """The clip with what stands above its root as in the cut's first frame, and the root where it was."""
    above = [joint for joint in clip.skeleton.ancestors(rig.root) if joint != rig.root]
    moves = [j for j in above if np.any(np.diff(clip.place(j), axis=0)) or np.any(np.diff(clip.turn(j), axis=0))]
    if not moves:
        return clip
    place, turn = root_in_world(clip, rig)
    frames = len(clip)
    held = clip.with_joints(
        {j: np.tile(clip.place(j)[cut.start], (frames, 1)) for j in moves},
        {j: np.tile(clip.turn(j)[cut.start], (frames, 1)) for j in moves},
    )
    return with_root(held, rig, place, turn)


def _with_above(clip: Clip, held: Clip, rig: Rig) -> Clip:
    """The clip with its root, and what stands above it, as in another one."""
    above = clip.skeleton.ancestors(rig.root)
    return clip.with_joints({j: held.place(j) for j in above}, {j: held.turn(j) for j in above})


def _exactly(clip: Clip, rig: Rig, travel: Travel) -> Clip:
    """The last frame is the first, to the last bit; the root's moved on."""
    joints = [joint for joint in range(len(clip.skeleton)) if joint not in clip.skeleton.ancestors(rig.root)]
    places, turns = dict[int, Floats](), dict[int, Floats]()
    for joint in joints:
        for track, into in ((clip.place(joint), places), (clip.turn(joint), turns)):
            if np.any(track[-1] != track[0]):
                into[joint] = np.array(track, order="F")
                into[joint][-1] = track[0]
    closed = clip.with_joints(places, turns)
    place, turn = (np.array(each, order="F") for each in root_in_world(closed, rig))
    place[-1], turn[-1] = travel.places(place[0]), rotation.multiply(travel.turn, turn[0])
    return with_root(closed, rig, place, turn)


def _blended(clip: Clip, rig: Rig, cut: Cut, travel: Travel) -> Closed:
    """The frames after the end are blended into those after the start: the last ones first, then the first ones.

    The window is what is left of the shorter of both plants, N_b = min(F_fs - F_s, F_fe - F_e) frames, of which the
    first half is put behind the end and the second in the start's place. So the cycle starts in mid-blend, its
    length stays.

    Source: K 5.2. Put right: w rises from 0 to 1 (as printed it runs from 1 to 2, and eq. 1 and 2 want opposite
    ones), `R = (1 - w) R_a + w R_b`, `q = slerp(q_a, q_b, w)` with a after the end and b after the start; and the
    root's height is blended like its place (left as it is, it leaps at the seam).
    """
    left = [end - frame - 1 for (_, end), frame in zip(cut.stands, (cut.start, cut.end), strict=True)]
    window = min(*left, len(clip) - cut.end) // 2 * 2
    if window < _FEWEST:
        raise InputError(
            f"{max(window, 0)} frames are left of the plants at frames {cut.start} and {cut.end}, too few to blend",
            hint="--method offset needs no plant there",
        )
    held = _held_above(clip, rig, cut)
    half, length = window // 2, cut.end - cut.start
    out = held.frames(slice(cut.start + half, cut.end + half + 1))
    i = np.arange(window)
    w = 0.5 - 0.5 * np.cos(np.pi * (i + 0.5) / window)
    a, b = cut.end + i, cut.start + i
    where = np.concatenate([np.arange(length - half, length), np.arange(half)])  # in the cycle
    places, turns = dict[int, Floats](), dict[int, Floats]()
    for joint in range(len(clip.skeleton)):
        if joint in clip.skeleton.ancestors(rig.root):
            continue
        place, turn = held.place(joint), held.turn(joint)
        if np.any(place[a] != place[b]):
            places[joint] = np.array(out.place(joint), order="F")
            places[joint][where] = (1.0 - w)[:, None] * place[a] + w[:, None] * place[b]
        if np.any(turn[a] != turn[b]):
            turns[joint] = np.array(out.turn(joint), order="F")
            turns[joint][where] = rotation.slerp(turn[a], turn[b], w)
    out = out.with_joints(places, turns)
    place, turn = _root_blended(held, rig, a, b, w, travel)
    whole = [np.array(each, order="F") for each in root_in_world(out, rig)]
    whole[0][where[:half]], whole[1][where[:half]] = place[:half], turn[:half]
    whole[0][where[half:]] = travel.places_back(place[half:])
    whole[1][where[half:]] = rotation.multiply(rotation.inverse(travel.turn), turn[half:])
    return Closed(_exactly(with_root(out, rig, *whole), rig, travel), cut.start + half, travel)


def _root_blended(clip: Clip, rig: Rig, a: Ints, b: Ints, w: Floats, travel: Travel) -> tuple[Floats, Floats]:
    """The root after the end, blended into that after the start moved on by one round."""
    place, turn = root_in_world(clip, rig)
    place_b, turn_b = travel.places(place[b]), rotation.multiply(travel.turn, turn[b])
    return (1.0 - w)[:, None] * place[a] + w[:, None] * place_b, rotation.slerp(turn[a], turn_b, w)
