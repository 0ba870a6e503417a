"""Close a cycle: its last frame becomes the first, moved by one round, with the first frame's velocity."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from footfix.errors import InputError
from footfix.locomotion.loop.cut_search import Cut
from footfix.locomotion.loop.params import LoopParams
from footfix.locomotion.loop.point_cloud import fit
from footfix.locomotion.loop.root_motion import Travel, carrier, root_in_world, with_root
from footfix.locomotion.loop.seam import figure, ratios, ratios_of
from footfix.locomotion.loop.seam_gap import RATIO, Gap, gaps_below, gaps_of_root
from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats, Ints
from footfix.rig.rig import Rig

# shares of the time for the gap, and for its slope: the sooner they decay the less do joints swing out, and the more
# are they jolted. The first is tried, the others where it does not do.
_TIMES = ((1.0, 0.4), (1.6, 0.6), (1.0, 0.25), (0.75, 0.25), (0.5, 0.2))
_MOST = 0.6  # greatest shift of a joint, as a share of the largest gap
_CALM = 1.1  # greatest acceleration at a calm seam, as a multiple of that elsewhere
_FAR = 5.0  # weight of excess shift, relative to excess acceleration
_NO_GAP = 1e-3  # [leg lengths] a smaller gap counts as none
_NONE: Floats = np.zeros(3)
_FEWEST = 4  # least number of frames of K's blend


@dataclass(frozen=True, eq=False)
class Closed:
    """A closed cycle.

    Args:
        clip: L + 1 frames; the last one is the first moved by `travel`.
        start: the frame of the captured clip that became the first.
        travel: of one round.
        worst_ratio: largest ratio, over all joints, of acceleration beside the seam to that elsewhere (`seam.ratios`).
    """

    clip: Clip
    start: int
    travel: Travel
    worst_ratio: float


def close(clip: Clip, rig: Rig, cut: Cut, params: LoopParams) -> Closed:
    """Close a cut.

    Args:
        clip: F frames.
        rig: its root.
        cut: the cycle in it.
        params: with the method.

    Raises:
        InputError: there are too few frames for the blend.
    """
    root, travel = carrier(clip, rig), fit(clip, rig, cut.start, cut.end, params.window)
    if params.method == "kim-neff":
        return _blended(clip, rig, root, cut, travel)
    span, limit = slice(cut.start, cut.end + 1), 0.5 * (cut.end - cut.start) * clip.frame_time
    captured = clip.frames(span)
    seen = figure(captured, rig)
    far = float(np.linalg.norm(seen[-1] - travel.places(seen[0]), axis=1).max())
    below, of_root = gaps_below(clip, root, cut.start, cut.end), gaps_of_root(clip, root, cut.start, cut.end, travel)
    best: tuple[float, Closed] | None = None
    for share, slope in _TIMES:
        fade = decay(len(captured), clip.frame_time, min(share * params.blend, limit), min(slope * params.blend, limit))
        closed = _offset(captured, root, below, of_root, travel, fade)
        now = figure(closed, rig)
        moved = float(np.linalg.norm(now - seen, axis=2).max())
        ratio = ratios_of(now, travel, clip.frame_time)[1]
        swings = max(moved / far - _MOST, 0.0) if far > _NO_GAP * rig.leg_length else 0.0
        worse = _FAR * swings + max(ratio - _CALM, 0.0)  # joints that swing out, or are jolted at the seam
        if best is None or worse < best[0]:
            best = worse, Closed(closed, cut.start, travel, ratio)
        if worse == 0.0:
            break
    assert best is not None
    return best[1]


@dataclass(frozen=True, eq=False)
class Decay:
    """Fade-out of a gap of value and slope over the frames of a cycle, from both of its ends.

    The curves are cubics that begin with a value, or a slope, and end at rest at zero.

    Args:
        value_ahead, slope_ahead: (F,) remaining share of the value, and of the slope [s], after the start.
        value_behind, slope_behind: (F,) before the end.
    """

    value_ahead: Floats
    slope_ahead: Floats
    value_behind: Floats
    slope_behind: Floats

    def frames(self, which: Ints) -> Decay:
        """Take some frames only."""
        parts = (self.value_ahead, self.slope_ahead, self.value_behind, self.slope_behind)
        return Decay(*(part[which] for part in parts))

    def ahead(self, gap: Floats = _NONE, speed: Floats = _NONE) -> Floats:
        """Compute the start's offsets (..., F, 3) for gaps (..., 3) and their rates (..., 3) [1/s]."""
        return _outer(RATIO * self.value_ahead, gap) + _outer(RATIO * self.slope_ahead, speed)

    def behind(self, gap: Floats = _NONE, speed: Floats = _NONE) -> Floats:
        """Compute the end's offsets (..., F, 3), of the opposite sign."""
        rest = 1.0 - RATIO
        return _outer(rest * self.slope_behind, speed) - _outer(rest * self.value_behind, gap)


def _outer(share: Floats, vector: Floats) -> Floats:
    """Multiply shares (F,) by vectors (..., 3): (..., F, 3)."""
    return (share * vector[..., None]).swapaxes(-1, -2)


def decay(frames: int, frame_time: float, tau: float, slope: float) -> Decay:
    """Make the fade-out of a gap over `tau` [s] at each end of some frames, and of its slope over `slope` [s]."""
    time: Floats = np.asarray(np.arange(frames) * frame_time, dtype=np.float64)
    parts = []
    for since in (time, time[-1] - time):
        u, w = (np.clip(since / part, 0.0, 1.0) for part in (tau, slope))
        parts += [(1.0 - u) ** 2 * (1.0 + 2.0 * u), (1.0 - w) ** 2 * w * slope]
    return Decay(*parts)


def _offset(
    clip: Clip, root: int, below: tuple[Gap, Gap], of_root: tuple[Gap, Gap], travel: Travel, fade: Decay
) -> Clip:  # fmt: skip
    """Close gaps of position, rotation and velocity by offsets at both ends that fade out.

    A joint moves half as far as in a blend on one side. Rotations are offset by rotation vectors on the left, those of
    the root in the frame of the travel. First the poses are joined, by offsets that start with zero velocity; then
    velocities are compared, and their gap is closed in the same way.

    Args:
        clip: the L + 1 frames of the cut.
        root: what carries it (`carrier`).
        below, of_root: the gaps of places and of rotations.
        travel: of one round.
        fade: how they fade out.

    Source: D. Holden, Creating looping animations from motion capture, theorangeduck.com 2022.
    """
    some = np.flatnonzero((fade.value_ahead > 0.0) | (fade.value_behind > 0.0))
    near = fade.frames(some)
    moves, spins = below
    places = _tracks(clip.position, moves.joints)
    if moves.joints:
        places[:, some] += near.ahead(moves.value, moves.speed) + near.behind(moves.value, moves.speed)
    turns = _tracks(clip.rotation, spins.joints)
    if spins.joints:
        joined = rotation.from_rotation_vector(near.ahead(spins.value) + near.behind(spins.value))
        smooth = rotation.from_rotation_vector(near.ahead(speed=spins.speed) + near.behind(speed=spins.speed))
        turns[:, some] = rotation.multiply(smooth, rotation.multiply(joined, turns[:, some]))
    place, turn = (np.array(each, order="F") for each in root_in_world(clip, root))
    gap, speed = of_root[0].value[0], of_root[0].speed[0]
    place += fade.ahead(gap, speed) + rotation.rotate(travel.turn, fade.behind(gap, speed))
    gap, speed = of_root[1].value[0], of_root[1].speed[0]
    for kind in ({"gap": gap}, {"speed": speed}):
        behind = rotation.from_rotation_vector(rotation.rotate(travel.turn, near.behind(**kind)))
        off = rotation.multiply(rotation.from_rotation_vector(near.ahead(**kind)), behind)
        turn[some] = rotation.multiply(off, turn[some])
    moved = clip.with_joints(dict(zip(moves.joints, places, strict=True)), dict(zip(spins.joints, turns, strict=True)))
    return _exactly(with_root(moved, root, place, turn), root, travel)


def _tracks(track: Callable[[int], Floats], joints: Sequence[int]) -> Floats:
    """Copy some joints' tracks to (J, F, n), each component contiguous over frames."""
    if not joints:
        return np.zeros((0, 0, 3))
    return np.stack([track(joint).T for joint in joints]).transpose(0, 2, 1)


def _exactly(clip: Clip, root: int, travel: Travel) -> Clip:
    """Set the last frame exactly to the first, with the root moved by the travel."""
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


def _blended(clip: Clip, rig: Rig, root: int, cut: Cut, travel: Travel) -> Closed:
    """Blend the frames after the end into those after the start (K 5.2).

    The blend takes the frames left of the shorter of both plants, N_b = min(F_fs - F_s, F_fe - F_e). Its first half
    is appended to the end, its second half replaces the start: the cycle starts in mid-blend and keeps its length.

    Source: K 5.2, corrected: w rises from 0 to 1 (as printed it runs from 1 to 2, and eq. 1 and 2 need opposite
    weights), `R = (1 - w) R_a + w R_b`, `q = slerp(q_a, q_b, w)` with a after the end and b after the start; and the
    root's height is blended like its place (otherwise it would jump at the seam).
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
    closed = _exactly(with_root(out, root, *whole), root, travel)
    return Closed(closed, cut.start + half, travel, ratios(closed, rig, travel)[1])


def _root_blended(clip: Clip, root: int, a: Ints, b: Ints, w: Floats, travel: Travel) -> tuple[Floats, Floats]:
    """Blend the root after the end into that after the start, moved by one round."""
    place, turn = root_in_world(clip, root)
    place_b, turn_b = travel.places(place[b]), rotation.multiply(travel.turn, turn[b])
    return (1.0 - w)[:, None] * place[a] + w[:, None] * place_b, rotation.slerp(turn[a], turn_b, w)
