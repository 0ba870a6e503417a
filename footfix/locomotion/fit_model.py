"""From captured cycles to a model."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from footfix.locomotion.eigencycles import Code, GaitSpace, SpaceParams, aligned, fit_space, make_code
from footfix.locomotion.leave_out import LeftOut, degree_for, leave_out
from footfix.locomotion.leg_pose import leg_pose
from footfix.locomotion.model import CycleModel, Origin
from footfix.locomotion.plan import Plan
from footfix.locomotion.samples import Sample
from footfix.motion import rotation
from footfix.motion.clip import Floats, Skeleton
from footfix.motion.vectors import unit
from footfix.rig.rig import Rig


def make_model(
    skeleton: Skeleton, rig: Rig, samples: Sequence[Sample], styles: Sequence[str], params: SpaceParams,
    origins: Sequence[Origin] = (),
) -> tuple[CycleModel, LeftOut]:  # fmt: skip
    """Make a model of the cycles of one skeleton.

    Args:
        skeleton: of the figure.
        rig: its legs, soles and size.
        samples: its cycles, of all gaits.
        styles: names of the styles besides the plain one.
        params: of the spaces.
        origins: the files.

    Returns:
        The model, and how well it tells the cycles of files left out.
    """
    skeleton = _without_what_is_above(skeleton, rig.root)
    rig = replace(rig, floor=0.0, notes=())
    code = make_code(samples, reaches(skeleton, rig.leg_length))
    gaits = [own for gait in ("walk", "run") if (own := [each for each in samples if each.gait == gait])]
    gaits = [aligned(own, code) for own in gaits]
    spaces = tuple(fit_space(own, code, styles, params, degree_for(own, code, styles, params)) for own in gaits)
    error = leave_out(gaits, spaces, code, params, skeleton, rig.root, rig.leg_length)
    bare = CycleModel(
        skeleton, rig, code, spaces, np.zeros(len(rig.soles)), np.tile([1.0, 0.0, 0.0], (len(rig.legs), 1)),
        tuple(origins),
    )  # fmt: skip
    return replace(bare, levels=_levels(bare), knees=_knees(bare)), error


def _without_what_is_above(skeleton: Skeleton, root: int) -> Skeleton:
    """The skeleton whose root is carried by joints that rest at the origin."""
    offsets = np.array(skeleton.offsets)
    offsets[list(skeleton.ancestors(root))] = 0.0
    return replace(skeleton, offsets=offsets)


def reaches(skeleton: Skeleton, leg_length: float) -> Floats:
    """(J,) [leg lengths] from each joint to the farthest of what hangs from it."""
    far = np.zeros(len(skeleton))
    np.maximum.at(far, skeleton.end_parents, np.linalg.norm(skeleton.end_offsets, axis=1))
    for joint in range(len(skeleton) - 1, -1, -1):
        parent = int(skeleton.parents[joint])
        if parent >= 0:
            far[parent] = max(far[parent], float(np.linalg.norm(skeleton.offsets[joint])) + far[joint])
    return np.asarray(np.maximum(far, 1e-3 * leg_length) / leg_length)


def usual(space: GaitSpace, model: CycleModel, count: int) -> Plan:
    """The plan (count,) of the middle of a gait's speeds."""
    speed = 0.5 * (space.ramp.low + space.ramp.high) * model.froude
    share = float(space.gait == "run")
    return Plan(np.arange(count), *(np.full(count, each) for each in (speed, share, 0.0)), np.zeros((count, len(space.styles))))


def _cycle_legs(model: CycleModel, space: GaitSpace, phases: Floats) -> list[object]:
    rows = model.rows(phases, usual(space, model, len(phases)))
    turns = model.turns(rows)
    place = model.rig.leg_length * rows[:, :3]
    return [leg_pose(model, k, place, turns[:, model.rig.root], turns) for k in range(len(model.rig.legs))]


def _levels(model: CycleModel) -> Floats:
    """(E,) [leg lengths] the height of each effector in the middle of its contact, mean of the gaits."""
    found = []
    for space in model.spaces:
        spans = space.contact_phases(np.array([0.5 * (space.ramp.low + space.ramp.high)]))[0]
        heights = np.full(len(spans), np.nan)
        for e, sole in enumerate(model.rig.soles):
            if spans[e, 1] > 0.02:
                (pose,) = [_cycle_legs(model, space, spans[e, :1] + 0.5 * spans[e, 1:])[sole.leg]]
                heights[e] = (pose.heel if sole.part == "heel" else pose.toe)[0, 1]  # type: ignore[attr-defined]
        found.append(heights)
    levels = np.nanmean(np.stack(found), axis=0) if found else np.zeros(len(model.rig.soles))
    return np.asarray(np.nan_to_num(levels)) / model.rig.leg_length


def _knees(model: CycleModel) -> Floats:
    """(L, 3) the axis about which each knee flexes in its cycles, in the frame of the thigh."""
    axes = np.zeros((len(model.rig.legs), 3))
    phases = np.linspace(0.0, 1.0, 32, endpoint=False)
    for space in model.spaces:
        for k, pose in enumerate(_cycle_legs(model, space, phases)):
            leg = model.rig.legs[k]
            thigh, shank = (pose.places[b] - pose.places[a] for a, b in ((leg.hip, leg.knee), (leg.knee, leg.ankle)))  # type: ignore[attr-defined]
            normal = np.cross(thigh, shank)
            axes[k] += rotation.rotate(rotation.inverse(pose.turns[leg.hip]), normal).sum(axis=0)  # type: ignore[attr-defined]
    return np.asarray(unit(axes))


__all__ = ["Code", "make_model"]
