"""Contact labels: JSON (the contract), CSV (one row a contact) and NPZ (a mask, as the ML literature has it).

What is read back may come from a person, another tool or a network, so it is checked against the clip.
"""

from __future__ import annotations

import csv
import io
import json
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np

from footfix.errors import InputError
from footfix.motion.contacts import Contact, Contacts, Effector, Wish, runs

FORMAT, VERSION = "footfix-contacts", 1

# [left heel, left toe, right heel, right toe]: what a mask without names means in the literature
LITERATURE_ORDER = ("left_heel", "left_toe", "right_heel", "right_toe")

_COLUMNS = ("effector", "start", "end", "start_s", "end_s", "confidence", "x_m", "y_m", "z_m", "wish")


@dataclass(frozen=True)
class Labels:
    """Labels as a file gives them, not yet held against a clip.

    Args:
        effectors: contacts by effector name; an effector that is not named is left to the detector.
        frames: frames of the clip they were made for, if the file says.
        source: name of the file, for messages.
    """

    effectors: Mapping[str, tuple[Contact, ...]]
    frames: int | None = None
    source: str = "labels"


def encode_json(
    contacts: Contacts, *, source: Mapping[str, Any], rig: Mapping[str, Any], detector: Mapping[str, Any]
) -> bytes:
    """The contacts file of the contract, version 1."""
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
    """One row a contact, with a header; times in frames and in seconds."""
    out = io.StringIO(newline="")
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(_COLUMNS)
    dt = contacts.frame_time
    for effector in contacts.effectors:
        for c in effector.contacts:
            place = ["", "", ""] if c.position is None else [f"{x:.6f}" for x in c.position]
            times = [f"{c.start * dt:.6f}", f"{c.end * dt:.6f}"]
            writer.writerow([effector.name, c.start, c.end, *times, f"{c.confidence:.4f}", *place, c.wish or ""])
    return out.getvalue().encode("utf-8")


def encode_npz(contacts: Contacts) -> bytes:
    """`contacts` (F, E) bool, `names` (E,), `fps` and `confidence` (F, E), as numpy's archive."""
    out = io.BytesIO()
    confidence = np.zeros((contacts.frames, len(contacts.effectors)), dtype=np.float32)
    for e, effector in enumerate(contacts.effectors):
        for contact in effector.contacts:
            if contact.wish != "forbid":
                confidence[contact.start : contact.end, e] = contact.confidence
    np.savez_compressed(
        out,
        contacts=contacts.mask(),
        names=np.array(contacts.names),
        fps=np.array(1.0 / contacts.frame_time),
        confidence=confidence,
    )
    return out.getvalue()


def decode(data: bytes, *, name: str = "labels") -> Labels:
    """Labels from the bytes of a JSON, CSV or NPZ file; which one it is, the content says.

    Raises:
        InputError: it is none of these, or what it says makes no sense.
    """
    if data[:2] == b"PK":
        return _from_npz(data, name)
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise InputError("this is no contact label file", file=name, hint="JSON, CSV and NPZ are read") from None
    return _from_json(text, name) if text.lstrip()[:1] in ("{", "[") else _from_csv(text, name)


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
        _put(effectors, entry["name"], contacts, name)
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


def _put(effectors: dict[str, tuple[Contact, ...]], effector: str, contacts: tuple[Contact, ...], name: str) -> None:
    if effector in effectors:
        raise InputError(f"effector {effector} is listed twice", file=name)
    effectors[effector] = contacts


def _from_csv(text: str, name: str) -> Labels:
    rows = list(csv.reader(io.StringIO(text)))
    header = [cell.strip().lower() for cell in rows[0]] if rows else []
    if not {"effector", "start", "end"} <= set(header):
        raise InputError(
            "this is no contact label file", file=name, hint="a CSV needs the columns effector, start and end"
        )
    effectors: dict[str, tuple[Contact, ...]] = {}
    for number, row in enumerate(rows[1:], start=2):
        if not any(cell.strip() for cell in row):
            continue
        cells = {key: cell.strip() for key, cell in zip(header, row, strict=False)}
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


def _from_npz(data: bytes, name: str) -> Labels:
    try:
        with np.load(io.BytesIO(data), allow_pickle=False) as archive:
            mask = np.asarray(archive["contacts"])
            names = [str(each) for each in archive["names"]] if "names" in archive else None
    except Exception:  # zipfile, zlib and numpy raise a dozen kinds for a damaged archive
        raise InputError("not a contact archive: it needs an array `contacts` (F, E)", file=name) from None
    if mask.ndim != 2 or mask.dtype.kind not in "biuf":
        raise InputError(f"`contacts` must be (F, E) of truth values, not {mask.shape} {mask.dtype}", file=name)
    if names is None:
        if mask.shape[1] != len(LITERATURE_ORDER):
            raise InputError(f"`contacts` has {mask.shape[1]} columns and no `names`", file=name)
        names = list(LITERATURE_ORDER)
    if len(names) != mask.shape[1]:
        raise InputError(f"{len(names)} names for {mask.shape[1]} columns", file=name)
    effectors: dict[str, tuple[Contact, ...]] = {}
    for e, effector in enumerate(names):
        _put(effectors, effector, tuple(Contact(a, b) for a, b in runs(mask[:, e] > 0.5)), name)
    return Labels(effectors, mask.shape[0], name)


def fit(labels: Labels, blank: Contacts) -> tuple[Contacts, frozenset[str]]:
    """Holds labels against a clip.

    Args:
        labels: what a file says.
        blank: the effectors of the clip's rig, nothing in contact.

    Returns:
        Contacts with what the labels say, and the names of the effectors that are left to the detector:
        those the labels do not name, and those for which they only forbid.

    Raises:
        InputError: other frames, unknown effectors, contacts that overlap or lie outside the clip.
    """
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
        _put(given, known[_key(name)], _in_order(contacts, name, blank.frames, labels.source), labels.source)
    open_ones = frozenset(
        name
        for name in blank.names
        if name not in given or (given[name] and all(c.wish == "forbid" for c in given[name]))
    )
    effectors: tuple[Effector, ...] = tuple(
        replace(effector, contacts=given.get(effector.name, ())) for effector in blank.effectors
    )
    return replace(blank, effectors=effectors, method="labels"), open_ones


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
    """Labels where they speak, the detector's contacts for the effectors they leave open, less what is forbidden."""
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
