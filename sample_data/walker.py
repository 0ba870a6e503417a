"""Walkers: figures whose heel and toe contacts are exactly known, since the motion is built on them.

`make(Gait("walk"))` plans footsteps, lets the feet take them (`walker_feet`), carries the pelvis over them and
puts the legs in between (`walker_body`). Within a contact the planted point rests to rounding; on a treadmill
it moves with the belt. Everything is in metres, y up, the figure faces +z at the start.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from walker_body import Body, Posture, X, Y, Z, hips_in_world, pose
from walker_feet import Footstep, FootTrack, track
from walker_gaits import GRID, Gait, Plan, smooth
from walker_plan import plan

from footfix.motion import rotation
from footfix.motion.clip import Bools, Clip, Floats
from footfix.motion.contacts import Contacts, Effector


@dataclass(frozen=True, eq=False)
class Walk:
    """A clip and all that is known about it.

    Args:
        clip: the motion, metres, y up.
        contacts: when each heel and toe is planted, exactly.
        tracks: for each effector its (F, 3) [m] track on the sole.
        soles: for each effector the joint that carries it, and where it is in that joint's frame [m].
        belt: (x, y, z) [m/s] with which planted points move; zero but on a treadmill.
        floor: [m] height of the floor the walk starts on.
        gait: what was asked for.
        steps: the footsteps of each foot.
    """

    clip: Clip
    contacts: Contacts
    tracks: tuple[Floats, ...]
    soles: tuple[tuple[str, tuple[float, float, float]], ...]
    belt: tuple[float, float, float]
    floor: float
    gait: Gait
    steps: tuple[tuple[Footstep, ...], tuple[Footstep, ...]]


@lru_cache(maxsize=64)
def make(gait: Gait) -> Walk:
    """Make the walk that a gait describes; the same value where it was asked for not long ago."""
    body = Body(leg=gait.leg)
    planned = plan(body, gait)
    frames = round(gait.duration * gait.fps) + 1
    times = np.arange(frames) / gait.fps
    feet = tuple(track(body, steps, times) for steps in planned.steps)
    pelvis, turn, heading, spread = _carry(body, planned, times)
    posture = Posture(
        pelvis=pelvis,
        pelvis_turn=turn,
        heading=heading,
        ankles=np.stack([foot.ankle for foot in feet]),
        foot_turns=np.stack([foot.turn for foot in feet]),
        foot_headings=np.stack([foot.heading for foot in feet]),
        toe_bends=np.stack([foot.toe_bend for foot in feet]),
        spread=spread,
        arm_swing=planned.style.arm_swing,
        elbow=planned.style.elbow,
        lean=planned.style.lean,
    )
    clip = pose(body, posture, 1.0 / gait.fps)
    tracks = tuple(each for foot in feet for each in _sole_tracks(body, foot))
    belt = planned.belt
    if any(belt):
        ride = times[:, None] * np.array(belt)
        positions = clip.positions.copy()
        positions[:, 0] += ride
        clip = replace(clip, positions=positions)
        tracks = tuple(each + ride for each in tracks)
    down = np.stack([mask for foot in feet for mask in (foot.heel_down, foot.ball_down)], axis=1)
    return Walk(
        clip, _contacts(clip, down), tracks, _soles(body), belt, 0.0, gait, (planned.steps[0], planned.steps[1])
    )


def _soles(body: Body) -> tuple[tuple[str, tuple[float, float, float]], ...]:
    heel, ball = body.heel_in_foot(), body.ball_in_toe()
    return tuple(
        (side + joint, (float(at[0]), float(at[1]), float(at[2])))
        for side in ("Left", "Right")
        for joint, at in (("Foot", heel), ("ToeBase", ball))
    )


def _sole_tracks(body: Body, foot: FootTrack) -> tuple[Floats, Floats]:
    heel = foot.ankle + rotation.rotate(foot.turn, body.heel_in_foot())
    joint = foot.ankle + rotation.rotate(foot.turn, body.ball_in_foot())
    toe = rotation.multiply(foot.turn, rotation.from_axis_angle(X, foot.toe_bend))
    return heel, joint + rotation.rotate(toe, body.ball_in_toe())


def _contacts(clip: Clip, down: Bools) -> Contacts:
    effectors = (
        Effector("left_heel", "left", "heel", "LeftFoot"),
        Effector("left_toe", "left", "toe", "LeftToeBase"),
        Effector("right_heel", "right", "heel", "RightFoot"),
        Effector("right_toe", "right", "toe", "RightToeBase"),
    )
    return Contacts(len(clip), clip.frame_time, effectors, method="known").with_mask(down)


def _carry(body: Body, planned: Plan, times: Floats) -> tuple[Floats, Floats, Floats, Floats]:
    """Pelvis track (F, 3), its turn (F, 4), heading (F,) and spread of the feet (F,) at the frames' times.

    All is found on a fine grid of its own, so that a clip at another rate is the same motion.
    """
    style, grid = planned.style, planned.grid
    feet = [track(body, steps, grid) for steps in planned.steps]
    load = np.stack([(foot.heel_down | foot.ball_down).astype(np.float64) for foot in feet])
    beat = 0.25 * planned.period
    onto_left = smooth(np.where(load.sum(0) > 0.5, (load[0] - load[1]) / np.maximum(load.sum(0), 1.0), 0.0), beat)
    forward = np.stack([np.sin(planned.heading), np.zeros_like(grid), np.cos(planned.heading)], axis=-1)
    left = np.cross([0.0, 1.0, 0.0], forward)
    apart = np.einsum("fi,fi->f", feet[0].ankle - feet[1].ankle, forward)
    spread = smooth(apart, 0.15 * planned.period) / max(float(np.abs(apart).max()), 0.3 * body.leg)
    in_air = smooth((load.sum(0) < 0.5).astype(np.float64), beat)
    pelvis = planned.path + (style.sway * body.leg * onto_left)[:, None] * left
    pelvis[:, 1] += style.bob * body.leg * (1.0 - spread**2) + planned.rise + style.flight * in_air
    turn = rotation.multiply(
        rotation.from_axis_angle(Y, planned.heading - style.twist * spread),
        rotation.multiply(
            rotation.from_axis_angle(X, np.full_like(grid, style.tilt)),
            rotation.from_axis_angle(Z, style.list_ * onto_left),
        ),
    )
    pelvis[:, 1] -= _too_high(body, pelvis, turn, np.stack([foot.ankle for foot in feet]), style.reach)
    columns = [np.interp(times, grid, each) for each in (*pelvis.T, planned.heading, spread, *turn.T)]
    heading, spread_at = columns[3], columns[4]
    return np.stack(columns[:3], axis=-1), rotation.normalize(np.stack(columns[5:], axis=-1)), heading, spread_at


def _too_high(body: Body, pelvis: Floats, turn: Floats, ankles: Floats, reach: float) -> Floats:
    """How far the pelvis must come down (F,) [m], smoothly, so that no leg is straighter than `reach`."""
    hips = hips_in_world(body, pelvis, turn)
    flat = np.sum((hips - ankles)[..., [0, 2]] ** 2, axis=-1)
    allowed = np.sqrt(np.maximum((reach * body.leg) ** 2 - flat, 0.01 * body.leg**2))
    drop = np.maximum((hips - ankles)[..., 1] - allowed, 0.0).max(axis=0)
    width = round(0.06 / GRID)
    padded = np.pad(drop, width, mode="edge")
    highest = np.lib.stride_tricks.sliding_window_view(padded, 2 * width + 1).max(axis=-1)
    return smooth(highest, 2 * width * GRID)
