"""Fit a skin to the skeleton of a clip: match joints, scale the skin, and place its soles.

The skeleton may be the skin's own, or another figure's with other names, other bone frames and other bone lengths.
They have only places of joints in common: so a foot is placed from ankle to toe joint, with its sole level where the
clip's foot stands flat, and scaled by the length of the legs.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from footfix.errors import InputError
from footfix.motion import rotation
from footfix.motion.clip import Floats, Ints
from footfix.notes import Note
from footfix.rig.foot_mesh import FootMesh
from footfix.rig.frame_sample import Sample
from footfix.rig.names import bare
from footfix.rig.rig import Leg, SolePoint
from footfix.rig.skin import Skin, SkinFoot, SkinLeg, feet_of, legs_of, stands_on_toes
from footfix.rig.skin_bone_frames import shared_frames
from footfix.rig.skin_vertices import LOW, kept, outline, spread, toes
from footfix.rig.soles import SoleEstimate

_MISMATCH = 0.05  # share by which the feet of skin and clip may differ


@dataclass(frozen=True, eq=False)
class Fitted:
    """The feet of a skin on a clip.

    Args:
        meshes: of each leg.
        points: heel and toe of each leg.
        on_toes: of each leg whether it stands on its toes, so that its heel bears no weight.
        notes: what does not fit.
        name: of the skin, for messages.
        how: how the two skeletons were matched, for messages.
    """

    meshes: tuple[FootMesh, ...]
    points: tuple[SolePoint, ...]
    on_toes: tuple[bool, ...]
    notes: tuple[Note, ...]
    name: str
    how: str

    def watched(self, points: Sequence[SolePoint], without: Sequence[SolePoint]) -> tuple[SolePoint, ...]:
        """Give the sole points of legs that stand on their toes as they are without a skin, the others as with it."""
        both = zip(points, without, strict=True)
        return tuple(plain if self.on_toes[own.leg] else own for own, plain in both)


def fit_skin(skin: Skin, seen: Sample, legs: Sequence[Leg], feet: Sequence[SoleEstimate]) -> Fitted:
    """Put a skin's feet on the legs of a clip.

    Args:
        skin: the character.
        seen: frames of the clip [m], y up.
        legs: of the clip.
        feet: how each of its feet lies when it is flat.

    Raises:
        InputError: the skin has no such legs, or its feet move no vertices.
    """
    names = seen.skeleton.names
    named = _by_names(skin, names, legs)
    own = named or _by_shape(skin, legs)
    soles = feet_of(skin, own)
    if not soles[0].length > 0.0:
        raise InputError("its legs have no length", file=skin.name)
    # Straight from hip to knee to ankle in both, whatever joints lie between.
    lengths = [seen.distance(leg.hip, leg.knee) + seen.distance(leg.knee, leg.ankle) for leg in legs]
    scale = float(np.mean(lengths)) / soles[0].length
    how = "joint names" if named else "the shape of its legs"
    frames = shared_frames(skin, seen, legs, own, feet, soles, named=bool(named))
    meshes, points, notes = [], [], list[Note]()
    for k, (leg, foot, sole) in enumerate(zip(legs, feet, soles, strict=True)):
        if frames is None:
            bound = _by_places(skin, sole, leg, foot, scale)
        else:
            bound = _by_frames(skin, sole, leg, frames, names, scale, named=bool(named))
        meshes.append(_mesh(k, sole, bound, scale))
        points += _points(k, leg, bound)
    notes += [_told(skin, soles, scale), *_mismatch(skin, seen, legs, soles, scale)]
    on_toes = tuple(
        stands_on_toes(float(skin.places[sole.leg.ankle] @ sole.up) - sole.level, sole.length) for sole in soles
    )
    return Fitted(tuple(meshes), tuple(points), on_toes, tuple(notes), skin.name, how)


def _by_names(skin: Skin, names: Sequence[str], legs: Sequence[Leg]) -> tuple[SkinLeg, ...] | None:
    """Match joints by name, ignoring namespace and case; None where some are missing or ambiguous."""
    folded = [bare(name).casefold() for name in skin.names]

    def find(joint: int) -> int | None:
        hits = [k for k, name in enumerate(folded) if name == bare(names[joint]).casefold()]
        # Nodes below a joint of the same name are meshes that move with it.
        return hits[0] if hits and skin.below(hits[0])[hits].all() else None

    found = []
    for leg in legs:
        hip, knee, ankle = (find(joint) for joint in (leg.hip, leg.knee, leg.ankle))
        if hip is None or knee is None or ankle is None or len({hip, knee, ankle}) < 3:
            return None
        found.append(SkinLeg(leg.name, hip, knee, ankle, None if leg.toe is None else find(leg.toe)))
    return tuple(found)


def _by_shape(skin: Skin, legs: Sequence[Leg]) -> tuple[SkinLeg, ...]:
    """Match legs by side and end of the body."""
    found = {leg.name: leg for leg in legs_of(skin)}
    if any(leg.name not in found for leg in legs):
        mine, its = ", ".join(leg.name for leg in legs), ", ".join(found)
        raise InputError(f"the clip's legs are {mine}, the skin's are {its}", file=skin.name)
    return tuple(found[leg.name] for leg in legs)


@dataclass(frozen=True, eq=False)
class _Bound:
    """The vertices of a foot in the frames of the clip's joints: (V, k), (V, k), (V, k, 3); and its places likewise."""

    joints: Ints
    weights: Floats
    offsets: Floats
    heel: Floats  # (3,) in the ankle's frame
    ball: Floats  # (3,) in the frame of the toe joint, or of the ankle where there is none


def _by_frames(
    skin: Skin, sole: SkinFoot, leg: Leg, axes: Floats, names: Sequence[str], scale: float, *, named: bool
) -> _Bound:
    """Bind a foot whose joints have the same frames in skin and clip (axes, (J, 3, 3)): as it is bound in the skin."""
    to = _joints_in_clip(skin, sole.leg, leg, names, named=named)
    own = np.flatnonzero(skin.moved_by(skin.below(sole.leg.ankle)) > 0.5)
    which, weights = skin.joints[own], np.where(to[skin.joints[own]] >= 0, skin.weights[own], 0.0)
    keep = np.maximum(weights.sum(axis=1, keepdims=True), 1e-9)

    def seen_from(joint: int, points: Floats) -> Floats:
        return np.asarray(scale * (points - skin.places[joint]) @ axes[joint])

    # A joint that the clip does not have goes with the nearest one above it that it has.
    anchors = _anchors(skin, to)
    offsets = np.zeros((*which.shape, 3))
    for joint in np.unique(which[weights > 0.0]).tolist():
        rows = np.nonzero(which == joint)
        offsets[rows] = seen_from(anchors[joint], skin.vertices[own[rows[0]]])
    toe = sole.leg.ankle if leg.toe is None or sole.leg.toe is None else sole.leg.toe
    joints = np.where(to[which] >= 0, to[which], leg.ankle)
    return _Bound(
        joints, weights / keep, offsets, seen_from(sole.leg.ankle, sole.heel), seen_from(toe, sole.ball)
    )


def _joints_in_clip(skin: Skin, own: SkinLeg, leg: Leg, names: Sequence[str], *, named: bool) -> Ints:
    """Find the clip's joint that each of the skin's joints (J,) is or hangs on; -1 above the ankle or where unknown."""
    folded = [bare(name).casefold() for name in names]
    known = {own.ankle: leg.ankle}
    if own.toe is not None and leg.toe is not None:
        known[own.toe] = leg.toe
    if named:
        for joint, name in enumerate(skin.names):
            if folded.count(bare(name).casefold()) == 1:
                known.setdefault(joint, folded.index(bare(name).casefold()))
    to = np.full(len(skin.names), -1, np.intp)
    for joint, parent in enumerate(skin.parents.tolist()):
        to[joint] = known.get(joint, to[parent] if parent >= 0 else -1)
    return to


def _anchors(skin: Skin, to: Ints) -> list[int]:
    """Find for each joint of the skin the topmost one, itself or above it, that hangs on the same joint of the clip."""
    found: list[int] = []
    for joint, parent in enumerate(skin.parents.tolist()):
        found.append(found[parent] if parent >= 0 and to[joint] == to[parent] else joint)
    return found


def _by_places(skin: Skin, sole: SkinFoot, leg: Leg, foot: SoleEstimate, scale: float) -> _Bound:
    """Bind a foot by where its ankle and toe joint are: level and straight ahead where the clip's foot lies flat."""
    ankle = skin.places[sole.leg.ankle]
    reach = None if sole.leg.toe is None else scale * float((skin.places[sole.leg.toe] - ankle) @ sole.ahead)
    own = None if foot.ball is None else float(foot.ball @ foot.ahead)
    longer = 0.0 if reach is None or own is None else own - reach

    def in_ankle(points: Floats) -> Floats:
        """Place points (N, 3) in the frame of the clip's ankle, stretched to its foot's length up to the toe joint."""
        from_it = scale * (points - ankle)
        along, across, high = from_it @ sole.ahead, from_it @ sole.left, from_it @ sole.up
        if reach is not None and reach > 0.0:
            along = along + longer * np.clip(along / reach, 0.0, 1.0)
        left = np.cross(foot.up, foot.ahead)
        return np.asarray(np.outer(along, foot.ahead) + np.outer(across, left) + np.outer(high, foot.up))

    at_ankle = in_ankle(sole.vertices)
    heel, ball = in_ankle(np.stack([sole.heel, sole.ball]))
    if leg.toe is None or foot.ball is None or foot.toe_turn is None:
        ones = np.ones((len(at_ankle), 1))
        return _Bound(np.full(ones.shape, leg.ankle, np.intp), ones, at_ankle[:, None], heel, ball)
    ahead_of_it = at_ankle @ foot.ahead > float(foot.ball @ foot.ahead)
    share = sole.share if sole.leg.toe is not None else ahead_of_it.astype(np.float64)
    turn = rotation.inverse(foot.toe_turn)
    at_toe = rotation.rotate(turn, at_ankle - foot.ball)
    if sole.leg.toe is None:
        ball = _below(foot, heel)
    joints = np.broadcast_to(np.array([leg.ankle, leg.toe], np.intp), (len(share), 2))
    weights, offsets = np.stack([1.0 - share, share], axis=1), np.stack([at_ankle, at_toe], axis=1)
    return _Bound(joints, weights, offsets, heel, rotation.rotate(turn, ball - foot.ball))


def _below(foot: SoleEstimate, heel: Floats) -> Floats:
    """Find the place at the heel's level below the toe joint, in the ankle's frame."""
    assert foot.ball is not None
    return np.asarray(foot.ball + float((heel - foot.ball) @ foot.up) * foot.up)


def _mesh(number: int, sole: SkinFoot, bound: _Bound, scale: float) -> FootMesh:
    """Keep of a foot the vertices that can be its lowest, and those of its sole."""
    part = toes(sole)
    chosen = kept(sole, part)
    number_of = {int(v): k for k, v in enumerate(chosen.tolist())}
    low = sole.vertices @ sole.up - sole.level < LOW * sole.length
    outlines = tuple(
        tuple(number_of[v] for v in outline(sole, np.flatnonzero(low & own)))
        for own in (sole.share <= 0.5, sole.share > 0.5)
    )  # fmt: skip
    whole = np.zeros(len(sole.vertices), np.bool_)
    whole[spread(sole)] = True
    return FootMesh(
        number, bound.joints[chosen], bound.weights[chosen], bound.offsets[chosen], whole[chosen], part[chosen],
        outlines,
    )  # fmt: skip


def _points(number: int, leg: Leg, bound: _Bound) -> list[SolePoint]:
    def triple(vector: Floats) -> tuple[float, float, float]:
        return float(vector[0]), float(vector[1]), float(vector[2])

    toe = leg.ankle if leg.toe is None else leg.toe
    return [
        SolePoint(f"{leg.name}_heel", number, "heel", leg.ankle, triple(bound.heel)),
        SolePoint(f"{leg.name}_toe", number, "toe", toe, triple(bound.ball)),
    ]


def _told(skin: Skin, soles: Sequence[SkinFoot], scale: float) -> Note:
    """Say where heel, ball and tip of each foot are, and how thick its sole is there."""
    feet = []
    for sole in soles:
        ankle, toe = skin.places[sole.leg.ankle], None if sole.leg.toe is None else skin.places[sole.leg.toe]
        front = ankle if toe is None else toe
        unit = 1000.0 * scale  # mm of the clip's figure
        back, ahead = unit * float((ankle - sole.heel) @ sole.ahead), unit * float((sole.tip - front) @ sole.ahead)
        thick, low = unit * sole.thickness(sole.heel, ankle), unit * sole.thickness(sole.ball, front)
        at = "the ankle" if toe is None else "the toe joint"
        feet.append(
            f"{sole.leg.name.replace('_', ' ')}: heel {back:.0f} mm behind and {thick:.0f} mm below the ankle, "
            f"ball {low:.0f} mm below {at}, tip {ahead:.0f} mm ahead of it"
        )
    return Note("skin-soles", f"soles of {skin.name}: {'; '.join(feet)}")


def _mismatch(
    skin: Skin, seen: Sample, legs: Sequence[Leg], soles: Sequence[SkinFoot], scale: float
) -> tuple[Note, ...]:  # fmt: skip
    """Say how much longer the feet of the clip are than those of the skin, where that is more than it may be."""
    ratios = []
    for leg, sole in zip(legs, soles, strict=True):
        if leg.toe is not None and sole.leg.toe is not None:
            its = float(np.linalg.norm(skin.places[sole.leg.toe] - skin.places[sole.leg.ankle]))
            ratios.append(seen.distance(leg.ankle, leg.toe) / max(scale * its, 1e-9))
    ratio = float(np.mean(ratios)) if ratios else 1.0
    if abs(ratio - 1.0) <= _MISMATCH:
        return ()
    text = (
        f"the clip's feet are {abs(100.0 * (ratio - 1.0)):.0f} % {'longer' if ratio > 1.0 else 'shorter'} from ankle "
        f"to toe joint than those of {skin.name}, scaled by the length of its legs; its soles may not be this figure's"
    )
    return (Note("skin-mismatch", text, "warning"),)
