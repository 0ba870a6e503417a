"""Contact labels: JSON (the contract) and CSV (one row a contact); arrays are read by `label_arrays`.

What is read back may come from a person, another tool or a network, so it is checked against the clip. JSON, CSV and
NPZ lose nothing: a clip is cleaned alike with each. One row a frame (NPY, CSV) holds only what is planted, and counts
as contacts given by a person.
"""

from __future__ import annotations

import csv
import io
import json
import re
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from footfix.errors import InputError, UsageError
from footfix.formats import label_arrays
from footfix.formats.labels import Labels, fit, merge, put
from footfix.motion.contacts import Contact, Contacts, Wish

__all__ = ["ENCODERS", "ENDS", "Labels", "decode", "encode_csv", "encode_json", "fit", "merge", "order_from"]

FORMAT, VERSION = "footfix-contacts", 1

_COLUMNS = ("effector", "start", "end", "start_s", "end_s", "confidence", "x_m", "y_m", "z_m", "wish")


def encode_json(
    contacts: Contacts, *, source: Mapping[str, Any], rig: Mapping[str, Any], detector: Mapping[str, Any]
) -> bytes:
    """Encode contacts as the contract's contacts file, version 1."""
    document = {
        "format": FORMAT,
        "version": VERSION,
        "source": dict(source),
        "rig": dict(rig),
        "detector": dict(detector),
        "effectors": [
            {
                "name": effector.name,
                "side": effector.side,
                "part": effector.part,
                "joint": effector.joint,
                "contacts": [_plain(contact) for contact in effector.contacts],
            }
            for effector in contacts.effectors
        ],
    }
    # One contact a line: people edit this file by hand.
    text = json.dumps(document, indent=1, ensure_ascii=False)
    text = re.sub(r"\{\s+(\"start\":[^{}]*?)\s+\}", lambda m: "{" + re.sub(r"\s*\n\s*", " ", m[1]) + "}", text)
    return (text + "\n").encode("utf-8", "surrogateescape")


def _plain(contact: Contact) -> dict[str, Any]:
    plain: dict[str, Any] = {"start": contact.start, "end": contact.end, "confidence": round(contact.confidence, 4)}
    if contact.position is not None:
        plain["position_m"] = [round(x, 6) + 0.0 for x in contact.position]
    if contact.wish:
        plain[contact.wish] = True
    return plain


def encode_csv(contacts: Contacts) -> bytes:
    """Encode contacts as CSV, one row a contact, with a header; times in frames and in seconds.

    Of the columns, effector, start and end are needed when one is read. An effector that is never planted has a row
    without start and end: one that is not named at all would be left to the detector.
    """
    out = io.StringIO(newline="")
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(_COLUMNS)
    dt = contacts.frame_time
    for effector in contacts.effectors:
        for c in effector.contacts:
            place = ["", "", ""] if c.position is None else [f"{x:.6f}" for x in c.position]
            times = [f"{c.start * dt:.6f}", f"{c.end * dt:.6f}"]
            writer.writerow([effector.name, c.start, c.end, *times, f"{c.confidence:.4f}", *place, c.wish or ""])
        if not effector.contacts:
            writer.writerow([effector.name, *[""] * (len(_COLUMNS) - 1)])
    return out.getvalue().encode("utf-8")


# How contacts are written but as JSON, which says more of the clip: kind -> (what names end in, encoder).
ENCODERS: Mapping[str, tuple[str, Callable[[Contacts], bytes]]] = {
    "csv": (".contacts.csv", encode_csv),
    "frames": (".frames.csv", label_arrays.encode_frames),
    "npz": (".contacts.npz", label_arrays.encode_npz),
    "npy": (".contacts.npy", label_arrays.encode_npy),
}

# Kind of label file -> what names of such files end in.
ENDS: Mapping[str, str] = {"json": ".contacts.json", **{kind: end for kind, (end, _) in ENCODERS.items()}}


def decode(data: bytes, *, name: str = "labels", order: Sequence[str] = ()) -> Labels:
    """Read labels from the bytes of a JSON, CSV, NPZ or NPY file; which one it is, the content says.

    Args:
        data: the bytes.
        name: of the file, for messages.
        order: effector names of the columns of an array, over those it has; without either, four columns are
            left heel, left toe, right heel, right toe.

    Raises:
        InputError: it is none of these, or what it says makes no sense.
    """
    if data[:2] == b"PK":
        return label_arrays.from_npz(data, name, order)
    if data[:6] == b"\x93NUMPY":
        return label_arrays.from_npy(data, name, order)
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise InputError("this is no contact label file", file=name, hint="JSON, CSV, NPZ and NPY are read") from None
    return _from_json(text, name) if text.lstrip()[:1] in ("{", "[") else _from_csv(text, name)


def order_from(text: str) -> tuple[str, ...]:
    """Read effector names from "right_heel,right_toe,left_heel,left_toe"; parts may be told apart as people do.

    Raises:
        UsageError: a name is empty or given twice.
    """
    names = tuple(re.sub(r"[\s-]+", "_", each.strip()) for each in text.strip("[] ").split(",")) if text else ()
    if not all(names) or len(set(names)) < len(names):
        usual = ",".join(label_arrays.LITERATURE_ORDER)
        raise UsageError(f"--order takes effector names such as {usual}, not {text!r}")
    return names


def _from_json(text: str, name: str) -> Labels:
    try:
        document = json.loads(text)
    except (json.JSONDecodeError, RecursionError) as error:
        line, column = getattr(error, "lineno", None), getattr(error, "colno", None)
        raise InputError(f"not valid JSON: {error}", file=name, line=line, column=column) from None
    if not isinstance(document, dict) or document.get("format") != FORMAT:
        raise InputError(f'not a contacts file: "format" is not "{FORMAT}"', file=name)
    if document.get("version") != VERSION:
        raise InputError(f"contacts file of version {document.get('version')!r}; version {VERSION} is read", file=name)
    effectors: dict[str, tuple[Contact, ...]] = {}
    listed = document.get("effectors")
    if not isinstance(listed, list):
        raise InputError('"effectors" must be a list', file=name)
    for entry in listed:
        if not isinstance(entry, dict) or not isinstance(entry.get("name"), str):
            raise InputError("every effector needs a name", file=name)
        found = entry.get("contacts", [])
        if not isinstance(found, list) or not all(isinstance(each, dict) for each in found):
            raise InputError(f"contacts of {entry['name']} must be a list of intervals", file=name)
        contacts = tuple(_contact(each, entry["name"], name) for each in found)
        put(effectors, entry["name"], contacts, name)
    frames = document.get("source", {}).get("frames") if isinstance(document.get("source"), dict) else None
    return Labels(effectors, frames if isinstance(frames, int) else None, name)


def _contact(entry: Mapping[str, Any], effector: str, name: str) -> Contact:
    try:
        start, end = _whole(entry["start"]), _whole(entry["end"])
        confidence = float(entry.get("confidence", 1.0))
        place = entry.get("position_m")
        position = None if place is None else tuple(float(x) for x in place)
    except (KeyError, TypeError, ValueError):
        raise InputError(f"{effector}: every contact needs whole numbers start and end", file=name) from None
    if not np.isfinite(confidence) or (
        position is not None and (len(position) != 3 or not np.all(np.isfinite(position)))
    ):
        raise InputError(f"{effector}: contact {start}-{end} has a confidence or place that is no number", file=name)
    said = entry.get("wish")
    wishes: list[Wish] = [w for w in ("force", "forbid") if entry.get(w) is True or said == w]
    if len(wishes) > 1:
        raise InputError(f"{effector}: contact {start}-{end} is both forced and forbidden", file=name)
    return Contact(start, end, min(max(confidence, 0.0), 1.0), position, wishes[0] if wishes else None)


def _whole(value: Any) -> int:
    if isinstance(value, bool) or int(value) != float(value):
        raise ValueError
    return int(value)


def _from_csv(text: str, name: str) -> Labels:
    try:
        rows = list(csv.reader(io.StringIO(text)))
    except csv.Error as error:
        raise InputError(f"this is no contact label file: {error}", file=name) from None
    header = [cell.strip().lower() for cell in rows[0]] if rows else []
    if any(cell.endswith(("heel", "toe")) for cell in header):
        return label_arrays.from_frames(rows, name)
    if not {"effector", "start", "end"} <= set(header):
        hint = "a CSV needs the columns effector, start and end, or a column for each effector and a row a frame"
        raise InputError("this is no contact label file", file=name, hint=hint)
    effectors: dict[str, tuple[Contact, ...]] = {}
    for number, row in enumerate(rows[1:], start=2):
        if not any(cell.strip() for cell in row):
            continue
        cells = {key: cell.strip() for key, cell in zip(header, row, strict=False)}
        if cells.get("effector") and not cells.get("start") and not cells.get("end"):
            effectors.setdefault(cells["effector"], ())
            continue
        entry: dict[str, Any] = {key: cells[key] for key in ("start", "end", "wish") if cells.get(key)}
        entry["confidence"] = cells.get("confidence") or 1.0
        if all(cells.get(key) for key in ("x_m", "y_m", "z_m")):
            entry["position_m"] = [cells[key] for key in ("x_m", "y_m", "z_m")]
        try:
            contact = _contact(entry, cells.get("effector", ""), name)
        except InputError as error:
            raise InputError(error.what, file=name, line=number) from None
        effectors[cells["effector"]] = (*effectors.get(cells["effector"], ()), contact)
    return Labels(effectors, None, name)


