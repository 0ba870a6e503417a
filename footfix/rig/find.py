"""Finds the rig of a figure: which joints are its legs, what carries it, its soles, its size and its floor."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from footfix.errors import NoLegsError
from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats
from footfix.motion.leadin import motion_proper
from footfix.notes import Note
from footfix.rig import soles
from footfix.rig.limbs import Limb, Pair, pairs, toes
from footfix.rig.names import read
from footfix.rig.params import RigParams
from footfix.rig.rig import Leg, Rig, SolePoint
from footfix.rig.sample import Sample, sample

_LEAST = 0.9  # score below which a pair of limbs is no pair of legs


def find_rig(clip: Clip, params: RigParams | None = None) -> Rig:
    """The rig of a clip's figure, of the first one where there are several.

    Args:
        clip: metres, y up.
        params: what is known beforehand.

    Raises:
        NoLegsError: nothing in the skeleton could be a pair of legs.
        UsageError: the parameters name a joint that is not there.
    """
    return find_rigs(clip, params)[0]


def find_rigs(clip: Clip, params: RigParams | None = None) -> tuple[Rig, ...]:
    """The rigs of all figures of a clip, in the order of the file: one for each root that has legs.

    Args:
        clip: metres, y up.
        params: what is known beforehand.

    Raises:
        NoLegsError: no figure has legs.
        UsageError: the parameters name a joint that is not there.
    """
    params = params or RigParams()
    seen = sample(clip, motion_proper(clip))
    roots = np.flatnonzero(clip.skeleton.parents < 0).tolist()
    rigs = []
    for root in roots:
        pair = legs_of(seen, root)
        if pair is not None:
            rigs.append(_rig(seen, root, pair, params))
    if not rigs:
        raise no_legs(clip)
    return tuple(rigs)


def no_legs(clip: Clip) -> NoLegsError:
    """What to say about a skeleton without legs."""
    return NoLegsError(
        f"no legs found among its {len(clip.skeleton)} joints",
        hint="name them in the config under rig.legs if it has some",
    )


def legs_of(seen: Sample, root: int) -> Pair | None:
    """The pair of limbs that are the legs of a figure; None where nothing is."""
    found = pairs(seen, root)
    return found[0] if found and found[0].score >= _LEAST else None


def _rig(seen: Sample, root: int, pair: Pair, params: RigParams) -> Rig:
    toe_joints = toes(seen, pair)
    limbs, toe_joints, origin = _sided(seen, pair.limbs, toe_joints)
    legs = tuple(
        Leg(name, name, limb.hip, limb.knee, limb.ankle, toe, limb.chain)
        for name, limb, toe in zip(("left", "right"), limbs, toe_joints, strict=True)
    )
    length = 0.5 * sum(limb.length for limb in limbs)
    facing = _facing(seen, legs)
    feet = soles.alike(*(soles.foot(seen, leg.ankle, leg.toe, facing, length) for leg in legs), length)
    points = _points(legs, feet)
    level, others = _floor(seen, points, length)
    notes = []
    if others and params.floor is None:
        notes.append(
            Note(
                "floor-ambiguous",
                f"the feet rest at {level:.2f} m and at {others[0]:.2f} m; set rig.floor if the first is wrong",
                "warning",
            )
        )
    return Rig(
        root=_carrier(seen, root, pair.pelvis),
        pelvis=pair.pelvis,
        legs=legs,
        soles=points,
        leg_length=length,
        floor=level if params.floor is None else params.floor,
        notes=tuple(notes),
        origins={"sides": origin},
    )


def _sided(
    seen: Sample, limbs: Sequence[Limb], toe_joints: Sequence[int | None]
) -> tuple[list[Limb], list[int | None], str]:
    """Left before right: by name, else by the way the figure faces."""
    names = seen.skeleton.names
    sides = []
    for limb, toe in zip(limbs, toe_joints, strict=True):
        votes = [read(names[j]).side for j in (limb.branch, *limb.chain, *(() if toe is None else (toe,)))]
        sides.append("left" if votes.count("left") > votes.count("right") else "right" if "right" in votes else "")
    if set(sides) == {"left", "right"} or (any(sides) and not all(sides)):
        first_is_left = sides[0] == "left" or sides[1] == "right"
        origin = "names"
    else:
        ahead = _ahead(seen, limbs, toe_joints)
        left = np.cross(soles.UP, ahead)
        across = seen.places[:, limbs[0].hip] - seen.places[:, limbs[1].hip]
        first_is_left = float(np.einsum("fi,fi->f", left, across).mean()) >= 0.0
        origin = "geometry"
    order = (0, 1) if first_is_left else (1, 0)
    return [limbs[i] for i in order], [toe_joints[i] for i in order], origin


def _ahead(seen: Sample, limbs: Sequence[Limb], toe_joints: Sequence[int | None]) -> Floats:
    """(S, 3) roughly the way the figure faces, whatever is left and right: where toes point and knees bend."""
    ahead = np.zeros((len(seen), 3))
    for limb, toe in zip(limbs, toe_joints, strict=True):
        hip, knee, ankle = (seen.places[:, j] for j in (limb.hip, limb.knee, limb.ankle))
        ahead += knee - 0.5 * (hip + ankle)
        if toe is not None:
            ahead += 2.0 * (seen.places[:, toe] - ankle)
        else:
            for e, parent in enumerate(seen.skeleton.end_parents.tolist()):
                if parent == limb.ankle:
                    ahead += 2.0 * (seen.ends[:, e] - ankle)
    ahead[:, 1] = 0.0
    return ahead


def _facing(seen: Sample, legs: Sequence[Leg]) -> Floats:
    """(S, 3) the way the figure faces: level, from its left hip and its right hip."""
    left = np.mean([seen.places[:, leg.hip] for leg in legs if leg.side == "left"], axis=0)
    right = np.mean([seen.places[:, leg.hip] for leg in legs if leg.side == "right"], axis=0)
    facing = np.cross(left - right, soles.UP)
    return np.asarray(facing / np.maximum(np.linalg.norm(facing, axis=-1, keepdims=True), 1e-12))


def _points(legs: Sequence[Leg], feet: Sequence[soles.Foot]) -> tuple[SolePoint, ...]:
    points = []
    for index, (leg, foot) in enumerate(zip(legs, feet, strict=True)):
        heel = -foot.ankle_height * foot.up - foot.behind * foot.ahead
        points.append(SolePoint(f"{leg.name}_heel", index, "heel", leg.ankle, _triple(heel)))
        if leg.toe is not None and foot.up_at_toe is not None:
            points.append(
                SolePoint(f"{leg.name}_toe", index, "toe", leg.toe, _triple(-foot.ball_height * foot.up_at_toe))
            )
        else:
            ball = -foot.ankle_height * foot.up + foot.reach * foot.ahead
            points.append(SolePoint(f"{leg.name}_toe", index, "toe", leg.ankle, _triple(ball)))
    return tuple(points)


def _triple(vector: Floats) -> tuple[float, float, float]:
    x, y, z = (float(v) for v in vector)
    return x, y, z


def _floor(seen: Sample, points: Sequence[SolePoint], leg: float) -> tuple[float, tuple[float, ...]]:
    heights, speeds = [], []
    for point in points:
        arm = rotation.rotate(seen.turns[:, point.joint], np.asarray(point.offset))
        heights.append(seen.places[:, point.joint, 1] + arm[:, 1])
        speeds.append(np.linalg.norm(seen.velocities[:, point.joint], axis=-1))
    return soles.floor(np.stack(heights, axis=1), np.stack(speeds, axis=1), leg)


def _carrier(seen: Sample, root: int, pelvis: int) -> int:
    """The joint nearest to the pelvis that translates the whole figure."""
    skeleton = seen.skeleton
    figure = _count_below(seen, root)
    way = skeleton.ancestors(pelvis)
    able = [
        joint
        for joint in way
        if skeleton.translates[joint] and _count_below(seen, joint) + len(skeleton.ancestors(joint)) > 0.8 * figure
    ]
    travel = {joint: float(np.ptp(seen.local[:, joint], axis=0).max()) for joint in able}
    moving = [
        joint for joint in able if travel[joint] > 1e-3 * max(travel.values(), default=0.0) and travel[joint] > 0.0
    ]
    return (moving or able or [way[-1]])[0]


def _count_below(seen: Sample, joint: int) -> int:
    below = {joint}
    for other in range(joint + 1, len(seen.skeleton)):
        if int(seen.skeleton.parents[other]) in below:
            below.add(other)
    return len(below)



