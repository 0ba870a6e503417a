"""A character's skin in its bind pose, and the sole of each of its feet (L §3.1).

Lyard and Magnenat-Thalmann take the vertices that the feet move, and of these the ones whose normals point down. The
file does not say which way is down: a mesh may be modelled z up, in centimetres, and the rest pose of its joints may be
in mid-step. So down is found from the bind pose, in which figures stand.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from footfix.errors import InputError
from footfix.motion.clip import Bools, Clip, Floats, Ints, Skeleton, frozen
from footfix.rig.frame_sample import sample
from footfix.rig.leg_assignment import Figure, figures
from footfix.rig.names import read
from footfix.rig.params import RigParams

_MOVED = 0.5  # least weight of a foot's joints on a vertex of the foot
_DOWN = 0.7  # least cosine between a normal of the sole and down
_RIM = 0.3  # the same for the rim of the sole, whose normals are between those of the sole and the sides
_LAYER = 0.012  # [leg lengths] height of the sole's vertices over the lowest one: 1 cm for an adult
_FEWEST = 3  # least number of vertices of a sole
_PAW = 0.05  # a paw stands on at least this share of its vertices, the lowest ones
_ON_TOES = 0.2  # [leg lengths] height of an ankle above which no foot lies flat
_BAND = 0.02  # [leg lengths] around a place, whose vertices give the thickness of the sole there
_STILL = 4  # frames of the bind pose as a clip, enough to recognise an animal on four legs
_UPRIGHT = float(np.cos(np.radians(35.0)))  # an axis of the mesh within 35 degrees of ankles to hips is up


@dataclass(frozen=True, eq=False)
class Skin:
    """All meshes of a character in their bind pose, in one space.

    Args:
        name: of its file, for messages.
        names, parents: (J,) its joints; a parent stands before its children, -1 above roots.
        frames: (J, 4, 4) each joint's place and orientation.
        vertices, normals: (V, 3).
        joints: (V, k) which joints move each vertex.
        weights: (V, k) by how much; they add up to 1.
    """

    name: str
    names: tuple[str, ...]
    parents: Ints
    frames: Floats
    vertices: Floats
    normals: Floats
    joints: Ints
    weights: Floats

    def __post_init__(self) -> None:
        for key in ("frames", "vertices", "normals", "weights"):
            object.__setattr__(self, key, frozen(getattr(self, key)))
        for key in ("parents", "joints"):
            object.__setattr__(self, key, frozen(getattr(self, key), np.intp))

    @property
    def places(self) -> Floats:
        """Get the joints' places (J, 3)."""
        return self.frames[:, :3, 3]

    @cached_property
    def turns(self) -> Floats:
        """Get the joints' axes (J, 3, 3) as columns, without scale."""
        axes = self.frames[:, :3, :3]
        return np.asarray(axes / np.maximum(np.linalg.norm(axes, axis=1, keepdims=True), 1e-12))

    def below(self, joint: int) -> Bools:
        """Mark a joint and all joints below it, (J,)."""
        found: Bools = np.asarray(np.arange(len(self.names)) == joint)
        for other in range(joint + 1, len(self.names)):
            found[other] |= self.parents[other] >= 0 and found[self.parents[other]]
        return found

    def moved_by(self, joints: Bools) -> Floats:
        """Add up the weights of joints (J,) on each vertex, (V,)."""
        return np.asarray(np.where(joints[self.joints], self.weights, 0.0).sum(axis=1))


@dataclass(frozen=True)
class SkinLeg:
    """One leg of a skin, by joint index; `toe` is None where it has none. `name` is "left", "hind_left" and so on."""

    name: str
    hip: int
    knee: int
    ankle: int
    toe: int | None

    def length(self, skin: Skin) -> float:
        """Measure hip to knee to ankle, in the skin's units."""
        hip, knee, ankle = (skin.places[joint] for joint in (self.hip, self.knee, self.ankle))
        return float(np.linalg.norm(knee - hip) + np.linalg.norm(ankle - knee))


@dataclass(frozen=True, eq=False)
class SkinFoot:
    """One foot of a skin as it stands, in the skin's space and units.

    Args:
        leg: its joints.
        length: of its leg.
        up, ahead: unit vectors.
        level: height of its lowest vertex along `up`.
        vertices: (V, 3) that its joints move.
        share: (V,) the part of the toe joint (and all below it) in that, 0 to 1.
        sole: (V,) which of them are its sole.
        heel, ball, tip: (3,) the rearmost place of the sole, the one under the toe joint, and the foremost.
    """

    leg: SkinLeg
    length: float
    up: Floats
    ahead: Floats
    level: float
    vertices: Floats
    share: Floats
    sole: Bools
    heel: Floats
    ball: Floats
    tip: Floats

    @property
    def left(self) -> Floats:
        """Get the unit vector across the foot."""
        return np.cross(self.up, self.ahead)

    def thickness(self, place: Floats, joint: Floats) -> float:
        """Measure how far a place of the sole lies below a joint, both (3,)."""
        return float((joint - place) @ self.up)


def legs_of(skin: Skin) -> tuple[SkinLeg, ...]:
    """Find the legs of a skin by the shape and the names of its joints.

    Raises:
        InputError: nothing in it could be a pair of legs.
    """
    first = figures(sample(_as_clip(skin, np.eye(3))), RigParams(), y_up=False)[0]
    hips = np.mean([skin.places[limb.hip] - skin.places[limb.ankle] for limb in first.limbs], axis=0)
    turned = _as_clip(skin, _to_y(_nearest_axis(hips)))
    return _legs(skin, figures(sample(turned), RigParams(), y_up=True)[0], turned)


def _as_clip(skin: Skin, turn: Floats) -> Clip:
    """Make a clip that stands still in the bind pose, turned by (3, 3)."""
    places = skin.places @ turn.T
    offsets = np.where((skin.parents < 0)[:, None], places, places - places[np.maximum(skin.parents, 0)])
    turns = np.zeros((_STILL, len(offsets), 4))
    turns[..., 3] = 1.0
    return Clip(Skeleton(skin.names, skin.parents, offsets), np.stack([offsets] * _STILL), turns, 1.0 / 30.0)


def _legs(skin: Skin, figure: Figure, clip: Clip) -> tuple[SkinLeg, ...]:
    """Name the legs of a figure; where joint names say nothing, sides follow from the direction of toes and knees."""
    found = []
    for k, (limb, toe, end) in enumerate(zip(figure.limbs, figure.toes, figure.names, strict=True)):
        side = figure.sides[k] or next((s for s in (read(skin.names[j]).side for j in limb.chain) if s), "")
        if not side:
            side = _side_of(figure, k, clip)
        found.append(SkinLeg(f"{end}_{side}" if end else side, limb.hip, limb.knee, limb.ankle, toe))
    return tuple(found)


def _side_of(figure: Figure, which: int, clip: Clip) -> str:
    places = np.asarray(sample(clip).places[0])
    mine, other = figure.limbs[which], figure.limbs[which ^ 1]
    ahead = np.zeros(3)
    for limb, toe in zip(figure.limbs, figure.toes, strict=True):
        tips = [toe] if toe is not None else [j for j in range(len(places)) if clip.skeleton.parents[j] == limb.ankle]
        for tip in tips:
            ahead = ahead + (places[tip] - places[limb.ankle]) / len(tips)
    left = np.cross([0.0, 1.0, 0.0], ahead)
    return "left" if float((places[mine.hip] - places[other.hip]) @ left) >= 0.0 else "right"


def up_of(skin: Skin, legs: tuple[SkinLeg, ...]) -> Floats:
    """Find the direction up (3,) in the bind pose, in which the figure stands.

    Meshes are modelled along one of their axes: up is the axis along which hips are above ankles. Where no axis is near
    that direction, the figure is turned, and up is the normal of the plane on which its feet stand.
    """
    hips = np.mean([skin.places[leg.hip] - skin.places[leg.ankle] for leg in legs], axis=0)
    hips = hips / max(float(np.linalg.norm(hips)), 1e-12)
    axis = _nearest_axis(hips)
    standing = _standing(skin, legs, hips)
    if standing is not None and abs(float(standing @ axis)) < np.cos(np.radians(5.0)):
        return axis if float(axis @ hips) > _UPRIGHT and float(standing @ hips) < _UPRIGHT else standing
    return axis


def _standing(skin: Skin, legs: tuple[SkinLeg, ...], hips: Floats) -> Floats | None:
    """Find up (3,) as the normal of the plane that the feet stand on: the side of their convex hull below the hips."""
    from scipy.spatial import ConvexHull, QhullError

    feet = np.any([skin.moved_by(skin.below(leg.ankle)) > _MOVED for leg in legs], axis=0)
    points = skin.vertices[feet]
    if len(points) < 4:
        return None
    try:
        hull = ConvexHull(points)
    except QhullError:
        return None
    above = points.mean(axis=0) + hips * np.ptp(points, axis=0).max()
    facing = hull.equations[:, :3] @ -hips  # of each side, how much it looks down
    down = np.flatnonzero(facing > 0.5)
    if not len(down):
        return None
    # The line from the hips straight down leaves the hull at the first of these sides.
    way = -(hull.equations[down, :3] @ above + hull.equations[down, 3]) / facing[down]
    return -np.asarray(hull.equations[down[int(np.argmin(way))], :3])


def _nearest_axis(direction: Floats) -> Floats:
    axis = np.zeros(3)
    along = int(np.argmax(np.abs(direction)))
    axis[along] = np.sign(direction[along])
    return axis


def _to_y(up: Floats) -> Floats:
    """Make a rotation (3, 3) that takes an axis up to y."""
    if abs(up[1]) > 0.5:
        return np.diag([1.0, up[1], up[1]])
    ahead = np.cross(up, [0.0, 1.0, 0.0])
    return np.stack([np.cross(up, ahead), up, ahead])


def feet_of(skin: Skin, legs: tuple[SkinLeg, ...]) -> tuple[SkinFoot, ...]:
    """Find the soles of a skin's feet.

    Args:
        skin: the character.
        legs: its legs.

    Raises:
        InputError: a foot moves no vertices.
    """
    up = up_of(skin, legs)
    length = float(np.mean([leg.length(skin) for leg in legs]))
    return tuple(_foot(skin, leg, up, length) for leg in legs)


def _foot(skin: Skin, leg: SkinLeg, up: Floats, length: float) -> SkinFoot:
    below = skin.below(leg.ankle)
    moved = skin.moved_by(below)
    own = np.flatnonzero(moved > _MOVED)
    if len(own) < _FEWEST:
        raise InputError(f"no part of the mesh moves with {skin.names[leg.ankle]}", file=skin.name)
    toes = np.zeros(len(own)) if leg.toe is None else skin.moved_by(skin.below(leg.toe))[own]
    vertices, ankle = skin.vertices[own], skin.places[leg.ankle]
    height = vertices @ up
    level = float(height.min())
    ahead = _ahead(skin, leg, up, vertices)
    along = (vertices - ankle) @ ahead
    facing = skin.normals[own] @ up
    low = (height - level < _LAYER * length) & (facing < -_DOWN)
    rim = (height - level < _LAYER * length) & (facing < -_RIM)
    if np.count_nonzero(low) < _FEWEST or (leg.toe is None and stands_on_toes(float(ankle @ up) - level, length)):
        least = np.quantile(height, _PAW) if len(own) > _FEWEST / _PAW else np.sort(height)[_FEWEST - 1]
        low = (height <= least) | (height - level < _LAYER * length)
        rim = low
    left, side = np.cross(up, ahead), (vertices - ankle) @ np.cross(up, ahead)
    toe = ankle if leg.toe is None else skin.places[leg.toe]
    under = float((toe - ankle) @ ahead) if leg.toe is not None else float(np.quantile(along[low], 0.6))
    rear, front = float(along[rim].min()), float(along[rim].max())
    places = []
    for at, stop in ((rear, 0.5 * (rear + under)), (under, None), (front, None)):
        near = rim & (np.abs(along - at) <= _BAND * length)
        near = near if near.any() else rim & (np.abs(along - at) <= np.abs(along - at)[rim].min())
        across = float(side[near].min() + side[near].max()) / 2.0
        across = float((toe - ankle) @ left) if at == under and leg.toe is not None else across  # under its joint
        # A heel is round, and touches the floor in front of its back.
        bears = near if stop is None else rim & (along <= max(stop, rear))
        places.append(ankle + (at * ahead + across * left) + (float(height[bears].min()) - float(ankle @ up)) * up)
    return SkinFoot(leg, length, up, ahead, level, vertices, np.clip(toes / moved[own], 0.0, 1.0), low, *places)


def stands_on_toes(ankle: float, length: float) -> bool:
    """Tell whether an ankle is too high over the ground, for the leg's length, for a flat foot."""
    return ankle > _ON_TOES * length


def _ahead(skin: Skin, leg: SkinLeg, up: Floats, vertices: Floats) -> Floats:
    """Find the direction (3,) in which a foot points: from ankle to toe joint, or to the middle of its vertices; level.
    """
    way = (vertices.mean(axis=0) if leg.toe is None else skin.places[leg.toe]) - skin.places[leg.ankle]
    way = way - (way @ up) * up
    return np.asarray(way / max(float(np.linalg.norm(way)), 1e-12))
