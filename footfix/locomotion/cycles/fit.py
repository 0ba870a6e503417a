"""Fit a model to captured cycles."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from footfix.locomotion.cycles.eigencycles import GaitSpace
from footfix.locomotion.cycles.fit_space import SpaceParams, aligned, fit_space, make_code
from footfix.locomotion.cycles.leave_out import LeftOut, degree_for, leave_out
from footfix.locomotion.cycles.leg_pose import LegPoses
from footfix.locomotion.cycles.model import CycleModel, Origin
from footfix.locomotion.cycles.plan import Plan
from footfix.locomotion.cycles.samples import Sample
from footfix.motion.clip import Bools, Floats, Ints, Skeleton
from footfix.motion.vectors import unit
from footfix.rig.rig import Rig

_MIXED = 9  # speeds at which contacts between walk and run are computed
_BRIEFEST = 0.03  # of a cycle: shorter contacts are ignored
_FINE = 128  # samples of a contact
_WIDER = 0.02  # of a cycle: margin around captured contacts
_DELTA = 0.4  # G eq. 8
_LEVEL = (0.012, 0.02)  # [leg lengths] least and greatest eps_p above the least height
_QUICK = 0.7  # [leg lengths/s] a faster effector is not planted
_NEAR = 0.02  # [leg lengths] greatest distance of a planted effector from its resting place


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
        The model, and its errors on cycles of files left out of the fit.
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
        np.zeros((_MIXED, len(rig.soles), 2)), tuple(origins),
    )  # fmt: skip
    bare = replace(bare, spaces=tuple(_detected(bare, space) for space in bare.spaces))
    bare = replace(bare, between=_between(bare))
    return replace(bare, levels=_levels(bare), knees=_knees(bare)), error


def _without_what_is_above(skeleton: Skeleton, root: int) -> Skeleton:
    """Make the skeleton whose joints above the root rest at the origin."""
    offsets = np.array(skeleton.offsets)
    offsets[list(skeleton.ancestors(root))] = 0.0
    return replace(skeleton, offsets=offsets)


def reaches(skeleton: Skeleton, leg_length: float) -> Floats:
    """Compute the distance from each joint to the farthest point below it, (J,) [leg lengths]."""
    far = np.zeros(len(skeleton))
    np.maximum.at(far, skeleton.end_parents, np.linalg.norm(skeleton.end_offsets, axis=1))
    for joint in range(len(skeleton) - 1, -1, -1):
        parent = int(skeleton.parents[joint])
        if parent >= 0:
            far[parent] = max(far[parent], float(np.linalg.norm(skeleton.offsets[joint])) + far[joint])
    return np.asarray(np.maximum(far, 1e-3 * leg_length) / leg_length)


def _asked(model: CycleModel, speed: float, run: float, count: int) -> Plan:
    """Make a plan of one speed v / sqrt(g l), (count,) times."""
    v, r, w = (np.full(count, each) for each in (speed * model.froude, run, 0.0))
    return Plan(np.arange(count, dtype=np.float64), v, r, w, np.zeros((count, len(model.styles))))


def _share(space: GaitSpace) -> float:
    return float(space.gait == "run")


def _cycle_legs(model: CycleModel, speed: float, run: float, phases: Floats) -> LegPoses:
    """Pose the legs of a cycle that travels along z at an even speed, at phases (T,)."""
    plan = _asked(model, speed, run, len(phases))
    rows = model.leg_rows(phases, plan)
    frames = model.leg_frames(rows)
    place = model.rig.leg_length * rows[:, :3]
    place[:, 2] += plan.speed * phases / model.frequency(plan)
    return model.legs.poses(place, frames[:, 0], frames[:, 1:])


def _levels(model: CycleModel) -> Floats:
    """Compute the height of each effector in the middle of its contact, (E,) [leg lengths], mean of the gaits."""
    found = np.full((len(model.spaces), len(model.rig.soles)), np.nan)
    for g, space in enumerate(model.spaces):
        speed = 0.5 * (space.ramp.low + space.ramp.high)
        share = _share(space)
        spans = model.contact_phases(_asked(model, speed, share, 1))[0]
        pose = _cycle_legs(model, speed, share, spans[:, 0] + 0.5 * spans[:, 1])
        for e, sole in enumerate(model.rig.soles):
            if spans[e, 1] > 0.02:
                found[g, e] = (pose.heel if sole.part == "heel" else pose.toe)[e, sole.leg, 1]
    known = np.isfinite(found)
    mean = np.where(known, found, 0.0).sum(axis=0) / np.maximum(known.sum(axis=0), 1)
    return np.asarray(mean / model.rig.leg_length, dtype=np.float64)


def _knees(model: CycleModel) -> Floats:
    """Find the axis about which each knee flexes in its cycles, in the frame of the thigh, (L, 3)."""
    axes = np.zeros((len(model.rig.legs), 3))
    phases = np.linspace(0.0, 1.0, 32, endpoint=False)
    for space in model.spaces:
        pose = _cycle_legs(model, 0.5 * (space.ramp.low + space.ramp.high), _share(space), phases)
        normal = np.cross(pose.knee - pose.hip, pose.ankle - pose.knee)
        axes += np.einsum("tlji,tlj->li", pose.thigh, normal)
    return np.asarray(unit(axes))


def _detected(model: CycleModel, space: GaitSpace) -> GaitSpace:
    """Detect contacts on the cycles themselves (G sec. 4.2), within the time in which captured ones were.

    An effector is planted where it is lower than eps_p, between the least height and that at the ends of the window
    (eq. 8), searching inwards from both ends; and slow, and near its resting place, since in a mean of many cycles feet
    do not leave the floor abruptly.
    """
    speeds = zip(space.contact_speeds().tolist(), space.contacts, strict=True)
    return replace(space, contacts=np.stack([_on_cycle(model, v, _share(space), spans) for v, spans in speeds]))


def _between(model: CycleModel) -> Floats:
    """Compute `CycleModel.between`, (M, E, 2)."""
    if len(model.spaces) == 1:
        return np.array(model.between)
    speeds = np.maximum(model.between_speeds(), 0.02)
    usual = model.contact_phases(_asked(model, 1.0, 0.5, len(speeds)).of_speeds(speeds * model.froude))
    found = [_on_cycle(model, float(v), 0.5, spans) for v, spans in zip(speeds, usual, strict=True)]
    return np.asarray(np.stack(found) - usual)


def _on_cycle(model: CycleModel, speed: float, run: float, spans: Floats) -> Floats:
    """Find when each effector is set down in a cycle and for how long it stays, (E, 2), within spans (E, 2)."""
    out = np.array(spans)
    fine = np.linspace(0.0, 1.0, _FINE)
    seconds = 1.0 / float(model.frequency(_asked(model, speed, run, 1))[0])
    for e, sole in enumerate(model.rig.soles):
        start, lasts = spans[e]
        if lasts < _BRIEFEST:
            out[e, 1] = 0.0
            continue
        phases = start - _WIDER + (lasts + 2.0 * _WIDER) * fine
        pose = _cycle_legs(model, speed, run, phases)
        track = (pose.heel if sole.part == "heel" else pose.toe)[:, sole.leg] / model.rig.leg_length
        quick = np.linalg.norm(np.gradient(track, phases * seconds, axis=0), axis=1)
        own = _contact_of(track, quick, (phases >= start) & (phases <= start + lasts))
        out[e] = [phases[own[0]], phases[own[-1]] - phases[own[0]]] if len(own) else [start, 0.0]
    return out


def _contact_of(track: Floats, quick: Floats, usual: Bools) -> Ints:
    """Find the samples of a track (T, 3) [leg lengths] in which an effector is planted: low, slow and near its place.
    """
    middle = np.flatnonzero(usual)
    middle = middle[len(middle) // 4 : -(len(middle) // 4) or None]
    rest = np.median(track[middle], axis=0)
    least = float(track[middle, 1].min())
    eps_p = least + np.clip(_DELTA * (0.5 * (track[0, 1] + track[-1, 1]) - least), *_LEVEL)
    far = np.hypot(track[:, 0] - rest[0], track[:, 2] - rest[2])
    down = (track[:, 1] <= eps_p) & (far <= _NEAR) & (quick <= _QUICK) & usual
    if not down[middle].any():
        return middle[:0]
    low, high = middle[down[middle]][[0, -1]]
    while low > 0 and down[low - 1]:
        low -= 1
    while high + 1 < len(down) and down[high + 1]:
        high += 1
    return np.arange(low, high + 1)
