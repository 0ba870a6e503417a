"""Contact labels as they were read, and how they are held against a clip."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import pairwise

from footfix.errors import InputError
from footfix.motion.contacts import Contact, Contacts, Effector


@dataclass(frozen=True)
class Labels:
    """Labels as a file gives them, not yet held against a clip.

    Args:
        effectors: contacts by effector name; an effector that is not named is left to the detector.
        frames: frames of the clip they were made for, if the file says.
        source: name of the file, for messages.
        by_steps: True where the rows may be of the steps between frames, one fewer than frames, as where contacts
            come from speeds; the last row then holds for the last two frames.
    """

    effectors: Mapping[str, tuple[Contact, ...]]
    frames: int | None = None
    source: str = "labels"
    by_steps: bool = False


def put(effectors: dict[str, tuple[Contact, ...]], effector: str, contacts: tuple[Contact, ...], name: str) -> None:
    """Add the contacts of an effector; raises InputError where it has some already."""
    if effector in effectors:
        raise InputError(f"effector {effector} is listed twice", file=name)
    effectors[effector] = contacts


def fit(labels: Labels, blank: Contacts) -> tuple[Contacts, frozenset[str]]:
    """Match labels to a clip: its frames, its effectors.

    Args:
        labels: what a file says.
        blank: the effectors of the clip's rig, nothing in contact.

    Returns:
        Contacts with what the labels say, and the names of the effectors that are left to the detector:
        those the labels do not name, and those for which they only forbid.

    Raises:
        InputError: other frames, unknown effectors, contacts that overlap or lie outside the clip.
    """
    if labels.by_steps and labels.frames == blank.frames - 1:
        labels = _to_last_frame(labels)
    if labels.frames is not None and labels.frames != blank.frames:
        raise InputError(
            f"the labels are for {labels.frames} frames, the clip has {blank.frames}",
            file=labels.source, hint="take the labels of this very clip",
        )  # fmt: skip
    known = {_key(name): name for name in blank.names}
    given: dict[str, tuple[Contact, ...]] = {}
    for name, contacts in labels.effectors.items():
        if _key(name) not in known:
            raise InputError(
                f"the clip has no effector {name!r}", file=labels.source, hint=f"it has {', '.join(blank.names)}"
            )
        put(given, known[_key(name)], _in_order(contacts, name, blank.frames, labels.source), labels.source)
    open_ones = frozenset(
        name
        for name in blank.names
        if name not in given or (given[name] and all(c.wish == "forbid" for c in given[name]))
    )
    effectors: tuple[Effector, ...] = tuple(
        replace(effector, contacts=given.get(effector.name, ())) for effector in blank.effectors
    )
    return replace(blank, effectors=effectors, method="labels"), open_ones


def _to_last_frame(labels: Labels) -> Labels:
    """Convert labels with a row for each step between frames to a row for each frame."""
    rows = labels.frames or 0
    longer = {
        name: tuple(replace(each, end=each.end + (each.end == rows)) for each in contacts)
        for name, contacts in labels.effectors.items()
    }
    return replace(labels, effectors=longer, frames=rows + 1)


def _key(name: str) -> str:
    return re.sub(r"[^a-z0-9]", "", name.lower())


def _in_order(contacts: tuple[Contact, ...], effector: str, frames: int, source: str) -> tuple[Contact, ...]:
    ordered = tuple(sorted(contacts, key=lambda contact: contact.start))
    for contact in ordered:
        if not 0 <= contact.start < contact.end <= frames:
            raise InputError(
                f"{effector}: contact {contact.start}-{contact.end} does not fit a clip of {frames} frames", file=source
            )
    for before, after in pairwise(ordered):
        if after.start < before.end:
            raise InputError(
                f"{effector}: contacts {before.start}-{before.end} and {after.start}-{after.end} overlap", file=source
            )
    return ordered


def merge(given: Contacts, detected: Contacts, open_ones: frozenset[str]) -> Contacts:
    """Take labels where they speak, the detector's contacts for effectors they leave open, less what is forbidden."""
    effectors = []
    for label, found in zip(given.effectors, detected.effectors, strict=True):
        if label.name not in open_ones:
            effectors.append(label)
            continue
        left = list(found.contacts)
        for ban in label.contacts:
            left = [piece for contact in left for piece in _without(contact, ban.start, ban.end)]
        effectors.append(replace(found, contacts=tuple(sorted([*left, *label.contacts], key=lambda c: c.start))))
    method = "labels" if not open_ones else f"labels+{detected.method}"
    return replace(given, effectors=tuple(effectors), method=method, notes=detected.notes)


def _without(contact: Contact, start: int, end: int) -> list[Contact]:
    pieces = [(contact.start, min(contact.end, start)), (max(contact.start, end), contact.end)]
    return [replace(contact, start=a, end=b) for a, b in pieces if a < b]
