"""Contact labels: out and in again, and refused where they do not fit."""

from __future__ import annotations

import io
import json

import numpy as np
import pytest

from footfix.errors import InputError
from footfix.formats import contacts as labels
from footfix.formats import label_arrays
from footfix.motion.contacts import Contact, Contacts, Effector, runs

SOURCE = {"file": "walk.bvh", "sha256": "0" * 64, "frames": 100, "frame_time": 0.01}


def blank() -> Contacts:
    names = [("left", "heel"), ("left", "toe"), ("right", "heel"), ("right", "toe")]
    return Contacts(100, 0.01, tuple(Effector(f"{s}_{p}", s, p, s + p) for s, p in names))  # type: ignore[arg-type]


def some() -> Contacts:
    mask = np.zeros((100, 4), dtype=bool)
    mask[5:40, 0] = mask[70:100, 0] = mask[12:55, 1] = mask[0:20, 2] = True
    return blank().with_mask(mask, np.full((100, 4), 0.875))


def as_json(contacts: Contacts) -> bytes:
    return labels.encode_json(contacts, source=SOURCE, rig={}, detector={})


def spans(contacts: Contacts) -> list[list[tuple[int, int]]]:
    return [[(c.start, c.end) for c in effector.contacts] for effector in contacts.effectors]


@pytest.mark.parametrize("encode", [as_json, labels.encode_csv, label_arrays.encode_npz], ids=["json", "csv", "npz"])
def test_out_and_in_again(encode: object) -> None:
    contacts = some()
    fitted, _ = labels.fit(labels.decode(encode(contacts)), blank())  # type: ignore[operator]
    assert spans(fitted) == spans(contacts)


def test_json_keeps_confidence_place_and_wishes() -> None:
    first = Contact(3, 9, 0.25, (1.0, -2.5, 0.125), "force")
    contacts = Contacts(
        100, 0.01, (Effector("left_heel", "left", "heel", "x", (first, Contact(20, 30, wish="forbid"))),)
    )
    assert labels.decode(as_json(contacts)).effectors["left_heel"] == contacts.effectors[0].contacts
    assert labels.decode(labels.encode_csv(contacts)).effectors["left_heel"] == contacts.effectors[0].contacts


def test_json_is_the_contracts() -> None:
    document = json.loads(as_json(some()))
    assert (document["format"], document["version"]) == ("footfix-contacts", 1)
    assert document["effectors"][0]["contacts"][0] == {"start": 5, "end": 40, "confidence": 0.875}


def test_a_mask_without_names_is_in_the_literatures_order() -> None:
    out = io.BytesIO()
    np.savez(out, contacts=some().mask().astype(np.float32))
    assert spans(labels.fit(labels.decode(out.getvalue()), blank())[0]) == spans(some())


def test_effectors_that_are_not_named_stay_open_and_forbidden_stretches_are_cut_out() -> None:
    text = {
        "format": "footfix-contacts",
        "version": 1,
        "effectors": [
            {"name": "left_heel", "contacts": [{"start": 1, "end": 2}]},
            {"name": "Left Toe", "contacts": [{"start": 20, "end": 30, "forbid": True}]},
        ],
    }
    given, open_ones = labels.fit(labels.decode(json.dumps(text).encode()), blank())
    assert open_ones == {"left_toe", "right_heel", "right_toe"}
    merged = labels.merge(given, some(), open_ones)
    assert spans(merged)[0] == [(1, 2)]
    assert runs(merged.mask()[:, 1]) == [(12, 20), (30, 55)]
    assert spans(merged)[2] == [(0, 20)]


REFUSED = {
    "not json": (b"{", "not valid JSON"),
    "other json": (b"{}", "not a contacts file"),
    "version": (b'{"format": "footfix-contacts", "version": 2}', "version 2"),
    "frames": (as_json(some()).replace(b'"frames": 100', b'"frames": 99'), "99 frames"),
    "unknown effector": (as_json(some()).replace(b"left_heel", b"left_hand"), "left_hand"),
    "twice": (as_json(some()).replace(b"left_toe", b"left_heel"), "twice"),
    "outside": (b"effector,start,end\nleft_heel,90,101\n", "does not fit"),
    "backwards": (b"effector,start,end\nleft_heel,9,9\n", "does not fit"),
    "overlap": (b"effector,start,end\nleft_heel,1,9\nleft_heel,8,12\n", "overlap"),
    "half a frame": (b"effector,start,end\nleft_heel,1.5,9\n", "whole numbers"),
    "no columns": (b"a,b\n1,2\n", "columns"),
    "not text": (b"\xff\xfe\x00", "no contact label file"),
    "broken archive": (b"PK\x03\x04junk", "archive"),
    "both wishes": (b"effector,start,end,wish\nleft_heel,1,9,force\nleft_toe,1,x,force\n", "whole numbers"),
}


@pytest.mark.parametrize("why", REFUSED)
def test_labels_that_do_not_fit_are_refused_and_say_why(why: str) -> None:
    data, words = REFUSED[why]
    with pytest.raises(InputError, match=words) as caught:
        labels.fit(labels.decode(data, name="mine.json"), blank())
    assert str(caught.value).startswith("mine.json")


def test_a_label_file_is_never_unpickled() -> None:
    out = io.BytesIO()
    np.savez(out, contacts=np.array([{"a": 1}], dtype=object))
    with pytest.raises(InputError):
        labels.decode(out.getvalue())
