"""Lay walks along a path: body, feet, stride length, and lean."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from footfix.locomotion.follow.balance import (
    Segment,
    centres,
    corrected_lean,
    lean_for,
    neck_of,
    segments,
    zero_moment_point,
)
from footfix.locomotion.follow.blend_schedule import Timeline
from footfix.locomotion.follow.body_placement import Goal, Lean, goal_of, lay_body
from footfix.locomotion.follow.footsteps import Ground, envelope, ground_at, lower_swing, reach_lack
from footfix.locomotion.follow.legs import bend_legs, hips_of, reaches
from footfix.locomotion.follow.params import FollowParams
from footfix.locomotion.follow.path import Path
from footfix.locomotion.follow.planted_feet import firmness, rolled, unslid, unturned
from footfix.locomotion.follow.prepared_walk import Walk
from footfix.locomotion.follow.stride import Way, averaged, smoothed
from footfix.locomotion.follow.walk_poses import WalkPoses, pose
from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats
from footfix.rig.rig import Rig

_CURVES = 0.5  # on curves, how much legs are kept from being straight, relative to blends
_LINE = Path(np.array([[0.0, 0.0], [0.0, 1.0]]), 1.0, False)  # along z


@dataclass(frozen=True, eq=False)
class Laid:
    """Walks laid along a path: F frames, including those that are cut off later at both ends.

    Args:
        posed: the same on the spot.
        laid: the body on the path, before legs are bent.
        clip: with feet where they step.
        arc: (F,) [m] arc length on the path.
        speed: (F,) [m/s] along it.
        scale: (F,) length of strides, relative to captured ones.
        lean: of the body.
        aside: (F,) [m] distance of footsteps from the path, to the left.
        balance: (F,) [m] how far the zero-moment point is from where the straight walk has it, to the left.
        stride: (F,) [frames] of a stride.
    """

    posed: WalkPoses
    laid: Clip
    clip: Clip
    arc: Floats
    speed: Floats
    scale: Floats
    lean: Lean
    aside: Floats
    balance: Floats
    stride: Floats


@dataclass(frozen=True, eq=False)
class Course:
    """The progress of a figure along a path, frame by frame, and its lean.

    Args:
        path: the path.
        arc: (F,) [m] arc length on it.
        speed: (F,) [m/s] along it.
        scale: (F,) length of strides, relative to captured ones.
        angle: (F,) [rad] of the lean, to the left.
        height: (F,) [m] of the pelvis, by which feet step outwards times the sine of the lean,
        outwards: where this is set.
        firm: (F,) share of a planted foot's slide and turn that is removed.
        neck: the joint that compensates the lean, None for none,
        head: and the share of the lean that it compensates.
    """

    path: Path
    arc: Floats
    speed: Floats
    scale: Floats
    angle: Floats
    height: Floats
    outwards: bool
    firm: Floats
    neck: int | None
    head: float

    @property
    def aside(self) -> Floats:
        """Compute the distance of footsteps from the path, (F,) [m] to the left."""
        return np.asarray(-self.height * np.sin(self.angle) * self.outwards)

    @property
    def lean(self) -> Lean:
        """Make the lean of the body."""
        return Lean(self.angle, self.neck, self.head)

    @property
    def ground(self) -> Ground:
        """Get the path under the body."""
        return ground_at(self.path, self.arc, self.aside)


def course_on(
    path: Path, way: Way, walks: Sequence[Walk], timeline: Timeline, params: FollowParams, *, paced: bool,
    since: float = 0.0,
) -> Course:  # fmt: skip
    """Compute the progress of walks along a path.

    Args:
        path: the path.
        way: distances on the path by distances walked.
        walks: one after the other.
        timeline: when each is shown.
        params: of the walk along the path.
        paced: whether they are at another speed than captured.
        since: [m] walked before the timeline starts.
    """
    arc = way.arc(timeline.gone + since)
    first, leads, stride = walks[0], timeline.leads(), _strides(walks, timeline)
    usual = float(np.median(stride))
    straight, on = np.gradient(timeline.gone), np.gradient(arc)
    speed = on / timeline.frame_time
    scale = np.where((straight > 0.0) & (not path.straight), on / np.maximum(straight, 1e-12), 1.0)
    curvature = path.curvature(arc)
    firm = np.maximum(firmness(curvature), paced | timeline.blended())
    height = smoothed(np.array([walk.height for walk in walks])[leads], round(usual)) if len(walks) > 1 else np.full(
        len(arc), first.height
    )  # fmt: skip
    angle = lean_for(speed, curvature, usual) if params.lean else np.zeros(len(arc))
    neck = neck_of(first.clip.skeleton, first.rig) if params.head else None
    return Course(path, arc, speed, scale, angle, height, params.on_path == "root", firm, neck, params.head)


def _strides(walks: Sequence[Walk], timeline: Timeline) -> Floats:
    """Compute the duration of a stride of the leading walk, (F,) [frames]."""
    return np.array([walk.stride_seconds for walk in walks])[timeline.leads()] / timeline.frame_time


def lay_walks(
    path: Path, way: Way, walks: Sequence[Walk], timeline: Timeline, params: FollowParams, *, paced: bool
) -> Laid:  # fmt: skip
    """Lay body and feet along a path, and lean; `paced` tells whether the speed differs from the captured one."""
    posed, first = pose(walks, timeline), walks[0]
    course = course_on(path, way, walks, timeline, params, paced=paced)
    stride, arc = _strides(walks, timeline), course.arc
    usual = float(np.median(stride))
    laid, clip, lowered = lay_figure(posed, course)
    off = np.zeros(len(arc))
    if np.any(course.angle):
        body = segments(first.clip.skeleton, first.rig)
        still = np.zeros(len(arc))
        on = lay_body(posed, ground_at(_LINE, timeline.gone, still), Lean(still))
        upright = _balance(on, first.rig, body, _LINE, timeline.gone, still, usual)
        off = _balance(clip, first.rig, body, path, arc, course.aside, usual) - upright
        high = float((centres(first.clip, body)[..., 1] - first.rig.floor).mean(axis=1) @ [each.mass for each in body])
        course = replace(course, angle=corrected_lean(course.angle, off, high, usual))
        laid, clip, lowered = lay_figure(posed, course)
        off = _balance(clip, first.rig, body, path, arc, course.aside, usual) - upright
    lean = replace(course.lean, lower=lowered)
    return Laid(posed, laid, clip, arc, course.speed, course.scale, lean, course.aside, off, stride)


def _balance(
    clip: Clip, rig: Rig, body: tuple[Segment, ...], path: Path, arc: Floats, aside: Floats, stride: float
) -> Floats:  # fmt: skip
    """Measure how far the zero-moment point is to the left of the footsteps along a path, (F,) [m].

    It is the mean over a stride, weighted by the force on the floor, which is zero in flight.
    """
    point, press = zero_moment_point(clip, rig, body)
    heading = path.heading(arc)
    ahead = np.stack([np.sin(heading), np.cos(heading)], axis=1)
    on = arc + np.einsum("fk,fk->f", point - path.position(arc), ahead)
    heading = path.heading(on)
    left = np.stack([np.cos(heading), -np.sin(heading)], axis=1)
    side = np.einsum("fk,fk->f", point - path.position(on), left) - aside
    return averaged(press * side, stride) / averaged(press, stride)


def lay_figure(posed: WalkPoses, course: Course) -> tuple[Clip, Clip, Floats]:
    """Place the body on its course, bend its legs to the footsteps, and lower it as far as legs require."""
    rig, dt, path, firm = posed.rig, posed.clip.frame_time, course.path, course.firm
    ground, aside = course.ground, course.aside
    laid = lay_body(posed, ground, course.lean)
    count = np.arange(len(aside))
    goals: list[Goal] = []
    for number, foot in enumerate(posed.feet):
        moment = foot.steps.moment
        soles = {sole.part: e for e, sole in enumerate(rig.soles) if sole.leg == number}
        ankle, heel = (rotation.rotate(foot.turn, each) for each in (foot.ankle, foot.heel))
        there = ground_at(path, np.interp(moment, count, course.arc), np.interp(moment, count, aside))
        share, (down, heels) = np.interp(moment, count, firm), (posed.planted[:, soles[k]] for k in ("toe", "heel"))
        yaw, shift = unturned(foot.turn, ankle, heel, down, foot.steps, share, dt)
        shift += unslid(foot.toe, down, share, dt)
        rolls = foot.toe + shift + rotation.rotate(rotation.about_vertical(yaw), heel)
        shift += rolled(rolls, heels, down, foot.mixed, dt)
        height = lower_swing(foot.toe[:, 1], foot.steps, np.minimum(course.scale, 1.0))
        goals.append(goal_of(foot, there, yaw, shift, height))
    far = reaches(laid, rig, posed.reach, np.maximum(posed.mixed, _CURVES * firm))
    near = [np.where(goal.held(), each, np.inf) for goal, each in zip(goals, far, strict=True)]
    lack = reach_lack(hips_of(laid, rig), [goal.ankle for goal in goals], near)
    lowered = envelope(lack, posed.stride)
    if np.any(lowered):
        laid = lay_body(posed, ground, replace(course.lean, lower=lowered))
    return laid, bend_legs(laid, rig, goals, [float(each.max()) for each in far], ground.turn), lowered
