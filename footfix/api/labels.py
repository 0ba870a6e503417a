"""Contact labels, from files and to files."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from footfix.api.clips import find_rigs
from footfix.api.parameters import check_settings
from footfix.api.reports import source_of
from footfix.errors import ArgumentError
from footfix.formats import contacts as labels_format
from footfix.formats.document import Document
from footfix.formats.label_arrays import encode_npy, encode_npz
from footfix.input_checks import check_clip, check_contacts, check_rig
from footfix.jobs import contacts as job
from footfix.motion.clip import Clip
from footfix.motion.contacts import Contacts
from footfix.motion.lead_in import motion_range
from footfix.pipeline import prepare
from footfix.report import document as report_format
from footfix.rig.rig import Rig
from footfix.settings import Settings


def load_contacts(
    path: str | os.PathLike[str], clip: Clip, rig: Rig | None = None, settings: Settings | None = None, *,
    order: Sequence[str] = (),
) -> Contacts:  # fmt: skip
    """Read contact labels and hold them against a clip.

    Effectors that the file does not name are left to the detector, as `footfix clean --labels` does.

    Args:
        path: a JSON, CSV, NPZ or NPY file; which one it is, the content says.
        clip: the motion that it labels.
        rig: legs and sole points; of all figures, found, where it is not given.
        settings: the detector of what is left to it.
        order: the effectors of an array's columns; by default left heel, left toe, right heel, right toe.

    Raises:
        ArgumentError: clip or rig can't be what is meant.
        InputError: the file is no label file, or one of another clip.
    """
    settings = check_settings(settings)
    rigs = find_rigs(clip, settings) if rig is None else (check_rig(rig, check_clip(clip)),)
    labels = labels_format.decode(Path(path).read_bytes(), name=os.fspath(path), order=order)
    return job.find_contacts(prepare(clip, settings, rigs, motion_range(clip)), settings, labels)


def save_contacts(
    path: str | os.PathLike[str], contacts: Contacts, *, clip: Clip | None = None, rig: Rig | None = None,
    like: Document | None = None,
) -> None:  # fmt: skip
    """Write contact labels, whole or not at all.

    Args:
        path: the file; its suffix says what is written: .json, .csv, .npz or .npy.
        contacts: the labels.
        clip, rig: what they label; JSON says so, and needs both.
        like: the document that the clip came from.

    Raises:
        ArgumentError: the suffix is another one, or JSON is asked for without clip and rig.
        OutputError: it could not be written; what stood there still does.
    """
    from footfix.batch.file_io import write_whole

    write_whole(Path(path), _encoded(Path(path), contacts, clip, rig, like))


def _encoded(path: Path, contacts: Contacts, clip: Clip | None, rig: Rig | None, like: Document | None) -> bytes:
    suffix = path.suffix.lower()
    if suffix == ".csv":
        return labels_format.encode_csv(contacts)
    if suffix == ".npz":
        return encode_npz(contacts)
    if suffix == ".npy":
        return encode_npy(contacts)
    if suffix != ".json":
        raise ArgumentError(f"labels are written as .json, .csv, .npz or .npy, not {path.suffix!r}")
    if clip is None or rig is None:
        raise ArgumentError("a JSON file says which clip and legs its labels are for: hand in clip= and rig=, too")
    check_contacts(contacts, check_clip(clip), [sole.name for sole in rig.soles])
    unit_m, up = (1.0, "y") if like is None else (like.unit_m, like.up)
    entry = report_format.rig(rig, clip, unit_m=unit_m, up=up)
    return job.contacts_json(contacts, source_of(clip, like), entry, Settings())
