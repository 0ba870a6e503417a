"""Contacts as events, which engines fire sounds and footprints by: when each sole point strikes and lifts."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from footfix.motion.contacts import Contacts

FORMAT, VERSION = "footfix-events", 1


def events_of(contacts: Contacts, *, start: float = 0.0) -> list[dict[str, Any]]:
    """List when sole points strike and lift, in the order of time.

    What stands in the first frame strikes there; what stands in the last one does not lift.

    Args:
        contacts: when each effector is planted.
        start: [s] the time of the first frame, as players count it.
    """
    found = []
    for effector in contacts.effectors:
        for contact in effector.contacts:
            if contact.wish == "forbid":
                continue
            both = [("strike", contact.start)] + ([("lift", contact.end)] if contact.end < contacts.frames else [])
            for kind, frame in both:
                found.append({
                    "time_s": round(start + frame * contacts.frame_time, 6), "frame": frame, "event": kind,
                    "effector": effector.name, "side": effector.side, "part": effector.part, "joint": effector.joint,
                })  # fmt: skip
    return sorted(found, key=lambda event: (event["frame"], event["effector"], event["event"]))


def encode(contacts: Contacts, source: Mapping[str, Any], *, start: float = 0.0) -> bytes:
    """Write the events file of a clip: JSON, an event a line.

    Args:
        contacts: when each effector is planted.
        source: what the file says of the clip.
        start: [s] the time of the first frame.
    """
    rows = ",\n  ".join(json.dumps(event, ensure_ascii=False) for event in events_of(contacts, start=start))
    head = json.dumps({"format": FORMAT, "version": VERSION, "source": dict(source)}, ensure_ascii=False)
    return f'{head[:-1]}, "events": [\n  {rows}\n]}}\n'.encode("utf-8", "surrogateescape")
