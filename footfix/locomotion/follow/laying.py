"""Walks laid along a path: body and feet, strides, and lean."""

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
from footfix.locomotion.follow.legs import bend_legs, hips_of, reaches
from footfix.locomotion.follow.params import FollowParams
from footfix.locomotion.follow.path import Path
from footfix.locomotion.follow.placing import Goal, Lean, goal_of, lay_body
from footfix.locomotion.follow.posing import Posed, pose
from footfix.locomotion.follow.standing import firmness, unslid, unturned
from footfix.locomotion.follow.steps import envelope, ground_at, lower_swing, reach_lack
from footfix.locomotion.follow.stride import Way, averaged, smoothed
from footfix.locomotion.follow.timeline import Timeline
from footfix.locomotion.follow.walk import Walk
from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats
from footfix.rig.rig import Rig

_CURVES = 0.5  # of what a leg is kept from being straight where walks are mixed, on curves
_LINE = Path(np.array([[0.0, 0.0], [0.0, 1.0]]), 1.0, False)  # along z


@dataclass(frozen=True, eq=False)
class Laid:
    """Walks laid along a path, F frames with what is cut off at both ends.

    Args:
        posed: the same on the spot.
        laid: bodies on the path, before legs were bent.
        clip: with feet where they step.
        arc: (F,) [m] arc length on the path.
        speed: (F,) [m/s] along it.
        scale: (F,) how long strides are, of captured ones.
        lean: of the body.
        aside: (F,) [m] how far feet step beside the path, to the left.
        balance: (F,) [m] how far the zero-moment point is from where the straight walk has it, to the left.
        stride: (F,) [frames] of a stride.
    """

    posed: Posed
    laid: Clip
    clip: Clip
    arc: Floats
    speed: Floats
    scale: Floats
    lean: Lean
    aside: Floats
    balance: Floats
    stride: Floats


def lay_walks(
    path: Path, way: Way, walks: Sequence[Walk], timeline: Timeline, params: FollowParams, *, paced: bool
) -> Laid:  # fmt: skip
    """Lay body and feet along a path, and lean; `paced` says whether walks are gone at another speed."""
    posed = pose(walks, timeline)
    arc = way.arc(timeline.gone)
    dt, first = timeline.frame_time, walks[0]
    leads = timeline.leads()
    stride = np.array([walk.stride_seconds for walk in walks])[leads] / dt  # (F,) [frames]
    usual = float(np.median(stride))
    straight = np.gradient(timeline.gone)
    speed = np.gradient(arc) / dt
    scale = np.where(straight > 0.0, np.gradient(arc) / np.maximum(straight, 1e-12), 1.0)
    scale = np.ones_like(scale) if path.straight else scale
    curvature = path.curvature(arc)
    firm = np.maximum(firmness(curvature), paced | timeline.blended())
    height = smoothed(np.array([walk.height for walk in walks])[leads], round(usual)) if len(walks) > 1 else np.full(
        len(arc), first.height
    )  # fmt: skip
    angle = lean_for(speed, curvature, usual) if params.lean else np.zeros(len(arc))
    neck = neck_of(first.clip.skeleton, first.rig) if params.head else None

    def lay(angle: Floats) -> tuple[Clip, Clip, Floats, Floats]:
        aside = -height * np.sin(angle) * (params.on_path == "root")
        return (*_figure(posed, path, arc, aside, Lean(angle, neck, params.head), scale, firm), aside)

    laid, clip, lowered, aside = lay(angle)
    off = np.zeros(len(arc))
    if np.any(angle):
        body = segments(first.clip.skeleton, first.rig)
        on = go_straight(posed, timeline.gone)
        upright = _balance(on, first.rig, body, _LINE, timeline.gone, 0.0 * aside, usual)
        off = _balance(clip, first.rig, body, path, arc, aside, usual) - upright
        high = float((centres(first.clip, body)[..., 1] - first.rig.floor).mean(axis=1) @ [each.mass for each in body])
        angle = corrected_lean(angle, off, high, usual)
        laid, clip, lowered, aside = lay(angle)
        off = _balance(clip, first.rig, body, path, arc, aside, usual) - upright
    return Laid(posed, laid, clip, arc, speed, scale, Lean(angle, neck, params.head, lowered), aside, off, stride)


def lay_straight(posed: Posed, timeline: Timeline) -> Clip:
    """Lay body and feet straight on along z, upright, as captured where nothing is blended."""
    still = np.zeros(len(timeline))
    firm = np.asarray(timeline.blended(), dtype=np.float64)
    return _figure(posed, _LINE, timeline.gone, still, Lean(still), still + 1.0, firm)[1]


def go_straight(posed: Posed, gone: Floats) -> Clip:
    """The walks straight on along z."""
    still = np.zeros(len(gone))
    return lay_body(posed, ground_at(_LINE, gone, still), Lean(still))


def _balance(
    clip: Clip, rig: Rig, body: tuple[Segment, ...], path: Path, arc: Floats, aside: Floats, stride: float
) -> Floats:  # fmt: skip
    """(F,) [m] how far the zero-moment point is to the left of where feet step along a path.

    The mean over a stride, by how hard the body presses on the floor: in free flight it does not.
    """
    point, press = zero_moment_point(clip, rig, body)
    heading = path.heading(arc)
    ahead = np.stack([np.sin(heading), np.cos(heading)], axis=1)
    on = arc + np.einsum("fk,fk->f", point - path.position(arc), ahead)
    heading = path.heading(on)
    left = np.stack([np.cos(heading), -np.sin(heading)], axis=1)
    side = np.einsum("fk,fk->f", point - path.position(on), left) - aside
    return averaged(press * side, stride) / averaged(press, stride)


def _figure(
    posed: Posed, path: Path, arc: Floats, aside: Floats, lean: Lean, scale: Floats, firm: Floats
) -> tuple[Clip, Clip, Floats]:  # fmt: skip
    """The body on a path, the same with its feet where they step, and by how much it is lowered for that."""
    rig, dt = posed.rig, posed.clip.frame_time
    ground = ground_at(path, arc, aside)
    laid = lay_body(posed, ground, lean)
    count = np.arange(len(arc))
    goals: list[Goal] = []
    for number, foot in enumerate(posed.feet):
        moment = foot.steps.moment
        toes = next(e for e, sole in enumerate(rig.soles) if sole.leg == number and sole.part == "toe")
        ankle, heel = (rotation.rotate(foot.turn, each) for each in (foot.ankle, foot.heel))
        there = ground_at(path, np.interp(moment, count, arc), np.interp(moment, count, aside))
        share, down = np.interp(moment, count, firm), posed.planted[:, toes]
        yaw, shift = unturned(foot.turn, ankle, heel, down, foot.steps, share, dt)
        shift += unslid(foot.toe, down, share, dt)
        height = lower_swing(foot.toe[:, 1], foot.steps, np.minimum(scale, 1.0))
        goals.append(goal_of(foot, there, yaw, shift, height))
    far = reaches(laid, rig, np.maximum(posed.mixed, _CURVES * firm))
    near = [np.where(goal.held(), each, np.inf) for goal, each in zip(goals, far, strict=True)]
    lack = reach_lack(hips_of(laid, rig), [goal.ankle for goal in goals], near)
    lowered = envelope(lack, _window(posed))
    if np.any(lowered):
        laid = lay_body(posed, ground, replace(lean, lower=lowered))
    return laid, bend_legs(laid, rig, goals, [float(each.max()) for each in far], ground.turn), lowered


def _window(posed: Posed) -> int:
    """[frames] from a stance of a foot to its next, about."""
    steps = [b[0] - a[0] for foot in posed.feet
             for a, b in zip(foot.steps.stances[:-1], foot.steps.stances[1:], strict=True)]  # fmt: skip
    return int(np.median(steps)) if steps else round(1.0 / posed.clip.frame_time)
