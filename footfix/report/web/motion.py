"""What the page needs of the motion: joints, sole points and their speeds, before and after."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from footfix.measure.skinned_joints import FEWEST, counted
from footfix.motion.clip import Bools, Clip, Floats, Ints, frozen
from footfix.motion.contacts import Contacts
from footfix.motion.kinematics import forward
from footfix.motion.threads import at_once
from footfix.report.web.bones import bones_of
from footfix.report.web.feet import SolePart, sole_parts
from footfix.report.web.pack import pack, quantize
from footfix.rig.rig import Rig

SHOWN_FRAMES = 7200  # as many as a page holds: a minute at 120 fps


def display_frames(frames: int, most: int = SHOWN_FRAMES) -> Ints:
    """Choose the frames that a page shows: every one, or every n-th where there are more than `most`."""
    return np.arange(0, frames, max(1, -(-frames // most)), dtype=np.intp)


@dataclass(frozen=True)
class Lines:
    """Lines to draw into the curves of height and speed, and what they mean.

    Args:
        height: [m] above the floor.
        speed: [m/s] over the floor.
        meaning: for people.
    """

    height: float = 0.05
    speed: float = 0.5
    meaning: str = "the bounds of the foot skating ratio"


@dataclass(frozen=True, eq=False)
class Motion:
    """A figure before and after, at the frames that are shown.

    Args:
        frames: frames of the whole clip.
        step: every how many frames one is shown.
        frame_time: [s] between frames of the clip.
        names: (J,) joints, End Sites, and places where a foot without toe joint would have it; only joints have a name.
        parents: (J,) -1 for a root.
        root: the joint that carries the figure's travel.
        bones: (parent, child) joints that a line is drawn between.
        hips: the joint at the top of each leg and its side: "left", "right" or "" where it has none.
        legs: hip, knee and ankle of each leg.
        leg_names: the name of each leg, `front_left`.
        soles: (E,) the joint that carries each sole point, in the order of the contacts' effectors.
        sole_names: (E,) their names, `left_heel`.
        seen: (E,) the joint that the slide is measured on: of a toe the toe joint, or the place where it would be; of a
            heel the ankle. -1 where the sole point is measured.
        by_sole: (D, E) where the sole point is measured in place of that joint: a heel planted without its toe.
        counts: (D, E) the frames of plants that count for the slide.
        ground: (D, 3) [m] how far the ground under planted feet has moved, as on a treadmill.
        joints_before, joints_after: (D, J, 3) [m] y up.
        soles_before, soles_after: (D, E, 3) [m].
        speeds_before, speeds_after: (D, E) [m/s] horizontal speed of what is measured, over the ground.
        floor: [m] height of the floor.
        meshes: the soles of a skin, where one was given.
    """

    frames: int
    step: int
    frame_time: float
    names: tuple[str, ...]
    parents: tuple[int, ...]
    root: int
    bones: tuple[tuple[int, int], ...]
    hips: tuple[tuple[int, str], ...]
    legs: tuple[tuple[int, int, int], ...]
    leg_names: tuple[str, ...]
    soles: tuple[int, ...]
    sole_names: tuple[str, ...]
    seen: tuple[int, ...]
    by_sole: Bools
    counts: Bools
    ground: Floats
    joints_before: Floats
    joints_after: Floats
    soles_before: Floats
    soles_after: Floats
    speeds_before: Floats
    speeds_after: Floats
    floor: float
    meshes: tuple[SolePart, ...] = ()

    def __post_init__(self) -> None:
        for key in ("joints", "soles", "speeds"):
            for when in ("before", "after"):
                object.__setattr__(self, f"{key}_{when}", frozen(getattr(self, f"{key}_{when}")))


def film(
    before: Clip, after: Clip, rig: Rig, contacts: Contacts | None = None, ground: Floats | None = None,
    most: int = SHOWN_FRAMES,
) -> Motion:  # fmt: skip
    """Gather the motion of a page from the clip before and after.

    Args:
        before, after: the clip as read and as written [m], y up.
        rig: its legs and sole points.
        contacts: when each sole point is planted, in the order of `rig.soles`; without them never.
        ground: (F, 3) [m] how far the ground under planted feet has moved, as on a treadmill; at rest by default.
        most: frames that the page may hold.
    """
    shown = display_frames(len(before), most)
    skeleton = before.skeleton
    clips = (before,) if after is before else (before, after)
    points = at_once([partial(_points, clip.frames(shown), rig) for clip in clips], len(shown))
    first, second = points[0], points[-1]
    ends = skeleton.end_parents.tolist()
    parents = (*skeleton.parents.tolist(), *ends)
    without = [k for k, sole in enumerate(rig.soles) if sole.held is not None]  # of feet without toe joint
    seen = tuple(
        len(parents) + without.index(k) if k in without else _seen_joint(rig, k) for k in range(len(rig.soles))
    )
    by_sole, counts = _looked_at(rig, seen, len(before), contacts)
    moved = np.zeros((len(before), 3)) if ground is None else ground
    was, now = (_speeds(clip, rig, shown, seen, by_sole[shown], moved) for clip in (before, after))
    return Motion(
        frames=len(before), step=int(shown[1] - shown[0]) if len(shown) > 1 else 1, frame_time=before.frame_time,
        names=(*skeleton.names, *("" for _ in (*ends, *without))),
        parents=(*parents, *(rig.soles[k].joint for k in without)), root=rig.root,
        bones=bones_of(parents, len(skeleton), first[0]),
        hips=tuple((leg.hip, side_of(leg.side)) for leg in rig.legs),
        legs=tuple((leg.hip, leg.knee, leg.ankle) for leg in rig.legs),
        leg_names=tuple(leg.name for leg in rig.legs),
        soles=tuple(sole.joint for sole in rig.soles), sole_names=tuple(sole.name for sole in rig.soles),
        seen=seen, by_sole=by_sole[shown], counts=counts[shown], ground=moved[shown],
        joints_before=first[0], joints_after=second[0], soles_before=first[1], soles_after=second[1],
        speeds_before=was, speeds_after=now, floor=rig.floor,
        meshes=sole_parts(before, rig),
    )  # fmt: skip


def seen_tracks(motion: Motion) -> tuple[Floats, Floats]:
    """Get the tracks that slides are measured on, before and after: (D, E, 3), (D, E, 3) [m] over the ground."""
    joints = np.maximum(motion.seen, 0)
    pairs = ((motion.joints_before, motion.soles_before), (motion.joints_after, motion.soles_after))
    first, second = (np.where(motion.by_sole[..., None], soles, places[:, joints]) for places, soles in pairs)
    return first - motion.ground[:, None], second - motion.ground[:, None]


def _seen_joint(rig: Rig, sole: int) -> int:
    """Find the joint that the slide of a sole point is measured on, -1 where there is none."""
    leg = rig.legs[rig.soles[sole].leg]
    if rig.soles[sole].part == "heel":
        return leg.ankle
    return -1 if leg.toe is None else leg.toe


def _looked_at(
    rig: Rig, seen: tuple[int, ...], frames: int, contacts: Contacts | None
) -> tuple[Bools, Bools]:
    """Mark where the sole point itself is measured, not a joint, (F, E), and the frames of plants that count, (F, E).
    """
    by_sole, counts = (np.zeros((frames, len(seen)), dtype=np.bool_) for _ in range(2))
    by_sole[:, [joint < 0 for joint in seen]] = True
    spans = [[c for c in each.contacts if c.wish != "forbid"] for each in contacts.effectors] if contacts else []
    for k, own in enumerate(spans[: len(seen)]):
        for contact in own:
            counts[slice(*counted(contact)), k] = True
    toes = {sole.leg: k for k, sole in enumerate(rig.soles) if sole.part == "toe"}
    for k, own in enumerate(spans[: len(seen)]):
        sole = rig.soles[k]
        if sole.part != "heel":
            continue
        stands = counts[:, toes[sole.leg]] if sole.leg in toes else np.zeros(frames, dtype=np.bool_)
        for contact in own:
            span = slice(*counted(contact))
            if np.count_nonzero(stands[span]) < FEWEST:
                by_sole[contact.start : contact.end, k] = True
            else:
                counts[span, k] &= stands[span]
    return by_sole, counts


def side_of(name: str) -> str:
    """Read the side from the name of a leg or an effector: "left", "right" or ""."""
    return next((side for side in ("left", "right") if side in name.lower()), "")


def _points(clip: Clip, rig: Rig) -> tuple[Floats, Floats]:
    """Compute joints, End Sites and toes held without a toe joint (D, J, 3), and sole points (D, E, 3) [m]."""
    pose = forward(clip)
    skeleton = clip.skeleton
    count = len(skeleton)
    # in memory order of the packed series, which halves the time of packing
    carried = list(zip(skeleton.end_parents.tolist(), skeleton.end_offsets, strict=True))
    carried += [rig.held_at(sole) for sole in rig.soles if sole.held is not None]
    joints = np.empty((count + len(carried), 3, len(clip)))
    joints[:count] = pose.positions.transpose(1, 2, 0)
    for k, (parent, offset) in enumerate(carried):
        joints[count + k] = pose.point(parent, offset).T
    soles = np.empty((len(rig.soles), 3, len(clip)))
    for k, track in enumerate(rig.tracks(pose)):
        soles[k] = track.T
    return joints.transpose(2, 0, 1), soles.transpose(2, 0, 1)


def _speeds(
    clip: Clip, rig: Rig, shown: Ints, seen: tuple[int, ...], by_sole: Bools, ground: Floats
) -> Floats:
    """Compute the horizontal speed over the ground of what is measured, (D, E) [m/s], by central differences."""
    if len(clip) < 2 or not rig.soles:
        return np.zeros((len(shown), len(rig.soles)))
    behind, ahead = np.maximum(shown - 1, 0), np.minimum(shown + 1, len(clip) - 1)
    pose = rig.pose(clip.frames(np.concatenate([behind, ahead])))
    rolled = ground[ahead] - ground[behind]  # (D, 3) [m]

    def pace(track: Floats) -> Floats:  # (2 D, 3) [m]
        step = track[len(shown) :] - track[: len(shown)] - rolled
        return np.asarray(np.hypot(step[:, 0], step[:, 2]) / ((ahead - behind) * clip.frame_time))

    soles = np.stack([pace(track) for track in rig.tracks(pose)], axis=1)
    joints = [
        pace(pose.position(joint)) if sole.part == "heel" else pace(pose.point(*rig.held_at(sole)))
        for joint, sole in zip(seen, rig.soles, strict=True)
    ]
    return np.where(by_sole, soles, np.stack(joints, axis=1))


_JOINT, _POINT, _SPEED = 5e-4, 1e-4, 1e-3  # units of the packed integers [m, m, m/s]


def packed(motion: Motion, lines: Lines) -> dict[str, Any]:
    """Pack the motion as the page's script reads it (codec.js), as plain JSON values.

    Corrections mostly shift the whole figure and turn a few joints of the legs, so of the figure after cleaning only
    the root's shift is written, and the joints that move otherwise.
    """
    before = quantize(motion.joints_before, _JOINT)
    points, points_after = (quantize(each, _POINT) for each in (motion.soles_before, motion.soles_after))
    speeds, speeds_after = (quantize(each, _SPEED) for each in (motion.speeds_before, motion.speeds_after))
    return {
        "shown": len(before),
        "frames": motion.frames,
        "step": motion.step,
        "frameTime": motion.frame_time,
        "parents": list(motion.parents),
        "root": motion.root,
        "bones": [list(bone) for bone in motion.bones],
        "hips": [list(hip) for hip in motion.hips],
        "legs": [[*leg, name] for leg, name in zip(motion.legs, motion.leg_names, strict=True)],
        "soles": list(motion.soles),
        "seen": list(motion.seen),
        "floor": motion.floor,
        **({"meshes": [part.packed() for part in motion.meshes]} if motion.meshes else {}),
        "ground": pack(quantize(motion.ground, _POINT)) if motion.ground.any() else None,
        "lines": {"height": lines.height, "speed": lines.speed},
        "quantum": {"joints": _JOINT, "points": _POINT, "speeds": _SPEED},
        "joints": {"before": pack(before), **_packed_change(motion)},
        "points": {"before": pack(points), "after": _packed_unless_same(points, points_after)},
        "speeds": {"before": pack(speeds), "after": _packed_unless_same(speeds, speeds_after)},
    }


def _packed_unless_same(first: NDArray[np.int32], second: NDArray[np.int32]) -> str | None:
    return None if np.array_equal(first, second) else pack(second)


def _packed_change(motion: Motion) -> dict[str, Any]:
    """Pack the change of the joints: the shift of the root, and the joints that move otherwise."""
    if motion.joints_after is motion.joints_before:
        return {"shift": None, "moved": [], "own": ""}
    change = motion.joints_after - motion.joints_before  # (D, J, 3) [m]
    shift = change[:, motion.root]
    own = change - shift[:, None]
    moved = np.flatnonzero(np.abs(own).max(axis=(0, 2), initial=0.0) > _JOINT / 2)
    if not moved.size and not np.any(np.abs(shift) > _JOINT / 2):
        return {"shift": None, "moved": [], "own": ""}
    steps = quantize(shift, _JOINT)
    return {"shift": pack(steps), "moved": moved.tolist(), "own": pack(quantize(own[:, moved], _JOINT))}
