"""Make captured walks follow a path, one blended into the next: root, feet, lean, and held plants."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from footfix.enforce.correction import Correction, apply
from footfix.enforce.footplant import Footplant
from footfix.enforce.params import EnforceParams
from footfix.locomotion.follow.blend_schedule import Pace, Timeline
from footfix.locomotion.follow.blend_weight import Transition
from footfix.locomotion.follow.bone_frames import in_frames_of_first
from footfix.locomotion.follow.key_times import Keys, align
from footfix.locomotion.follow.params import FollowParams
from footfix.locomotion.follow.path import Path, make_path
from footfix.locomotion.follow.path_layout import Laid, lay_walks
from footfix.locomotion.follow.plant_cleanup import as_straight, held_on
from footfix.locomotion.follow.prepared_walk import Walk, check_alike, on_one_floor, pelvis_of
from footfix.locomotion.follow.stride import averaged, pace_of, paced, way_on
from footfix.locomotion.follow.transitions import At, timeline_of, transitions_of
from footfix.locomotion.follow.walk_poses import contacts_of
from footfix.locomotion.loop.root_motion import root_in_world
from footfix.motion.clip import Bools, Clip, Floats, Ints
from footfix.motion.contacts import Contacts
from footfix.notes import Note
from footfix.rig.rig import Rig

_GRIP = np.radians(40.0)  # lean at which shoes slip on most floors: a friction coefficient of 0.84


@dataclass(frozen=True, eq=False)
class Walked:
    """Frame-by-frame data of a walk along a path.

    Args:
        arc: (F,) [m] arc length on the path.
        root: (F, 2) [m] x and z of the root, in the mean over a stride.
        off: (F,) [m] distance of the root from the path, to the left.
        speed: (F,) [m/s] along the path.
        scale: (F,) length of strides, relative to captured ones.
        lean: (F,) [rad] to the left.
        aside: (F,) [m] distance of footsteps from the path, to the left.
        balance: (F,) [m] how far the zero-moment point is from where the straight walk has it, to the left, in the
            mean over a stride; zeros where nothing leans.
        lowered: (F,) [m] by which the body is lowered for its legs to reach.
    """

    arc: Floats
    root: Floats
    off: Floats
    speed: Floats
    scale: Floats
    lean: Floats
    aside: Floats
    balance: Floats
    lowered: Floats


@dataclass(frozen=True, eq=False)
class Follow:
    """Walks along a path.

    Args:
        clip: F frames, the figure's own skeleton.
        laid: the same before legs were bent and plants held.
        straight: the same walks on a straight path, F frames on the spot.
        rig: legs, soles and floor.
        contacts: of `clip`.
        path: the path.
        walked: frame-by-frame data.
        transitions: from walk to walk.
        walks: the loops that were laid.
        frames: (F,) the frame of the first captured clip that each corresponds to when it is written.
        plants: each contact with its place.
        correction: the change from `laid` to `clip`.
        notes: for the user.
    """

    clip: Clip
    laid: Clip
    straight: Clip
    rig: Rig
    contacts: Contacts
    path: Path
    walked: Walked
    transitions: tuple[Transition, ...]
    walks: tuple[Walk, ...]
    frames: Ints
    plants: tuple[Footplant, ...]
    correction: Correction
    notes: tuple[Note, ...]


def follow_path(
    points: Floats, walks: Sequence[Walk], ats: Sequence[At], params: FollowParams, holding: EnforceParams, *,
    relative: bool = False,
) -> Follow:  # fmt: skip
    """Make walks follow a path.

    Args:
        points: (N, 2) [m] x and z of the path.
        walks: one after the other.
        ats: where each of them begins; the first at the start.
        params: of the walk along the path.
        holding: how footplants are enforced.
        relative: whether points are seen from where the first walk is, to its left and ahead.

    Raises:
        ArgumentError: the points do not make a path.
        UsageError: a walk can't begin where it should.
        InputError: the walks have different skeletons.
    """
    check_alike(walks)
    walks = in_frames_of_first(on_one_floor(walks))
    first = walks[0]
    path = _path(points, walks, params, relative)
    paces = [pace_of(walk, params) for walk in walks]
    keys = align(walks) if len(walks) > 1 else (_one_key(first),)
    stride = float(np.mean([w.length * p.stride / w.strides for w, p in zip(walks, paces, strict=True)]))
    way = way_on(path, stride, first.rig.leg_length, _until(path, params, walks, paces), params)
    wanted, notes = transitions_of(walks, keys, paces, ats, path, way, params, holding)
    timeline, more = timeline_of(path, way, walks, keys, paces, wanted, params)
    made = lay_walks(path, way, walks, timeline, params, paced=paced(paces))
    return _finished(made, path, walks, timeline, holding, (*path.notes, *notes, *more))


def _one_key(walk: Walk) -> Keys:
    return Keys(np.zeros(1), np.zeros(1), walk.strides, walk.frames)


def _path(points: Floats, walks: Sequence[Walk], params: FollowParams, relative: bool) -> Path:
    """Make the path in the world, with kinks no sharper than a stance can turn."""
    if relative:
        x, z, heading = walks[0].start
        c, s = np.cos(heading), np.sin(heading)
        left, ahead = np.asarray(points, dtype=np.float64).T
        points = np.stack([x + left * c + ahead * s, z - left * s + ahead * c], axis=1)
    stance = max(_stance_way(walk) for walk in walks)
    sharpest = np.radians(params.stance_turn) / max(params.shortest * stance, 0.05)
    size = walks[0].rig.leg_length
    if params.stride:  # strides are the shorter, the sharper it is
        shorter = [np.radians(params.stance_turn) / (s * stance) for s in np.linspace(params.shortest, 1.0, 101)]
        fits = [k for k, s in zip(shorter, np.linspace(params.shortest, 1.0, 101), strict=True)
                if s >= 1.0 - params.shrink * size * k]  # fmt: skip
        sharpest = max(fits, default=sharpest)
    else:
        sharpest = np.radians(params.stance_turn) / stance
    return make_path(points, sharpest=float(sharpest), kink=np.radians(params.kink))


def _stance_way(walk: Walk) -> float:
    """Compute the mean distance walked during a stance [m]."""
    own = [e for e, sole in enumerate(walk.rig.soles) if sole.leg == 0]
    share = float(walk.contacts.mask()[:-1, own].any(axis=1).mean())
    return share * walk.length / walk.strides


def _until(path: Path, params: FollowParams, walks: Sequence[Walk], paces: Sequence[Pace]) -> float:
    """Compute an upper bound on the distance walked [m]."""
    if params.seconds is None:
        return path.length
    fastest = max(w.speed * p.stride / p.time for w, p in zip(walks, paces, strict=True))
    return max(path.length, params.seconds * fastest) if path.closed else path.length


def _finished(
    made: Laid, path: Path, walks: Sequence[Walk], timeline: Timeline, holding: EnforceParams, notes: tuple[Note, ...]
) -> Follow:  # fmt: skip
    """Cut the ends off, and hold what still slides."""
    lead = timeline.first
    some = slice(lead, len(timeline) - lead)
    clip, laid = made.clip.frames(some), made.laid.frames(some)
    contacts = contacts_of(made.posed, some)
    changed: Bools = np.asarray(_changes(made, timeline))
    needed = bool(changed[some].any())
    found = held_on(clip, made.posed.rig, contacts, holding, needed=needed)
    plants = tuple(replace(p, outcome="pinned") if needed and p.outcome == "kept" else p for p in found.plants)
    clip, straight = apply(clip, found.correction), made.posed.clip.frames(some)
    plants = as_straight(plants, clip, straight, timeline.gone[some], made.posed.rig)
    walked = _walked(made, path, clip, some)
    frames = _like(walks[0], timeline, some)
    notes = (*notes, *_too_much(walked, plants))
    return Follow(
        clip, laid, straight, made.posed.rig, contacts, path, walked, timeline.transitions,
        tuple(walks), frames, plants, _correction(laid, clip, made.posed.rig), (*notes, *found.notes),
    )  # fmt: skip


def _too_much(walked: Walked, plants: Sequence[Footplant]) -> tuple[Note, ...]:
    """Make notes where a path demands more than a figure could do."""
    notes: tuple[Note, ...] = ()
    at = int(np.argmax(np.abs(walked.lean)))
    lean, speed = abs(float(walked.lean[at])), float(walked.speed[at])
    if lean > _GRIP:
        most = speed * np.sqrt(np.tan(_GRIP) / np.tan(lean))
        text = (
            f"at {speed:.1f} m/s the figure leans by {np.degrees(lean):.0f} degrees {walked.arc[at]:.1f} m on, where "
            f"feet would slip; a wider curve, or a speed below {most:.1f} m/s, keeps them on the floor"
        )
        notes += (Note("too-fast", text),)
    let_go = sum(plant.outcome in ("released", "partly") for plant in plants)
    if let_go:
        text = (
            f"{let_go} of {len(plants)} plants are not held throughout: the path turns by more than the legs reach "
            "while a foot stands; a wider curve holds them"
        )
        notes += (Note("feet-let-go", text),)
    return notes


def _correction(laid: Clip, clip: Clip, rig: Rig) -> Correction:
    """Compute the correction from one clip to another with another root and other leg rotations."""
    shift = root_in_world(clip, rig.root)[0] - root_in_world(laid, rig.root)[0]
    joints = [joint for leg in rig.legs for joint in (*leg.chain, *(() if leg.toe is None else (leg.toe,)))]
    turned = [joint for joint in joints if np.any(clip.rotation(joint) != laid.rotation(joint))]
    turns = np.stack([clip.rotation(joint) for joint in turned], axis=1) if turned else np.zeros((len(clip), 0, 4))
    return Correction(rig.root, shift, tuple(turned), turns)


def _changes(made: Laid, timeline: Timeline) -> Bools:
    """Mark frames (F,) in which anything differs from a straight walk."""
    return np.asarray(timeline.blended() | (made.scale != 1.0) | (made.lean.angle != 0.0) | _any_turn(made))


def _any_turn(made: Laid) -> bool:
    return made.clip is not made.laid


def _walked(made: Laid, path: Path, clip: Clip, some: slice) -> Walked:
    root = pelvis_of(clip, made.posed.rig)[:, [0, 2]]
    stride = float(np.median(made.stride[some]))
    arc = made.arc[some]
    whole = pelvis_of(made.laid, made.posed.rig)[:, [0, 2]].copy()
    whole[some] = root
    heading = path.heading(made.arc)
    left = np.stack([np.cos(heading), -np.sin(heading)], axis=1)
    off = averaged(np.einsum("fk,fk->f", whole - path.position(made.arc), left), stride)
    mean = np.stack([averaged(each, stride) for each in whole.T], axis=1)
    lowered = made.lean.lower if made.lean.lower is not None else np.zeros(len(made.arc))
    return Walked(
        arc, mean[some], off[some], averaged(made.speed, stride)[some], made.scale[some], made.lean.angle[some],
        made.aside[some], made.balance[some], lowered[some],
    )  # fmt: skip


def _like(walk: Walk, timeline: Timeline, some: slice) -> Ints:
    """Find the frames (F,) of the first captured clip whose poses are nearest to each frame's."""
    first = timeline.zones[0].at[0][some]
    frames = walk.loop.frames
    return np.asarray(frames[np.rint(first).astype(np.intp) % min(walk.frames, len(frames))])
