"""The walker's body: a skeleton from one leg length, and the closed-form leg that puts its ankles in place."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats, Skeleton

X, Y, Z = np.eye(3)


@dataclass(frozen=True, kw_only=True)
class Body:
    """Sizes of a figure in rest pose (T-pose, facing +z, its left at +x), relative to `leg` [m], hip joint to ankle."""

    leg: float = 0.88  # [m]
    thigh: float = 0.51
    hip_half_width: float = 0.105
    ankle_height: float = 0.095
    ball_height: float = 0.033  # of the toe joint over the sole
    ball_forward: float = 0.150
    heel_back: float = 0.058
    toe_length: float = 0.075

    def ball_in_foot(self) -> Floats:
        """Place of the toe joint in the foot's frame [m]."""
        return self.leg * np.array([0.0, self.ball_height - self.ankle_height, self.ball_forward])

    def heel_in_foot(self) -> Floats:
        """Place of the heel's point of the sole in the foot's frame [m]."""
        return self.leg * np.array([0.0, -self.ankle_height, -self.heel_back])

    def ball_in_toe(self) -> Floats:
        """Place of the ball's point of the sole in the toe joint's frame [m]: straight below the joint."""
        return self.leg * np.array([0.0, -self.ball_height, 0.0])

    def skeleton(self) -> Skeleton:
        """The joints, in the plain CMU naming."""
        joints = [(name, parent, np.array(offset)) for name, parent, offset in self._joints()]
        names = [name for name, _, _ in joints]
        ends = [
            ("LeftToeBase", (0.0, -self.ball_height * 0.6, self.toe_length)),
            ("RightToeBase", (0.0, -self.ball_height * 0.6, self.toe_length)),
            ("Head", (0.0, 0.20, 0.0)),
            ("LeftHand", (0.11, 0.0, 0.0)),
            ("RightHand", (-0.11, 0.0, 0.0)),
        ]
        return Skeleton(
            names=tuple(names),
            parents=np.array([names.index(parent) if parent else -1 for _, parent, _ in joints]),
            offsets=self.leg * np.array([offset for _, _, offset in joints]),
            end_parents=np.array([names.index(name) for name, _ in ends]),
            end_offsets=self.leg * np.array([offset for _, offset in ends]),
        )

    def _joints(self) -> list[tuple[str, str, tuple[float, float, float]]]:
        joints: list[tuple[str, str, tuple[float, float, float]]] = [("Hips", "", (0.0, 0.0, 0.0))]
        for side, sign in (("Left", 1.0), ("Right", -1.0)):
            joints += [
                (f"{side}UpLeg", "Hips", (sign * self.hip_half_width, -0.05, 0.0)),
                (f"{side}Leg", f"{side}UpLeg", (0.0, -self.thigh, 0.0)),
                (f"{side}Foot", f"{side}Leg", (0.0, self.thigh - 1.0, 0.0)),
                (f"{side}ToeBase", f"{side}Foot", (0.0, self.ball_height - self.ankle_height, self.ball_forward)),
            ]
        joints += [
            ("Spine", "Hips", (0.0, 0.10, -0.01)),
            ("Spine1", "Spine", (0.0, 0.22, 0.0)),
            ("Neck", "Spine1", (0.0, 0.28, 0.0)),
            ("Head", "Neck", (0.0, 0.11, 0.02)),
        ]
        for side, sign in (("Left", 1.0), ("Right", -1.0)):
            joints += [
                (f"{side}Shoulder", "Spine1", (sign * 0.03, 0.24, 0.0)),
                (f"{side}Arm", f"{side}Shoulder", (sign * 0.16, 0.0, 0.0)),
                (f"{side}ForeArm", f"{side}Arm", (sign * 0.31, 0.0, 0.0)),
                (f"{side}Hand", f"{side}ForeArm", (sign * 0.27, 0.0, 0.0)),
            ]
        return joints


@dataclass(frozen=True, eq=False)
class Posture:
    """What the body does in each of F frames; the legs follow from it.

    Args:
        pelvis: (F, 3) [m] place of the hips joint.
        pelvis_turn: (F, 4) its frame in the world.
        heading: (F,) [rad] where the figure faces, about +y from +z.
        ankles: (2, F, 3) [m] left, right.
        foot_turns: (2, F, 4) the feet's frames in the world.
        foot_headings: (2, F) [rad].
        toe_bends: (2, F) [rad] of the toe joint, negative where the toe bends up.
        spread: (F,) how far the left foot is ahead of the right, about -1 to 1; arms and spine answer to it.
        arm_swing: [rad] of the upper arm at spread 1.
        elbow: [rad] bend of the elbows.
        lean: [rad] forward, of the spine.
    """

    pelvis: Floats
    pelvis_turn: Floats
    heading: Floats
    ankles: Floats
    foot_turns: Floats
    foot_headings: Floats
    toe_bends: Floats
    spread: Floats
    arm_swing: float
    elbow: float
    lean: float


def hips_in_world(body: Body, pelvis: Floats, pelvis_turn: Floats) -> Floats:
    """The hip joints' tracks (2, F, 3) [m], left and right."""
    offsets = body.leg * np.array([[body.hip_half_width, -0.05, 0.0], [-body.hip_half_width, -0.05, 0.0]])
    return np.stack([pelvis + rotation.rotate(pelvis_turn, offset) for offset in offsets])


def pose(body: Body, posture: Posture, frame_time: float) -> Clip:
    """The clip in which the ankles are where the posture wants them, to rounding."""
    skeleton = body.skeleton()
    frames = len(posture.pelvis)
    positions = np.broadcast_to(skeleton.offsets, (frames, *skeleton.offsets.shape)).copy()
    positions[:, 0] = posture.pelvis
    turns = {name: rotation.identity((frames,)) for name in skeleton.names}
    turns["Hips"] = posture.pelvis_turn
    _upper_body(turns, posture)
    hips = hips_in_world(body, posture.pelvis, posture.pelvis_turn)
    for k, side in enumerate(("Left", "Right")):
        thigh, knee = _leg(body, hips[k], posture.ankles[k], posture.heading, posture.foot_headings[k])
        turns[f"{side}UpLeg"] = rotation.multiply(rotation.inverse(posture.pelvis_turn), thigh)
        turns[f"{side}Leg"] = knee
        shin = rotation.multiply(thigh, knee)
        turns[f"{side}Foot"] = rotation.multiply(rotation.inverse(shin), posture.foot_turns[k])
        turns[f"{side}ToeBase"] = rotation.from_axis_angle(X, posture.toe_bends[k])
    rotations = np.stack([turns[name] for name in skeleton.names], axis=1)
    return Clip(skeleton, positions, rotations, frame_time)


def _leg(body: Body, hip: Floats, ankle: Floats, heading: Floats, foot_heading: Floats) -> tuple[Floats, Floats]:
    """The thigh's frame in the world and the knee's bend (F, 4) that put the ankle in its place."""
    a, b = body.leg * body.thigh, body.leg * (1.0 - body.thigh)
    reach = ankle - hip
    r = np.linalg.norm(reach, axis=-1)
    if np.any(r >= a + b) or np.any(r <= abs(a - b)):
        raise ValueError(f"ankle out of reach: {r.min():.3f} to {r.max():.3f} m of {a + b:.3f} m")
    # the knee bends towards the middle between where the hips and where the foot points
    toward = _facing(heading) + _facing(foot_heading)
    down = reach / r[:, None]
    hinge = np.cross(-down, toward)
    hinge /= np.linalg.norm(hinge, axis=-1, keepdims=True)
    straight = rotation.from_matrix(np.stack([hinge, -down, np.cross(hinge, -down)], axis=-1))
    # law of cosines, at the hip and at the knee
    at_hip = np.arccos((a * a + r * r - b * b) / (2.0 * a * r))
    at_knee = np.arccos((a * a + b * b - r * r) / (2.0 * a * b))
    thigh = rotation.multiply(straight, rotation.from_axis_angle(X, -at_hip))
    return thigh, rotation.from_axis_angle(X, np.pi - at_knee)


def _facing(heading: Floats) -> Floats:
    return np.stack([np.sin(heading), np.zeros_like(heading), np.cos(heading)], axis=-1)


def _upper_body(turns: dict[str, Floats], posture: Posture) -> None:
    spread = posture.spread
    ones = np.ones_like(spread)
    counter = 0.10 * spread  # the chest turns against the pelvis
    turns["Spine"] = rotation.multiply(
        rotation.from_axis_angle(Y, counter), rotation.from_axis_angle(X, 0.5 * posture.lean * ones)
    )
    turns["Spine1"] = turns["Spine"]
    turns["Neck"] = rotation.from_axis_angle(X, -0.7 * posture.lean * ones)
    turns["Head"] = rotation.from_axis_angle(Y, -counter)
    for side, sign in (("Left", 1.0), ("Right", -1.0)):
        hang = rotation.from_axis_angle(Z, -sign * 1.35 * ones)
        swing = rotation.from_axis_angle(X, sign * posture.arm_swing * spread)
        turns[f"{side}Arm"] = rotation.multiply(swing, hang)
        bend = posture.elbow * (1.0 - 0.3 * sign * spread)
        turns[f"{side}ForeArm"] = rotation.from_axis_angle(Y, -sign * bend)
