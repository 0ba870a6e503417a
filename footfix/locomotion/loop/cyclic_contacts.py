"""Contacts of a closed cycle, the same at its last frame as at its first."""

from __future__ import annotations

from dataclasses import replace

from footfix.motion.contacts import Contact, Contacts, Effector

_BRIEF = 0.05  # [s] a shorter remainder of a contact at the seam that does not continue across it is dropped


def wrapped(contacts: Contacts, start: int, length: int) -> Contacts:
    """Make the contacts of a cycle.

    Args:
        contacts: of the clip that it was cut from.
        start: the frame that became its first.
        length: frames of one round; the cycle has one more, which repeats the first.
    """
    effectors = tuple(_wrapped(each, start, length, _BRIEF / contacts.frame_time) for each in contacts.effectors)
    return replace(contacts, frames=length + 1, effectors=effectors, notes=())


def _wrapped(effector: Effector, start: int, length: int, brief: float) -> Effector:
    inside = []
    for contact in effector.contacts:
        a, b = max(contact.start - start, 0), min(contact.end - start, length + 1)
        if b > a:
            inside.append(replace(contact, start=a, end=b))
    spoken = [each for each in inside if each.wish != "forbid"]
    first = next((each for each in spoken if each.start == 0), None)
    last = next((each for each in reversed(spoken) if each.end >= length), None)
    if first is None and last is not None:
        # it goes on over the seam by the frame that is the first one again, or ends before it
        inside = _changed(inside, last, replace(last, end=length + 1), [Contact(0, 1, last.confidence)], brief)
    elif last is None and first is not None:
        more = [Contact(length, length + 1, first.confidence)]
        inside = _changed(inside, first, first, more, brief)
    elif first is not None and last is not None and last is not first:
        inside[inside.index(last)] = replace(last, end=length + 1)
    return replace(effector, contacts=tuple(sorted(inside, key=lambda each: each.start)))


def _changed(
    inside: list[Contact], old: Contact, new: Contact, more: list[Contact], brief: float
) -> list[Contact]:
    """Join a contact at the seam with its continuation; drop it where it is too short."""
    rest = [each for each in inside if each is not old]
    return rest if old.end - old.start < brief and old.wish is None else [*rest, new, *more]
