"""Contact labels: out and in again, and refused where they do not fit."""

from __future__ import annotations

import io
import json
from dataclasses import replace
from typing import Any

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


WHOLE = {"json": as_json, "csv": labels.encode_csv, "npz": label_arrays.encode_npz}


def kept() -> Contacts:
    """Contacts of all kinds: uncertain, with a place, wished for, touching, and an effector without any."""
    of = {
        "left_heel": (Contact(3, 9, 0.25, (1.0, -2.5, 0.125), "force"), Contact(9, 20, 0.9871)),
        "left_toe": (Contact(20, 30, wish="forbid"),),
        "right_heel": (Contact(0, 100, 1.0),),
    }
    return replace(
        blank(), effectors=tuple(replace(each, contacts=of.get(each.name, ())) for each in blank().effectors)
    )


@pytest.mark.parametrize("kind", WHOLE)
@pytest.mark.parametrize("contacts", [some(), kept()], ids=["some", "all kinds"])
def test_what_goes_out_comes_back_the_same_from_each_format(kind: str, contacts: Contacts) -> None:
    fitted, open_ones = labels.fit(labels.decode(WHOLE[kind](contacts)), blank())
    assert fitted.effectors == contacts.effectors
    assert open_ones == {each.name for each in contacts.effectors if [c.wish for c in each.contacts] == ["forbid"]}


@pytest.mark.parametrize("encode", [label_arrays.encode_npy, label_arrays.encode_frames], ids=["npy", "frames"])
def test_a_row_a_frame_gives_the_mask_back_as_given_by_hand(encode: Any) -> None:
    fitted, _ = labels.fit(labels.decode(encode(some())), blank())
    assert spans(fitted) == spans(some())
    assert {c.confidence for each in fitted.effectors for c in each.contacts} == {1.0}


def test_a_mask_that_was_edited_is_what_holds() -> None:
    archive = dict(np.load(io.BytesIO(label_arrays.encode_npz(some()))))
    archive["contacts"][60:65, 1] = True  # added by hand
    archive["contacts"][12:20, 1] = False
    out = io.BytesIO()
    np.savez(out, **archive)
    fitted, _ = labels.fit(labels.decode(out.getvalue()), blank())
    assert fitted["left_toe"].contacts == (Contact(20, 55, 0.875), Contact(60, 65, 1.0))
    assert fitted["left_heel"].contacts == some()["left_heel"].contacts


def npy(mask: Any) -> bytes:
    out = io.BytesIO()
    np.save(out, mask)
    return out.getvalue()


def test_arrays_of_data_sets_are_read_in_their_order_or_another() -> None:
    mask = some().mask()
    assert spans(labels.fit(labels.decode(npy(mask.astype(np.float32))), blank())[0]) == spans(some())
    turned = labels.decode(
        npy(mask[:, [2, 3, 0, 1]]), order=labels.order_from("right heel, right-toe,left_heel,left_toe")
    )
    assert spans(labels.fit(turned, blank())[0]) == spans(some())


def test_contacts_of_steps_between_frames_last_to_the_last_frame() -> None:
    steps = some().mask()[:-1]  # as differences of positions give them
    fitted, _ = labels.fit(labels.decode(npy(steps)), blank())
    assert spans(fitted) == spans(some())
    with pytest.raises(InputError, match="98 frames"):
        labels.fit(labels.decode(npy(steps[:-1])), blank())


def test_probabilities_say_how_sure_a_contact_is() -> None:
    mask = np.zeros((100, 4))
    mask[10:20, 0], mask[30:40, 0] = 0.75, 0.4
    fitted, _ = labels.fit(labels.decode(npy(mask)), blank())
    assert fitted["left_heel"].contacts == (Contact(10, 20, 0.75),)


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
    "array of places": (npy(np.full((100, 4), 3.0)), "0 or 1"),
    "array of three": (npy(np.zeros((100, 3))), "3 columns"),
    "array of objects": (npy(np.array([[{}]], dtype=object)), "array of contacts"),
    "frames with words": (b"frame,left_heel\n0,yes\n", "0 or 1"),
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
