"""Bring plants and correction of repeated rounds of a cyclic clip back to one round, with a closed seam."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from footfix.enforce.correction import Correction
from footfix.enforce.footplant import Footplant
from footfix.motion import rotation
from footfix.motion.clip import Floats
from footfix.motion.contacts import Contact, Contacts
from footfix.motion.kinematics import forward
from footfix.notes import Note
from footfix.rig.repeated_rounds import Rounds
from footfix.rig.rig import Rig

_CLOSED = 0.001  # [m] if the last frame is nearer to the first than this, they are the same pose


def plants_back(found: tuple[Footplant, ...], rounds: Rounds, contacts: Contacts, rig: Rig) -> tuple[Footplant, ...]:
    """Report for each contact of a clip the outcome found in the repeated rounds.

    Args:
        found: the plants of all rounds; a plant across the seam is one plant there.
        rounds: of the clip.
        contacts: of the clip, where a plant across the seam is two contacts.
        rig: its sole points.

    Returns:
        The footplants by effector, then time.
    """
    made: list[Footplant] = []
    for e, (sole, effector) in enumerate(zip(rig.soles, contacts.effectors, strict=True)):
        own = [plant for plant in found if plant.effector == e]
        for c in effector.contacts:
            if c.wish == "forbid" or c.end <= c.start:
                continue
            plain = Footplant(
                len(made), e, sole.name, sole.leg, sole.part, c.start, c.end, c.confidence, c.wish == "force"
            )
            made.append(_back(plain, own, rounds, c))
    return tuple(made)


def _back(plain: Footplant, own: list[Footplant], rounds: Rounds, contact: Contact) -> Footplant:
    start, frames = rounds.within.start, len(rounds.whole)
    at = start + contact.start
    laid = next((plant for plant in own if plant.start <= at < plant.end), None)
    if laid is None:
        return plain
    held = ((max(a - start, 0), min(b - start, frames)) for a, b in laid.held)
    return replace(
        laid, id=plain.id, start=plain.start, end=plain.end, confidence=plain.confidence, force=plain.force,
        asked=laid.asked if contact.position else None,
        held=tuple((max(a, plain.start), min(b, plain.end)) for a, b in held if a < plain.end and b > plain.start),
    )  # fmt: skip


def correction_back(found: Correction, rounds: Rounds) -> Correction:
    """Cut the correction of all rounds to the clip, closed at its seam.

    The rounds' corrections are nearly, but not exactly, the same. From the clip's first frame to its last, its own
    correction is blended into that of the round before, which ends where the clip begins. Where the clip's own ends
    differ, its last frame needs another correction than its first: a foot planted across the seam is held in both.
    """
    within, n = rounds.within, rounds.cycle.frames
    before = slice(within.start - n, within.stop - n)
    shift, rotations = found.root_shift[within], found.rotations[within]
    turns = [rounds.whole.rotation(joint) for joint in found.joints]
    if len(shift) > n and _open(rounds)[0] > _CLOSED:
        return replace(found, root_shift=shift, rotations=rotations)  # both ends get the same correction
    u = np.arange(len(shift)) / n
    u = u * u * (3.0 - 2.0 * u)
    earlier = rotation.rotate(rotation.about_vertical(rounds.cycle.yaw), found.root_shift[before])
    shift = shift + u[:, None] * (earlier - shift)
    led = rotations.copy()
    for k, turn in enumerate(turns):
        own, other = rotations[:, k], found.rotations[before, k]
        other = rotation.multiply(other, _between(rounds.clip.rotation(found.joints[k])[before], turn))
        change = (np.any(own != turn, axis=1) | np.any(found.rotations[before, k] != turn, axis=1))[:, None]
        led[:, k] = np.where(change, rotation.slerp(own, other, u), own)
    return replace(found, root_shift=shift, rotations=led)


def _between(a: Floats, b: Floats) -> Floats:
    """Compute the rotations from some to others, both (n, 4), in the frame of the first."""
    return rotation.multiply(rotation.inverse(a), b)


def cycle_note(rounds: Rounds) -> Note:
    """Say that a clip is a cycle, and how far its last frame is from its first where it repeats that."""
    seconds = rounds.cycle.frames * rounds.whole.frame_time
    off, joint = _open(rounds) if len(rounds.whole) > rounds.cycle.frames else (0.0, "")
    but = f", but for {1000.0 * off:.0f} mm at {joint}, which stay (`footfix loop` closes a clip)"
    text = (
        f"the clip is a cycle of {seconds:.2f} s: its last frame leads to the first{but if off > _CLOSED else ''}, and "
        "contacts and correction go on over the seam (enforce.cycle=no leaves it open)"
    )
    return Note("cycle", text)


def _open(rounds: Rounds) -> tuple[float, str]:
    """Find the joint farthest apart, seen from the root, in the first and last frame: distance [m] and name."""
    ends = rounds.whole.frames(np.array([0, len(rounds.whole) - 1]))
    pose = forward(ends)
    place, turn = pose.position(rounds.root), pose.rotation(rounds.root)
    seen = rotation.rotate(rotation.inverse(turn)[:, None], pose.positions - place[:, None])  # (2, J, 3)
    off = np.linalg.norm(seen[1] - seen[0], axis=1)
    worst = int(np.argmax(off))
    return float(off[worst]), ends.skeleton.names[worst]
