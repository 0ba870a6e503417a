"""Contact labels as arrays: NPZ with names and confidences, NPY as data sets have it, CSV with a row a frame.

NPZ, the keys of the archive (`contacts` alone is needed when one is read; E effectors, F frames, C contacts):

    contacts     (F, E) bool     True where an effector is planted; or probabilities, planted where over one half
    names        (E,)            effector names; without them the order of `LITERATURE_ORDER` and four columns
    fps          ()              frames per second
    confidence   (F, E) float    confidence of the contact that a frame belongs to, 0 outside contacts
    intervals    (C, 3) int      each contact: index of its effector, first frame, first frame after it
    certainty    (C,) float      confidence of each contact
    position_m   (C, 3) float    where each is planted [m], NaN where that is not said
    wish         (C,)            "force", "forbid" or "" for each contact

The last four tell apart contacts that touch, and keep what a mask has no place for. They hold while they agree with
`contacts`; where that array was edited it alone is read, with `confidence`.

NPY is one array (F, E) or (F - 1, E): HumanML3D, LAFAN1 and their kin keep 0 and 1 for [left heel, left toe, right
heel, right toe], from the speeds between frames, so that a clip of F frames may have F - 1 rows; the last one then
holds for two frames. CSV with a row a frame has a column an effector; columns `frame` and `time_s` are left alone.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from footfix.errors import InputError
from footfix.formats.labels import Labels, put
from footfix.motion.clip import Floats
from footfix.motion.contacts import Contact, Contacts, Wish, runs

# [left heel, left toe, right heel, right toe]: what a mask without names means in the literature
LITERATURE_ORDER = ("left_heel", "left_toe", "right_heel", "right_toe")

_BESIDE = ("frame", "time_s")  # columns of a frame-wise CSV that are no effectors


def encode_npz(contacts: Contacts) -> bytes:
    """Encode contacts as numpy's archive; its keys stand at the top of this module."""
    confidence = np.zeros((contacts.frames, len(contacts.effectors)), dtype=np.float32)
    found = [(e, c) for e, effector in enumerate(contacts.effectors) for c in effector.contacts]
    for e, contact in found:
        if contact.wish != "forbid":
            confidence[contact.start : contact.end, e] = round(contact.confidence, 4)
    nowhere = (np.nan, np.nan, np.nan)
    out = io.BytesIO()
    np.savez_compressed(
        out,
        contacts=contacts.mask(),
        names=np.array(contacts.names, dtype=np.str_),
        fps=np.array(1.0 / contacts.frame_time),
        confidence=confidence,
        intervals=np.array([(e, c.start, c.end) for e, c in found], dtype=np.int64).reshape(-1, 3),
        certainty=np.array([round(c.confidence, 4) for _, c in found]),  # as many decimals as in JSON and CSV
        position_m=np.round(np.array([c.position or nowhere for _, c in found]).reshape(-1, 3), 6),
        wish=np.array([c.wish or "" for _, c in found], dtype=np.str_),
    )
    return out.getvalue()


def encode_npy(contacts: Contacts) -> bytes:
    """Encode contacts as one array (F, E) of 0 and 1, the effectors in the order of the rig."""
    out = io.BytesIO()
    np.save(out, contacts.mask().astype(np.uint8))
    return out.getvalue()


def encode_frames(contacts: Contacts) -> bytes:
    """Encode contacts as CSV with a row a frame: its number, its time, and 0 or 1 for each effector."""
    out = io.StringIO(newline="")
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow([*_BESIDE, *contacts.names])
    for frame, row in enumerate(contacts.mask().astype(int).tolist()):
        writer.writerow([frame, f"{frame * contacts.frame_time:.6f}", *row])
    return out.getvalue().encode("utf-8")


def from_npz(data: bytes, name: str, order: Sequence[str]) -> Labels:
    """Read labels from the bytes of an archive.

    Raises:
        InputError: it is damaged, or holds no `contacts` of the right shape.
    """
    try:
        with np.load(io.BytesIO(data), allow_pickle=False) as archive:
            arrays = {key: np.asarray(archive[key]) for key in archive.files}
            mask = arrays["contacts"]
    except Exception:  # zipfile, zlib and numpy raise a dozen kinds for a damaged archive
        raise InputError("not a contact archive: it needs an array `contacts` (F, E)", file=name) from None
    names = order or [str(each) for each in arrays.get("names", np.array([])).ravel()]
    labels = from_mask(mask, name, names, confidence=arrays.get("confidence"))
    return _from_intervals(arrays, labels, np.asarray(mask > 0.5), name) or labels


def _from_intervals(arrays: Mapping[str, Any], labels: Labels, mask: Any, name: str) -> Labels | None:
    """Read labels from the list of contacts in an archive; None where there is none or it does not fit the mask."""
    names = list(labels.effectors)
    try:
        effectors: dict[str, tuple[Contact, ...]] = dict.fromkeys(names, ())
        again = np.zeros_like(mask)
        rows = zip(arrays["intervals"].tolist(), arrays["certainty"].tolist(),
                   arrays["position_m"].tolist(), arrays["wish"].tolist(), strict=True)  # fmt: skip
        for (e, start, end), confidence, place, said in rows:
            wish: Wish | None = "force" if said == "force" else "forbid" if said == "forbid" else None
            position = tuple(place) if np.all(np.isfinite(place)) else None
            effectors[names[e]] += (Contact(start, end, min(max(confidence, 0.0), 1.0), position, wish),)
            again[start:end, e] |= wish != "forbid"
    except (KeyError, IndexError, TypeError, ValueError):
        return None
    return Labels(effectors, len(mask), name) if np.array_equal(again, mask) else None


def from_npy(data: bytes, name: str, order: Sequence[str]) -> Labels:
    """Read labels from the bytes of one array (F, E) or (F - 1, E).

    Raises:
        InputError: it is damaged, or no array of truth values or probabilities.
    """
    try:
        mask = np.load(io.BytesIO(data), allow_pickle=False)
    except Exception:  # numpy raises several kinds for a damaged array
        raise InputError("not an array of contacts (F, 4)", file=name) from None
    return from_mask(mask, name, order, by_steps=True)


def from_frames(rows: Sequence[Sequence[str]], name: str) -> Labels:
    """Read labels from a CSV with a row a frame, its header first.

    Raises:
        InputError: a cell is no number.
    """
    header = [cell.strip() for cell in rows[0]]
    columns = [k for k, cell in enumerate(header) if cell.lower() not in (*_BESIDE, "time", "")]
    values: list[list[float]] = []
    for number, row in enumerate(rows[1:], start=2):
        if not any(cell.strip() for cell in row):
            continue
        try:
            values.append([float(row[k]) for k in columns])
        except (IndexError, ValueError):
            raise InputError("every frame needs 0 or 1 for each effector", file=name, line=number) from None
    return from_mask(np.array(values).reshape(-1, len(columns)), name, [header[k] for k in columns], by_steps=True)


def from_mask(
    mask: Any, name: str, names: Sequence[str] = (), *, confidence: Any = None, by_steps: bool = False
) -> Labels:
    """Make labels of an array with a row a frame and a column an effector.

    Args:
        mask: (F, E) of truth values, or of probabilities: planted where over one half, and the confidence of a
            contact is their mean. Contacts of 0 and 1 count as given by hand.
        name: of the file, for messages.
        names: (E,) effector names; `LITERATURE_ORDER` where there are four columns and none is given.
        confidence: (F, E) 0 to 1, over the mask's own.
        by_steps: True where F may be one less than the clip's frames.

    Raises:
        InputError: another shape, values or number of names; names given twice.
    """
    mask = np.asarray(mask)
    if mask.ndim != 2 or mask.dtype.kind not in "biuf":
        raise InputError(f"`contacts` must be (F, E) of truth values, not {mask.shape} {mask.dtype}", file=name)
    values = mask.astype(np.float64)
    if not np.all((values >= 0.0) & (values <= 1.0)):
        raise InputError("contacts are 0 or 1, or probabilities between them", file=name)
    if not names and mask.shape[1] != len(LITERATURE_ORDER):
        raise InputError(f"`contacts` has {mask.shape[1]} columns and no `names`", file=name, hint="--order names them")
    names = list(names or LITERATURE_ORDER)
    if len(names) != mask.shape[1]:
        raise InputError(f"{len(names)} names for {mask.shape[1]} columns", file=name)
    sure = values if confidence is None or np.shape(confidence) != mask.shape else np.asarray(confidence, np.float64)
    effectors: dict[str, tuple[Contact, ...]] = {}
    for e, effector in enumerate(names):
        put(effectors, effector, tuple(
            Contact(a, b, _mean(sure[a:b, e])) for a, b in runs(values[:, e] > 0.5)
        ), name)  # fmt: skip
    return Labels(effectors, len(mask), name, by_steps)


def _mean(confidence: Floats) -> float:
    """Average the confidence of a contact over frames that have one; without any it was added by hand: certain."""
    known = confidence[np.isfinite(confidence) & (confidence > 0.0)]
    return round(min(float(known.mean()), 1.0), 4) if len(known) else 1.0
