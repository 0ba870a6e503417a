"""A leg as captured, and what enforcement needs to know of it; `leg_state` says where it goes in a state.

Arrays have their components first and frames last, (3, F), so that each operation runs over contiguous memory.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np

from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats, Ints, Skeleton
from footfix.motion.kinematics import Pose
from footfix.motion.threads import at_once
from footfix.motion.vectors import cross as cross_rows
from footfix.motion.vectors import dot, norm, unit
from footfix.rig.rig import Leg, Rig

# The unknowns of one leg and of the root, in the order of the state vector.
ROOT = 3  # d: shift of the root [m]
# q (3): turn of the line from hip to ankle, k: flexion of the knee, w (3): turn of the foot, b: bend of the toes
LEG = 8
Q, K, W, B = slice(0, 3), 3, slice(4, 7), 7  # within a leg's eight
POINTS = ("heel", "toe", "ankle", "tip")
HEEL, TOE, ANKLE, TIP = range(4)

STRAIGHT = 0.4  # [sine] up to this bend a captured leg is too straight to show the axis of its knee
_STRETCHED = 3.6  # [degrees] of flexion: two equal bones at 99.95 % of their length
_WHITE = -0.7  # correlation of neighbouring fourth differences: -0.8 in white noise, above 0 in motion
_STRAIGHTEST = 1.0  # [percentile] of a clip's flexion that counts as its straightest knee


@dataclass(frozen=True, eq=False)
class LegCalibration:
    """Properties of a leg measured over the whole clip.

    Args:
        knee_axis: (3,) about which the knee flexes, in the hip joint's frame.
        straightest: [rad] least flexion of the knee, without outliers.
        toe_hinge: (3,) about which the toes turn up, in the ankle's frame.
        noise: [rad] noise of the line from hip to ankle, the knee, and the foot.
    """

    knee_axis: Floats
    straightest: float
    toe_hinge: Floats
    noise: tuple[Noise, Noise, Noise]

    @property
    def least(self) -> float:
        """Get the least flexion [rad] allowed for a knee that was not captured straighter."""
        return max(self.straightest, float(np.radians(_STRETCHED)))


@dataclass(frozen=True, eq=False)
class LegTracks:
    """A leg as captured over F frames, in the world.

    Args:
        leg: its joints.
        hip, ankle: (3, F) [m].
        line: (3, F) unit vector from hip to ankle.
        thigh, shank: (3, F) [m] from hip to knee, and from knee to ankle.
        axis: (3, F) about which the knee flexes.
        flexion: (F,) [rad] of the knee, 0 where it is straight, negative where it bends backwards.
        least: (F,) [rad] least flexion allowed.
        reach: (3, F) coefficients c of D(k)^2 = c0 + c1 cos k + c2 sin k, the distance from hip to ankle [m^2].
        points: heel and toe (and tip, where the toes have one), (3, F) [m] each: heel and toe from the ankle, the
            tip from the toe. The ankle is a point, too.
        toe_hinge: (3, F) about which the toes bend.
        bends: whether the file can bend the toes.
        turns: whether the file can turn hip, knee and ankle.
    """

    leg: Leg
    hip: Floats
    ankle: Floats
    line: Floats
    thigh: Floats
    shank: Floats
    axis: Floats
    flexion: Floats
    least: Floats
    reach: Floats
    points: tuple[Floats, ...]
    toe_hinge: Floats
    bends: bool
    turns: bool

    def place(self, point: int) -> Floats:
        """Get the track (3, F) [m] of a point as captured."""
        return self._places[point]

    @cached_property
    def _places(self) -> tuple[Floats, ...]:
        heel, toe = (self.ankle + each for each in self.points[:2])
        tip = (toe + self.points[2],) if len(self.points) > 2 else ()
        return heel, toe, self.ankle, *tip

    def frames(self, which: slice | Ints) -> LegTracks:
        """Cut the leg to some frames."""
        some = {
            name: np.ascontiguousarray(getattr(self, name)[..., which])
            for name in ("hip", "ankle", "line", "thigh", "shank", "axis", "flexion", "least", "reach", "toe_hinge")
        }
        points = tuple(np.ascontiguousarray(each[:, which]) for each in self.points)
        return LegTracks(self.leg, **some, points=points, bends=self.bends, turns=self.turns)


def calibrate(rig: Rig, pose: Pose, clip: Clip) -> tuple[LegCalibration, ...]:
    """Measure the properties of each leg that enforcement needs, over the whole clip.

    Args:
        rig: its legs.
        pose: of the clip, from `task.pose_of`.
        clip: F frames, metres, y up.
    """

    def of_leg(k: int) -> LegCalibration:
        leg = rig.legs[k]
        hip, knee, ankle = (pose.position(joint) for joint in (leg.hip, leg.knee, leg.ankle))
        thigh, shank, hip_turn = knee - hip, ankle - knee, pose.rotation(leg.hip)
        in_thigh = rotation.rotate(rotation.inverse(hip_turn), cross_rows(unit(thigh), unit(shank)))
        usual = in_thigh.sum(axis=0)
        heel, toe = (pose.point(s.joint, np.array(s.offset)) for s in rig.soles if s.leg == k)
        if np.linalg.norm(usual) <= 0.01 * len(clip):  # a leg that is never bent: its shank goes away from the toes
            across = cross_rows(thigh, heel - toe)
            usual = rotation.rotate(rotation.inverse(hip_turn), unit(across)).sum(axis=0)
        axis = knee_axis(thigh, shank, rotation.rotate(hip_turn, unit(usual)))
        flexion = _flexion(thigh, shank, axis)
        straightest = float(np.percentile(flexion, _STRAIGHTEST))
        up = np.array([0.0, 1.0, 0.0])
        ahead = unit((toe - heel) * [1.0, 0.0, 1.0])
        hinge = rotation.rotate(rotation.inverse(pose.rotation(leg.ankle)), cross_rows(ahead, up[None])).sum(axis=0)
        length = np.median(norm(ankle - hip))
        noise = noise_of((ankle - hip) / length), noise_of(flexion[:, None]), noise_of(unit(toe - ankle))
        return LegCalibration(unit(usual), straightest, unit(hinge), noise)

    return tuple(at_once([partial(of_leg, k) for k in range(len(rig.legs))], len(clip)))


def _lying(track: Floats) -> Floats:
    """Transpose a track (F, 3) to (3, F), each component contiguous."""
    return np.ascontiguousarray(track.T)


@dataclass(frozen=True)
class Noise:
    """The frame-to-frame noise of a track.

    Args:
        sigma: its standard deviation along one axis.
        white: whether the track's fastest changes are all noise.
    """

    sigma: float
    white: bool


def noise_of(track: Floats) -> Noise:
    """Estimate the noise of a track (F, D).

    It is the median of fourth differences, in which motion hardly shows; steps and strikes are too few to change it.
    Quick motion shows a little; it is recognised by neighbouring differences, which alternate less than in noise.
    Source: the difference-based estimator of J. von Neumann et al., Annals of Mathematical Statistics 12 (1941).
    """
    if len(track) < 9:
        return Noise(0.0, False)
    fourth = np.diff(track, n=4, axis=0)
    # 0.6745: median absolute value of a normal distribution; 70 = 1 + 16 + 36 + 16 + 1 times a frame's variance
    deviation = np.median(np.abs(fourth), axis=0) / 0.6745
    ahead, behind = fourth[1:], fourth[:-1]
    alike = float(np.median(dot(ahead, behind))) / max(float(np.median(dot(ahead, ahead))), 1e-300)
    return Noise(float(np.sqrt(np.mean(deviation**2) / 70.0)), alike < _WHITE)


def tracks(clip: Clip, rig: Rig, pose: Pose, calibration: Sequence[LegCalibration]) -> tuple[LegTracks, ...]:
    """Lay out the legs of a clip for the optimisation.

    Args:
        clip: F frames, metres, y up.
        rig: its legs.
        pose: of the clip, from `task.pose_of`.
        calibration: one a leg.
    """

    def of_leg(k: int, leg: Leg, known: LegCalibration) -> LegTracks:
        hip, knee, ankle = (pose.position(joint) for joint in (leg.hip, leg.knee, leg.ankle))
        thigh, shank = knee - hip, ankle - knee
        axis, flexion, reach = knee_of(thigh, shank, rotation.rotate(pose.rotation(leg.hip), known.knee_axis))
        least = np.minimum(flexion, known.least)
        points, bends = _points(clip, rig, pose, k)
        return LegTracks(
            leg=leg, hip=_lying(hip), ankle=_lying(ankle), line=_lying(unit(ankle - hip)), thigh=_lying(thigh),
            shank=_lying(shank), axis=_lying(axis), flexion=flexion, least=least, reach=reach,
            points=tuple(_lying(each) for each in points),
            toe_hinge=_lying(rotation.rotate(pose.rotation(leg.ankle), known.toe_hinge)), bends=bends,
            turns=bool(np.all(clip.skeleton.rotates[[leg.hip, leg.knee, leg.ankle]])),
        )  # fmt: skip

    each = zip(range(len(rig.legs)), rig.legs, calibration, strict=True)
    return tuple(at_once([partial(of_leg, *args) for args in each], len(clip)))


def knee_of(thigh: Floats, shank: Floats, usual: Floats) -> tuple[Floats, Floats, Floats]:
    """Measure a knee: its axis (F, 3), its flexion (F,) [rad], and `LegTracks.reach` (3, F) [m^2].

    Args:
        thigh, shank: (F, 3) [m] from hip to knee, and from knee to ankle.
        usual: (F, 3) unit axis that the knee has on the whole, in the world.
    """
    axis = knee_axis(thigh, shank, usual)
    # D(k)^2 = |thigh|^2 + |shank|^2 + 2 thigh . R(axis, k) shank
    along = dot(thigh, axis) * dot(shank, axis)
    reach = np.stack([
        dot(thigh, thigh) + dot(shank, shank) + 2.0 * along,
        2.0 * (dot(thigh, shank) - along),
        2.0 * dot(thigh, cross_rows(axis, shank)),
    ])  # fmt: skip
    return axis, _flexion(thigh, shank, axis), reach


def raise_leg(leg: LegTracks, lift: float | Floats) -> LegTracks:
    """Raise a leg as captured by `lift` [m], the same or one for each of its frames."""
    up = np.array([[0.0], [1.0], [0.0]]) * lift
    return replace(leg, hip=leg.hip + up, ankle=leg.ankle + up)


def knee_axis(thigh: Floats, shank: Floats, usual: Floats) -> Floats:
    """Find the axis about which a knee flexes, at right angles to the thigh.

    Where the leg is bent it is the normal of the captured leg's plane. Where it is straight that normal is undefined,
    and the knee's mean axis, fixed in the thigh, is used. As a leg passes through straight the normal flips: only its
    component along the mean axis counts.

    Args:
        thigh, shank: (F, 3) [m] from hip to knee, and from knee to ankle.
        usual: (F, 3) mean unit axis of the knee over the clip, in the world.

    Returns:
        (F, 3) unit axis in the world.
    """
    normal = cross_rows(unit(thigh), unit(shank))  # as long as the sine of the flexion
    c = dot(normal, usual)
    aside = normal - c[:, None] * usual
    square = c * c + STRAIGHT**2
    axis = np.sqrt(square)[:, None] * usual + (c * np.abs(c) / square)[:, None] * aside
    along = unit(thigh)
    return unit(axis - dot(axis, along)[:, None] * along)


def _flexion(thigh: Floats, shank: Floats, axis: Floats) -> Floats:
    """Compute the knee's flexion (F,) [rad] about its axis (F, 3)."""
    in_plane = shank - dot(shank, axis)[:, None] * axis
    return np.arctan2(dot(axis, cross_rows(thigh, in_plane)), dot(thigh, in_plane))


def _points(clip: Clip, rig: Rig, pose: Pose, k: int) -> tuple[tuple[Floats, ...], bool]:
    """Compute heel and toe from the ankle, and the tip from the toe, (F, 3) [m] each, and whether the toes bend."""
    leg, skeleton = rig.legs[k], clip.skeleton
    ankle = pose.position(leg.ankle)
    heel, toe = (pose.point(*rig.held_at(sole)) for sole in rig.soles if sole.leg == k)
    offset = tip_of(skeleton, rig, k)
    if leg.toe is None or offset is None:
        return (heel - ankle, toe - ankle), False
    return (heel - ankle, toe - ankle, pose.point(leg.toe, offset) - toe), bool(skeleton.rotates[leg.toe])


def tip_of(skeleton: Skeleton, rig: Rig, k: int) -> Floats | None:
    """Get the tip of a leg's toes (3,) [m] in the toe joint's frame; None where there is none that can be bent up."""
    leg = rig.legs[k]
    ends = np.flatnonzero(skeleton.end_parents == leg.toe)
    offset = skeleton.end_offsets[ends[0]] if len(ends) else np.zeros(3)
    if leg.toe is None or float(np.linalg.norm(offset)) < 0.01 * rig.leg_length:
        return None
    return offset if leg.ankle in skeleton.ancestors(int(skeleton.parents[leg.toe])) else None
