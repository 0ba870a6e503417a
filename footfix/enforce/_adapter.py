"""The interface of enforcement to come, on the enforcement that is there. To be deleted with the latter."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from footfix.enforce import run
from footfix.enforce.correction import Correction
from footfix.enforce.footplant import Footplant as Old
from footfix.enforce.footplant import Outcome
from footfix.enforce.run import EnforceParams
from footfix.motion.clip import Clip, Floats
from footfix.motion.contacts import Contact, Contacts, Part
from footfix.notes import Note
from footfix.rig.rig import Rig


@dataclass(frozen=True)
class Footplant:
    id: int
    effector: int
    name: str
    leg: int
    part: Part
    start: int
    end: int
    confidence: float
    force: bool
    asked: tuple[float, float, float] | None
    target: tuple[float, float, float]
    outcome: Outcome = "pinned"
    reason: str = ""
    residual: float = 0.0
    held: tuple[tuple[int, int], ...] = ()


@dataclass(frozen=True, eq=False)
class Enforcement:
    plants: tuple[Footplant, ...]
    correction: Correction
    notes: tuple[Note, ...]
    ground: Floats


def enforce(
    clip: Clip, rig: Rig, contacts: Contacts, params: EnforceParams, *, cut: tuple[bool, bool] = (False, False)
) -> Enforcement:
    old = run.enforce(clip, rig, contacts, params)
    plants: list[Footplant] = []
    for e, (sole, effector) in enumerate(zip(rig.soles, contacts.effectors, strict=True)):
        for contact in (each for each in effector.contacts if each.wish != "forbid"):
            parts = [
                each for each in old.plants
                if each.effector == sole.name and each.start < contact.end and each.end > contact.start
            ]  # fmt: skip
            plants.append(_one(len(plants), e, rig, contact, parts))
    return Enforcement(tuple(plants), old.correction, old.notes, old.ground)


def _one(number: int, e: int, rig: Rig, contact: Contact, parts: Sequence[Old]) -> Footplant:
    sole = rig.soles[e]
    outcomes: set[Outcome] = {each.outcome for each in parts}
    outcome: Outcome = outcomes.pop() if len(outcomes) == 1 else "partly" if outcomes else "released"
    longest = max(parts, key=lambda each: each.end - each.start, default=None)
    return Footplant(
        number, e, sole.name, sole.leg, sole.part, contact.start, contact.end, contact.confidence,
        contact.wish == "force", contact.position, longest.target if longest else (0.0, 0.0, 0.0), outcome,
        next((each.reason for each in parts if each.reason), ""),
        max((each.residual for each in parts), default=0.0),
        tuple((each.start, each.end) for each in parts if each.outcome != "released"),
    )  # fmt: skip
