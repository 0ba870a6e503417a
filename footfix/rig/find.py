"""Find the rig of a figure: its root, legs, soles, size and floor."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Literal

import numpy as np

from footfix.errors import InputError, UsageError
from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats
from footfix.motion.kinematics import Pose
from footfix.motion.lead_in import motion_range
from footfix.notes import Note
from footfix.rig import soles
from footfix.rig.foot_mesh import FootMesh
from footfix.rig.frame_sample import Sample, sample
from footfix.rig.leg_assignment import Figure, figures, joint
from footfix.rig.params import RigParams, SoleParams
from footfix.rig.rig import Leg, Rig, SolePoint
from footfix.rig.skin import Skin
from footfix.rig.skin_fit import Fitted, fit_skin
from footfix.rig.zero_plane import on_zero_plane, skin_on_zero_plane


def find_rig(
    clip: Clip, params: RigParams | None = None, frame_range: slice | None = None, skin: Skin | None = None
) -> Rig:  # fmt: skip
    """Find the rig of a clip's figure; of the first one where there are several.

    Args:
        clip: metres, y up.
        params: what is known beforehand.
        frame_range: the frames that are motion; found where they are not given.
        skin: a character whose feet these are, for its soles.

    Raises:
        NoLegsError: nothing in the skeleton could be a pair of legs.
        UsageError: the parameters name a joint that is not there.
    """
    return find_rigs(clip, params, frame_range, skin)[0]


def find_rigs(
    clip: Clip, params: RigParams | None = None, frame_range: slice | None = None, skin: Skin | None = None
) -> tuple[Rig, ...]:  # fmt: skip
    """Find the rigs of all figures of a clip, in the order of the file: one for each root that has legs.

    Args:
        clip: metres, y up.
        params: what is known beforehand.
        frame_range: the frames that are motion; found where they are not given.
        skin: a character whose feet these are, for the soles of each figure.

    Raises:
        NoLegsError: no figure has legs.
        UsageError: the parameters name a joint that is not there.
    """
    params = params or RigParams()
    seen = sample(clip, motion_range(clip) if frame_range is None else frame_range)
    found = figures(seen, params, y_up=True)
    return tuple(_rig(seen, figure, params, skin).of_figure(number) for number, figure in enumerate(found, start=1))


def _rig(seen: Sample, figure: Figure, params: RigParams, skin: Skin | None = None) -> Rig:
    legs, sides_origin = _legs(seen, figure)
    facing = _facing(seen, legs)
    on_four = any(leg.name.startswith("front") for leg in legs)
    feet = [
        soles.paw(seen, leg.ankle, figure.length)
        if on_four
        else soles.foot(seen, leg.ankle, leg.toe, facing, figure.length)
        for leg in legs
    ]
    feet = soles.alike(feet, [leg.name.removesuffix(leg.side) for leg in legs])
    seek_zero = not on_four and params.floor in (None, "zero")
    joints = [(leg.ankle, leg.toe) for leg in legs]
    measured = on_zero_plane(seen, feet, joints, figure.length) if seek_zero else None
    feet = feet if measured is None else list(measured)
    fitted, unfit = (None, ()) if skin is None else _fitted(skin, seen, legs, feet, named=params.skin is not None)
    points, given = _points(seen, legs, feet, params.soles, () if fitted is None else fitted.points)
    level, others, floor_origin = _floor(
        seen, points, figure.length, params.floor, on_zero=measured is not None and fitted is None,
        meshes=() if fitted is None else fitted.meshes,
    )  # fmt: skip
    root = _carrier(seen, figure) if params.root is None else _given_root(seen, params.root)
    origins = {
        "root": "geometry" if params.root is None else "config",
        "legs": figure.origin,
        "sides": sides_origin,
        "floor": floor_origin,
    }
    for index, (leg, foot) in enumerate(zip(legs, feet, strict=True)):
        origins |= {f"leg.{leg.name}.{part}": figure.origin for part in ("hip", "knee", "ankle", "toe")}
        for point in points:
            if point.leg == index:
                found = foot.origin if fitted is None else f"the skin of {fitted.name}, by {fitted.how}"
                origins[f"sole.{point.name}"] = "config" if point.name in given else found
    return Rig(
        root=root,
        pelvis=figure.pelvis,
        legs=legs,
        soles=points,
        leg_length=figure.length,
        floor=level,
        notes=_notes(legs, feet, level, others, given) + unfit + _fixed(seen, root),
        origins=origins,
        meshes=() if fitted is None else fitted.meshes,
        watched=() if fitted is None else fitted.watched(points, _points(seen, legs, feet, params.soles)[0]),
    )


def _fitted(
    skin: Skin, seen: Sample, legs: Sequence[Leg], feet: Sequence[soles.SoleEstimate], *, named: bool
) -> tuple[Fitted | None, tuple[Note, ...]]:
    """Fit the feet of a skin to the legs; note what does not fit, as a warning where the user named the skin."""
    try:
        fitted = fit_skin(skin, seen, legs, feet)
    except InputError as error:
        text = f"the skin of {skin.name} is not used: {error.what}"
        return None, (Note("skin-not-used", text, "warning" if named else "note"),)
    return fitted, fitted.notes


def _notes(
    legs: Sequence[Leg], feet: Sequence[soles.SoleEstimate], level: float, others: Sequence[float], given: set[str]
) -> tuple[Note, ...]:
    notes = []
    if others:
        high = " and ".join(f"{other:.2f}" for other in others[:3])
        text = f"the feet rest at {level:.2f} m, taken as the floor, and at {high} m; set rig.floor if that is wrong"
        notes.append(Note("floor-ambiguous", text))
    unknown = [
        leg.name
        for leg, foot in zip(legs, feet, strict=True)
        if "length" in foot.guessed and f"{leg.name}_toe" not in given
    ]
    if unknown:
        text = "the skeleton ends at the ankle, so where heel and ball are is guessed; rig.soles can say it"
        notes.append(Note("feet-without-toes", text))
    return tuple(notes)


def _legs(seen: Sample, figure: Figure) -> tuple[tuple[Leg, ...], str]:
    """Name the legs and tell their sides, left before right in each pair; say how sides were found."""
    sides, origin = list(figure.sides), figure.origin if figure.origin == "config" else "names"
    left = _leftwards(seen, figure)
    for pair in _pairs(figure):
        own = [sides[i] for i in pair]
        if len(pair) == 2 and sorted(own) == ["left", "right"]:
            continue
        if len(pair) == 2 and own.count("") == 1:
            known = next(side for side in own if side)
            for i in pair:
                sides[i] = sides[i] or ("right" if known == "left" else "left")
        elif len(pair) == 2:
            one, other = (seen.places[:, figure.limbs[i].hip] for i in pair)
            first_left = float(np.einsum("fi,fi->f", left, one - other).sum()) >= 0.0
            sides[pair[0]], sides[pair[1]] = ("left", "right") if first_left else ("right", "left")
            origin = "geometry"
    order = [i for pair in _pairs(figure) for i in sorted(pair, key=lambda i: sides[i] == "right")]
    legs = []
    for i in order:
        limb, toe, side = figure.limbs[i], figure.toes[i], sides[i]
        given = figure.origin == "config"
        name = figure.names[i] if given else f"{figure.names[i]}_{side}" if figure.names[i] else side
        legs.append(Leg(name, side or name, limb.hip, limb.knee, limb.ankle, toe, limb.chain))
    return tuple(legs), origin


def _pairs(figure: Figure) -> list[list[int]]:
    """List the indices of legs that make a pair: found ones come in pairs, given ones where there are just two."""
    count = len(figure.limbs)
    if figure.origin == "config" and count != 2:
        return [[i] for i in range(count)]
    return [[i, i + 1] for i in range(0, count, 2)]


def _leftwards(seen: Sample, figure: Figure) -> Floats:
    """Estimate a figure's left (S, 3) from how knees bend and where toes point.

    The axis of a knee runs from one side to the other, and so does what is across both the shin and the foot;
    that holds in any posture, and needs no up.
    """
    left = np.zeros((len(seen), 3))
    for limb, toe in zip(figure.limbs, figure.toes, strict=True):
        hip, knee, ankle = (seen.places[:, j] for j in (limb.hip, limb.knee, limb.ankle))
        left += np.cross(ankle - knee, hip - knee)
        tips = soles.tips(seen, limb.ankle) if toe is None else [seen.places[:, toe]]
        for tip in tips:
            left += (2.0 / len(tips)) * np.cross(knee - ankle, tip - ankle)
    return left


def _facing(seen: Sample, legs: Sequence[Leg]) -> Floats:
    """Compute the horizontal direction (S, 3) that the figure faces, from its left and right hip."""
    hips = {side: [seen.places[:, leg.hip] for leg in legs if leg.side == side] for side in ("left", "right")}
    if not all(hips.values()):
        return np.tile([0.0, 0.0, 1.0], (len(seen), 1))
    facing = np.cross(np.mean(hips["left"], axis=0) - np.mean(hips["right"], axis=0), soles.UP)
    return np.asarray(facing / np.maximum(np.linalg.norm(facing, axis=-1, keepdims=True), 1e-12))


def _points(
    seen: Sample, legs: Sequence[Leg], feet: Sequence[soles.SoleEstimate], given: Mapping[str, SoleParams],
    from_skin: Sequence[SolePoint] = (),
) -> tuple[tuple[SolePoint, ...], set[str]]:
    """Place heel and toe of each leg; list the names of those that the config placed."""
    points = []
    for index, (leg, foot) in enumerate(zip(legs, feet, strict=True)):
        heel = -foot.ankle_height * foot.up - foot.behind * foot.ahead
        points.append(SolePoint(f"{leg.name}_heel", index, "heel", leg.ankle, _triple(heel)))
        if leg.toe is not None and foot.up_at_toe is not None:
            carrier, ball = leg.toe, -foot.ball_height * foot.up_at_toe
        else:
            carrier, ball = leg.ankle, -foot.ankle_height * foot.up + foot.reach * foot.ahead
        points.append(SolePoint(f"{leg.name}_toe", index, "toe", carrier, _triple(ball)))
    points = list(from_skin) or points
    names = [point.name for point in points]
    for name, sole in given.items():
        if name not in names:
            raise UsageError(f"rig.soles.{name} is no sole point of this rig; it has {', '.join(names)}")
        at = names.index(name)
        carrier = joint(seen.skeleton, sole.joint, f"rig.soles.{name}.joint") if sole.joint else points[at].joint
        points[at] = replace(points[at], joint=carrier, offset=_triple(np.asarray(sole.offset, dtype=np.float64)))
    return tuple(_with_held(point, legs[point.leg], feet[point.leg]) for point in points), set(given)


def _with_held(point: SolePoint, leg: Leg, foot: soles.SoleEstimate) -> SolePoint:
    """Place what plants hold over the sole point of a toe, where a toe joint would be; as it is where there is one."""
    if point.part == "heel" or leg.toe is not None or point.joint != leg.ankle:
        return point
    return replace(point, held=_triple(np.array(point.offset) + foot.ball_height * foot.up))


def _triple(vector: Floats) -> tuple[float, float, float]:
    return float(vector[0]), float(vector[1]), float(vector[2])


def _floor(
    seen: Sample, points: Sequence[SolePoint], leg: float, asked: float | Literal["zero"] | None, *, on_zero: bool,
    meshes: Sequence[FootMesh],
) -> tuple[float, tuple[float, ...], str]:  # fmt: skip
    """Find the height of the floor [m] and that of other levels on which soles often rest; say how it was found."""
    if asked is not None:
        return (0.0 if asked == "zero" else asked), (), "config"
    heights, velocities = _lowest(seen, points)
    if meshes:  # a foot may lie on its side, or on its back
        pose = Pose(tuple(range(len(seen.skeleton))), seen.places, seen.turns)
        heights = np.stack([mesh.lowest(pose) for mesh in meshes], axis=1)
    level, others = soles.floor(heights, velocities, leg, soles.MESH_OVER_LOW if meshes else soles.OVER_LOW)
    if on_zero:
        return 0.0, others, "the file's zero plane, on which the toes rest"
    if meshes and skin_on_zero_plane(heights, velocities, level, leg):
        return 0.0, (), "the file's zero plane, on which the soles of the skin rest"
    return level, others, "where the soles rest most"


def _lowest(seen: Sample, points: Sequence[SolePoint]) -> tuple[Floats, Floats]:
    """Find the height of each leg's lower sole point, (S, L) [m], and how its joint moves, (S, L, 3) [m/s]."""
    lowest, velocities = [], []
    for index in {point.leg for point in points}:
        own = [point for point in points if point.leg == index]
        tracks = [
            seen.places[:, point.joint] + rotation.rotate(seen.turns[:, point.joint], np.asarray(point.offset))
            for point in own
        ]
        heights = np.stack([track[:, 1] for track in tracks], axis=1)
        which = np.argmin(heights, axis=1)  # on tiptoe the heel is at rest too, but not on the floor
        rows = np.arange(len(seen))
        lowest.append(heights[rows, which])
        velocities.append(seen.velocities[:, [point.joint for point in own]][rows, which])
    return np.stack(lowest, axis=1), np.stack(velocities, axis=1)


def _fixed(seen: Sample, root: int) -> tuple[Note, ...]:
    if seen.skeleton.translates[root]:
        return ()
    name = seen.skeleton.names[root]
    text = f"{name} has no position channels and nothing above it has, so the figure can't be moved as a whole"
    return (Note("root-fixed", text, joints=(name,)),)


def _given_root(seen: Sample, name: str) -> int:
    root = joint(seen.skeleton, name, "rig.root")
    if not seen.skeleton.translates[root]:
        able = [own for own, moves in zip(seen.skeleton.names, seen.skeleton.translates, strict=True) if moves]
        raise UsageError(
            f"rig.root: {name} has no position channels to move it by; {', '.join(able[:5]) or 'none'} can be"
        )
    return root


def _carrier(seen: Sample, figure: Figure) -> int:
    """Find the joint nearest to the pelvis that translates the whole figure, and not its legs alone."""
    legs = {joint for limb in figure.limbs for joint in seen.below(limb.branch)}
    rest = set(seen.below(figure.root)) - legs
    way = seen.skeleton.ancestors(figure.pelvis)
    able = [
        joint
        for place, joint in enumerate(way)
        if seen.skeleton.translates[joint] and len(rest & set(seen.below(joint))) + len(way) - place > 0.5 * len(rest)
    ]
    moving = [joint for joint in able if seen.travel[joint] > 0.005 * figure.length]
    return (moving or able or [figure.root])[0]
