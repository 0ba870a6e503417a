"""Closing a cycle: its last frame becomes its first one, moved on by one round, with the velocity of the first."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from footfix.errors import InputError
from footfix.locomotion.loop.cloud import fit
from footfix.locomotion.loop.cuts import Cut
from footfix.locomotion.loop.params import LoopParams
from footfix.locomotion.loop.seam import apart, changes, ratios
from footfix.locomotion.loop.travel import Travel, carrier, root_in_world, with_root
from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats, Ints
from footfix.rig.rig import Rig

_BESIDE = 1.0 / 30.0  # [s] before and after a frame, over which its velocity is taken
_RATIO = 0.5  # of the gap that the start takes; the end takes the rest
# shares of the time for the gap, and for its slope: the sooner they decay the less do joints swing out, and the more
# are they jolted. The first is tried, the others where it does not do.
_TIMES = ((1.0, 0.4), (1.6, 0.6), (1.0, 0.25), (0.75, 0.25), (0.5, 0.2))
_MOST = 0.6  # of the largest gap, by which a joint may be moved
_CALM = 1.1  # times what a joint accelerates elsewhere, up to which a seam is calm
_FAR = 5.0  # times as bad as the same share of such an acceleration it is to be moved by more
_NO_GAP = 1e-3  # [leg lengths] less is none
_NONE: Floats = np.zeros(3)
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
    root, travel = carrier(clip, rig), fit(clip, rig, cut.start, cut.end, params.window)
    if params.method == "kim-neff":
        return _blended(clip, root, cut, travel)
    best: tuple[float, Clip | None] = (np.inf, None)
    for share, slope in _TIMES:
        limit = 0.5 * (cut.end - cut.start) * clip.frame_time
        closed = _offset(clip, root, cut, travel, min(share * params.blend, limit), min(slope * params.blend, limit))
        worse = _worse(clip, rig, cut, closed, travel)
        if best[1] is None or worse < best[0]:
            best = worse, closed
        if worse == 0.0:
            break
    assert best[1] is not None
    return Closed(best[1], cut.start, travel)


def _worse(clip: Clip, rig: Rig, cut: Cut, closed: Clip, travel: Travel) -> float:
    """By how much a closed cycle is worse than it should be: joints that swing out, or are jolted at the seam."""
    gap = apart(clip, rig, cut.start, cut.end, travel)[0]
    moved = changes(clip.frames(slice(cut.start, cut.end + 1)), closed, rig)[0]
    far = max(moved / gap - _MOST, 0.0) if gap > _NO_GAP * rig.leg_length else 0.0
    return _FAR * far + max(ratios(closed, rig, travel)[1] - _CALM, 0.0)


@dataclass(frozen=True, eq=False)
class Decay:
    """How a gap of value and slope decays over the frames of a cycle, from both of its ends.

    Cubics that begin with a value, or a slope, and end at rest at zero.

    Args:
        value_ahead, slope_ahead: (F,) what is left of them after the start, the slope [s].
        value_behind, slope_behind: (F,) before the end.
    """

    value_ahead: Floats
    slope_ahead: Floats
    value_behind: Floats
    slope_behind: Floats

    def ahead(self, gap: Floats = _NONE, speed: Floats = _NONE) -> Floats:
        """(F, 3) the start's share of a gap (3,) and of its change (3,) [1/s]."""
        return _RATIO * (np.multiply.outer(self.value_ahead, gap) + np.multiply.outer(self.slope_ahead, speed))

    def behind(self, gap: Floats = _NONE, speed: Floats = _NONE) -> Floats:
        """(F, 3) the end's share, which takes away what the start adds."""
        rest = 1.0 - _RATIO
        return rest * (np.multiply.outer(self.slope_behind, speed) - np.multiply.outer(self.value_behind, gap))


def decay(frames: int, frame_time: float, tau: float, slope: float) -> Decay:
    """The decay of a gap over `tau` [s] at either end of some frames; of its slope over `slope` [s]."""
    time: Floats = np.asarray(np.arange(frames) * frame_time, dtype=np.float64)
    parts = []
    for since in (time, time[-1] - time):
        u, w = (np.clip(since / part, 0.0, 1.0) for part in (tau, slope))
        parts += [(1.0 - u) ** 2 * (1.0 + 2.0 * u), (1.0 - w) ** 2 * w * slope]
    return Decay(*parts)


def _offset(clip: Clip, root: int, cut: Cut, travel: Travel, tau: float, slope: float) -> Clip:
    """The gap of position, rotation and velocity is shared by both ends, and decays from either.

    A joint is so moved by half of what a blend on one side moves it. Rotations are offset by rotation vectors on the
    left, what carries the figure in the frame of the travel. First the poses are joined, by offsets that begin at
    rest; the velocities are compared as these turn them, and their gap decays after.

    Source: D. Holden, Creating looping animations from motion capture, theorangeduck.com 2022.
    """
    whole, dt = slice(cut.start, cut.end + 1), clip.frame_time
    out = clip.frames(whole)
    fade = decay(len(out), dt, tau, slope)
    some = (fade.value_ahead > 0.0) | (fade.value_behind > 0.0)
    places, turns = dict[int, Floats](), dict[int, Floats]()
    for joint in range(len(clip.skeleton)):
        if joint in clip.skeleton.ancestors(root):
            continue
        gap, speed = _place_gap(clip.position(joint), cut, dt)
        if np.any(gap) or np.any(speed):
            places[joint] = np.array(out.position(joint), order="F")
            places[joint][some] += (fade.ahead(gap, speed) + fade.behind(gap, speed))[some]
        gap, speed = _turn_gap(clip.rotation(joint), cut, dt)
        if np.any(gap) or np.any(speed):
            joined = rotation.from_rotation_vector((fade.ahead(gap) + fade.behind(gap))[some])
            smooth = rotation.from_rotation_vector((fade.ahead(speed=speed) + fade.behind(speed=speed))[some])
            turns[joint] = np.array(out.rotation(joint), order="F")
            turns[joint][some] = rotation.multiply(smooth, rotation.multiply(joined, turns[joint][some]))
    place, turn = root_in_world(clip, root)
    gap, speed = _place_gap(place, cut, dt, travel)
    place_out = place[whole] + fade.ahead(gap, speed) + rotation.rotate(travel.turn, fade.behind(gap, speed))
    gap, speed = _turn_gap(turn, cut, dt, travel)
    turn_out = np.array(turn[whole], order="F")
    for kind in ({"gap": gap}, {"speed": speed}):
        behind = rotation.from_rotation_vector(rotation.rotate(travel.turn, fade.behind(**kind))[some])
        off = rotation.multiply(rotation.from_rotation_vector(fade.ahead(**kind)[some]), behind)
        turn_out[some] = rotation.multiply(off, turn_out[some])
    return _exactly(with_root(out.with_joints(places, turns), root, place_out, turn_out), root, travel)


def _place_gap(place: Floats, cut: Cut, dt: float, travel: Travel | None = None) -> tuple[Floats, Floats]:
    """(3,) [m] and (3,) [m/s] from the start of a track to its end, moved back by the travel."""
    (a, b), (va, vb) = place[[cut.start, cut.end]], (_velocity(place, f, dt) for f in (cut.start, cut.end))
    if travel is not None:
        b, vb = travel.places_back(b), rotation.rotate(rotation.inverse(travel.turn), vb)
    return b - a, vb - va


def _velocity(place: Floats, frame: int, dt: float) -> Floats:
    at, weight = _beside(frame, len(place), dt)
    return np.asarray(weight @ (place[at] - place[frame]))


def _beside(frame: int, frames: int, dt: float) -> tuple[Ints, Floats]:
    """The frames that the velocity of a frame is told by, and the weight [1/s] of each: the slope of a polynomial.

    It is a cubic, so that a changing acceleration does not count as velocity, and a parabola where the clip ends.
    """
    n = max(2, round(_BESIDE / dt))
    before, after = min(n, frame), min(n, frames - 1 - frame)
    return np.arange(frame - before, frame + after + 1), _slope(before, after, dt)


@cache
def _slope(before: int, after: int, dt: float) -> Floats:
    at = np.arange(-before, after + 1)
    degree = 3 if min(before, after) >= 2 else min(2, len(at) - 1)
    return np.asarray(np.linalg.pinv(np.vander(at * dt, degree + 1, increasing=True))[1])


def _turn_gap(turn: Floats, cut: Cut, dt: float, travel: Travel | None = None) -> tuple[Floats, Floats]:
    """(3,) [rad] and (3,) [rad/s], as rotation vectors on the left, from the start of a track to its end.

    The velocities are those that both ends have when they are turned to where they meet.
    """
    (a, b), (va, vb) = turn[[cut.start, cut.end]], (_spin(turn, f, dt) for f in (cut.start, cut.end))
    if travel is not None:
        back = rotation.inverse(travel.turn)
        b, vb = rotation.multiply(back, b), rotation.rotate(back, vb)
    gap = rotation.to_rotation_vector(rotation.multiply(b, rotation.inverse(a)))
    va = rotation.rotate(rotation.from_rotation_vector(_RATIO * gap), va)
    vb = rotation.rotate(rotation.from_rotation_vector((_RATIO - 1.0) * gap), vb)
    return gap, vb - va


def _spin(turn: Floats, frame: int, dt: float) -> Floats:
    at, weight = _beside(frame, len(turn), dt)
    return np.asarray(weight @ rotation.to_rotation_vector(rotation.multiply(turn[at], rotation.inverse(turn[frame]))))


def _exactly(clip: Clip, root: int, travel: Travel) -> Clip:
    """The last frame is the first, to the last bit; the root's moved on."""
    joints = [joint for joint in range(len(clip.skeleton)) if joint not in clip.skeleton.ancestors(root)]
    places, turns = dict[int, Floats](), dict[int, Floats]()
    for joint in joints:
        for track, into in ((clip.position(joint), places), (clip.rotation(joint), turns)):
            if np.any(track[-1] != track[0]):
                into[joint] = np.array(track, order="F")
                into[joint][-1] = track[0]
    closed = clip.with_joints(places, turns)
    place, turn = (np.array(each, order="F") for each in root_in_world(closed, root))
    place[-1], turn[-1] = travel.places(place[0]), rotation.multiply(travel.turn, turn[0])
    return with_root(closed, root, place, turn)


def _blended(clip: Clip, root: int, cut: Cut, travel: Travel) -> Closed:
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
    half, length = window // 2, cut.end - cut.start
    out = clip.frames(slice(cut.start + half, cut.end + half + 1))
    i = np.arange(window)
    w = 0.5 - 0.5 * np.cos(np.pi * (i + 0.5) / window)
    a, b = cut.end + i, cut.start + i
    where = np.concatenate([np.arange(length - half, length), np.arange(half)])  # in the cycle
    places, turns = dict[int, Floats](), dict[int, Floats]()
    for joint in range(len(clip.skeleton)):
        if joint in clip.skeleton.ancestors(root):
            continue
        place, turn = clip.position(joint), clip.rotation(joint)
        if np.any(place[a] != place[b]):
            places[joint] = np.array(out.position(joint), order="F")
            places[joint][where] = (1.0 - w)[:, None] * place[a] + w[:, None] * place[b]
        if np.any(turn[a] != turn[b]):
            turns[joint] = np.array(out.rotation(joint), order="F")
            turns[joint][where] = rotation.slerp(turn[a], turn[b], w)
    out = out.with_joints(places, turns)
    place, turn = _root_blended(clip, root, a, b, w, travel)
    whole = [np.array(each, order="F") for each in root_in_world(out, root)]
    whole[0][where[:half]], whole[1][where[:half]] = place[:half], turn[:half]
    whole[0][where[half:]] = travel.places_back(place[half:])
    whole[1][where[half:]] = rotation.multiply(rotation.inverse(travel.turn), turn[half:])
    return Closed(_exactly(with_root(out, root, *whole), root, travel), cut.start + half, travel)


def _root_blended(clip: Clip, root: int, a: Ints, b: Ints, w: Floats, travel: Travel) -> tuple[Floats, Floats]:
    """The root after the end, blended into that after the start moved on by one round."""
    place, turn = root_in_world(clip, root)
    place_b, turn_b = travel.places(place[b]), rotation.multiply(travel.turn, turn[b])
    return (1.0 - w)[:, None] * place[a] + w[:, None] * place_b, rotation.slerp(turn[a], turn_b, w)
