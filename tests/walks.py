"""Walkers with a rig, for the tests of enforcement: what stands where is known exactly."""

from __future__ import annotations

import hashlib
from functools import cache

import numpy as np
from once import remembered
from walker import Walk, make
from walker_gaits import Gait

from footfix.enforce.correction import apply
from footfix.enforce.params import EnforceParams
from footfix.enforce.run import Enforcement, enforce
from footfix.motion.clip import Clip, Floats
from footfix.motion.contacts import Contacts
from footfix.rig.rig import Leg, Rig, SolePoint


@cache
def walk(name: str = "walk", fps: float = 60.0, duration: float = 3.0) -> Walk:
    """One of the gaits, made once."""
    return make(Gait(name=name, fps=fps, duration=duration))  # type: ignore[arg-type]


def short_walk(name: str = "walk", fps: float = 60.0, duration: float = 2.0) -> Walk:
    """One of the gaits for two seconds, which is enough for most of enforcement."""
    return walk(name, fps, duration)


def rig_of(made: Walk) -> Rig:
    """The walker's rig as it was built, nothing guessed."""
    at = made.clip.skeleton.names.index
    legs, soles = [], []
    for k, side in enumerate(("Left", "Right")):
        hip, knee, ankle, toe = (at(side + part) for part in ("UpLeg", "Leg", "Foot", "ToeBase"))
        legs.append(Leg(side.lower(), side.lower(), hip, knee, ankle, toe, (hip, knee, ankle)))
        for part, (joint, offset) in zip(("heel", "toe"), made.soles[2 * k : 2 * k + 2], strict=True):
            soles.append(SolePoint(f"{side.lower()}_{part}", k, part, at(joint), offset))  # type: ignore[arg-type]
    return Rig(0, 0, tuple(legs), tuple(soles), made.gait.leg, made.floor)


def slides(clip: Clip, rig: Rig, contacts: Contacts) -> dict[str, list[float]]:
    """[mm] for heels and for toes, how far each planted one is from its median place over the floor."""
    found: dict[str, list[float]] = {"heel": [], "toe": []}
    tracks = rig.tracks(rig.pose(clip))
    for sole, track, effector in zip(rig.soles, tracks, contacts.effectors, strict=True):
        for contact in effector.contacts:
            places = track[contact.start : contact.end][:, [0, 2]]
            far = np.linalg.norm(places - np.median(places, axis=0), axis=1).max()
            found[sole.part].append(1000.0 * float(far))
    return found


def heights(clip: Clip, rig: Rig, contacts: Contacts) -> Floats:
    """[mm] height of every planted point in every frame over the rig's floor."""
    tracks = rig.tracks(rig.pose(clip))
    return 1000.0 * np.concatenate([
        track[contact.start : contact.end, 1] - rig.floor
        for track, effector in zip(tracks, contacts.effectors, strict=True)
        for contact in effector.contacts
    ])  # fmt: skip


def straightness(clip: Clip, rig: Rig) -> Floats:
    """(F, legs) how straight each leg is, of its length."""
    pose = rig.pose(clip)
    columns = []
    for leg in rig.legs:
        hip, knee, ankle = (pose.position(joint) for joint in (leg.hip, leg.knee, leg.ankle))
        length = np.linalg.norm(knee - hip, axis=1) + np.linalg.norm(ankle - knee, axis=1)
        columns.append(np.linalg.norm(ankle - hip, axis=1) / length)
    return np.stack(columns, axis=1)


def extension(clip: Clip, rig: Rig) -> float:
    """How straight the straightest leg is, of its length."""
    return float(straightness(clip, rig).max())


def cleaned(
    clip: Clip, rig: Rig, contacts: Contacts, params: EnforceParams | None = None
) -> tuple[Clip, Enforcement]:
    """The clip with its plants enforced; the same clip is enforced once for all tests of a run."""
    params = params or EnforceParams()
    skeleton = clip.skeleton
    bones = skeleton.parents, skeleton.offsets, skeleton.end_parents, skeleton.end_offsets
    numbers = b"".join(array.tobytes() for array in (clip.positions, clip.rotations, *bones))
    words = repr((clip.frame_time, skeleton.translates, skeleton.rotates, rig, contacts, params))

    def make() -> tuple[Clip, Enforcement]:
        found = enforce(clip, rig, contacts, params)
        return apply(clip, found.correction), found

    return remembered(hashlib.sha256(numbers + words.encode()).hexdigest(), make)
