"""The main job on walkers whose plants are exactly known: measured on the file that was written."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import artefacts
import exports
import numpy as np
import pytest
from bvhmaker import side_by_side
from exports import Spelling
from walker import Walk, make
from walker_plan import Gait

from footfix.formats import contacts as contacts_format
from footfix.formats.bvh import decode
from footfix.formats.contacts import Labels
from footfix.formats.labels import fit
from footfix.jobs.clean import clean_file
from footfix.jobs.inspect import inspect_file
from footfix.jobs.outputs import Outputs
from footfix.jobs.source import read
from footfix.motion.clip import Clip, Floats
from footfix.motion.contacts import Contact, runs
from footfix.report.inspection import describe
from footfix.settings import ReportParams, Settings

SETTINGS = Settings(report=ReportParams(kind="json"))
LEGS = ("UpLeg", "Leg", "Foot", "ToeBase")

# (naming, unit, up, rotation order, fps)
EXPORTS = [
    ("plain", 0.01, "y", "ZXY", 60),
    ("mixamo", 0.01, "y", "XYZ", 60),
    ("daz", 0.0254, "y", "ZYX", 30),
    ("biped", 1.0, "z", "YXZ", 50),
    ("unreal", 0.01, "z", "XYZ", 30),
    ("nothing", 1.0 / 17.7, "y", "ZYX", 120),
]


@cache
def walker(fps: float, seed: int = 1) -> Walk:
    return make(Gait(name="walk", duration=2.0, fps=fps, seed=seed))


@cache
def cleaned(case: tuple[str, float, str, str, int]) -> tuple[Walk, bytes, Outputs]:
    naming, unit, up, order, fps = case
    walk = walker(fps)
    skating = artefacts.wander(artefacts.drift(exports.renamed(walk.clip, naming), 0.03), 0.03)
    data = exports.bvh(skating, Spelling(unit_m=unit, up=up, order=order))
    return walk, data, clean_file(data, "walk.bvh", SETTINGS)


def slides_of(written: bytes, walk: Walk, part: str, up: str) -> list[float]:
    """How far the walker's own sole points slide within their true plants [mm], in the file as written."""
    clip = read(written, "walk.bvh", SETTINGS).clip
    slides = []
    for (joint, offset), effector in zip(walk.soles, walk.contacts.effectors, strict=True):
        if effector.part != part:
            continue
        at = walk.clip.skeleton.names.index(joint)
        x, y, z = offset  # in a z-up file the joints' frames are turned, too
        track = point(clip, at, np.array([x, y, z] if up == "y" else [x, -z, y]))
        for contact in effector.contacts:
            planted = track[contact.start : contact.end][:, [0, 2]]
            slides.append(1000.0 * float(np.max(np.linalg.norm(planted - np.median(planted, 0), axis=1))))
    return slides


def point(clip: Clip, joint: int, offset: Floats) -> Floats:
    from footfix.motion.kinematics import forward

    return forward(clip, [joint]).point(joint, offset)


@pytest.mark.parametrize("case", EXPORTS, ids=lambda case: case[0])
def test_a_walker_comes_back_without_skate_and_otherwise_untouched(case: tuple[str, float, str, str, int]) -> None:
    walk, data, outputs = cleaned(case)
    assert outputs.status == "cleaned"
    header, body = data.split(b"MOTION")
    new_header, new_body = outputs.motion.split(b"MOTION")
    assert new_header == header
    document = decode(data)
    free = np.concatenate(  # columns that must not change: all but the legs' and the root's position
        [
            [not any(plain.endswith(leg) for leg in LEGS)] * (6 if plain == "Hips" else 3)
            for plain in walk.clip.skeleton.names
        ]
    )
    free[:3] = False
    old = [line.split() for line in body.split(b"\n")[3:] if line.strip()]
    new = [line.split() for line in new_body.split(b"\n")[3:] if line.strip()]
    assert len(old) == len(new) == len(document.values)
    for before, after in zip(old, new, strict=True):
        assert [b for b, keep in zip(before, free, strict=True) if keep] == [
            a for a, keep in zip(after, free, strict=True) if keep
        ]
    toe = slides_of(outputs.motion, walk, "toe", case[2])
    assert np.percentile(toe, 90) <= 5.0
    assert np.percentile(slides_of(data, walk, "toe", case[2]), 90) > 5.0, "the clip was to have skate in it"


def test_contacts_are_the_true_ones() -> None:
    scores = []
    for case in EXPORTS:
        walk, _, outputs = cleaned(case)
        found = fit(contacts_format.decode(outputs.contacts), walk.contacts)[0].mask()
        truth = walk.contacts.mask()
        for foot in (0, 2):
            scores.append(f1(truth[:, foot : foot + 2].any(1), found[:, foot : foot + 2].any(1), 2))
    assert np.median(scores) >= 0.95


def f1(truth: np.ndarray, found: np.ndarray, tolerance: int) -> float:
    """F1 over frames; a wrong frame within the tolerance of an edge of the truth does not count."""
    near = np.zeros(len(truth), dtype=bool)
    for a, b in runs(truth):
        for edge in (a, b):
            near[max(edge - tolerance, 0) : edge + tolerance] = True
    agreed = np.where(near, truth, found)
    both = np.sum(agreed & truth)
    return float(2 * both / max(agreed.sum() + truth.sum(), 1))


def test_a_clip_that_needs_nothing_comes_back_as_the_same_file() -> None:
    walk = make(Gait(name="stand", duration=2.0, fps=60.0))
    still = replace(
        walk.clip, positions=walk.clip.positions[:1].repeat(120, 0), rotations=walk.clip.rotations[:1].repeat(120, 0)
    )
    data = exports.bvh(still, Spelling())
    outputs = clean_file(data, "stand.bvh", SETTINGS)
    assert outputs.status == "unchanged" and outputs.motion == data


def test_cleaning_a_cleaned_clip_changes_nothing_to_be_seen() -> None:
    _, _, outputs = cleaned(EXPORTS[0])
    again = clean_file(outputs.motion, "walk.bvh", SETTINGS)
    from footfix.motion.kinematics import forward

    once, twice = (forward(read(data, "walk.bvh", SETTINGS).clip).positions for data in (outputs.motion, again.motion))
    assert np.linalg.norm(once - twice, axis=-1).max() < 0.002


def test_two_figures_in_one_file_are_both_cleaned_as_each_alone() -> None:
    first = exports.bvh(artefacts.wander(walker(30).clip, 0.03))
    second = exports.bvh(artefacts.wander(artefacts.turned(walker(30, 2).clip, 0.4, (2.0, 1.0)), 0.04, seed=3))
    outputs = clean_file(side_by_side(first, second), "two.bvh", SETTINGS)
    alone = [clean_file(data, "one.bvh", SETTINGS) for data in (first, second)]
    effectors = {plant["effector"] for plant in outputs.report["plants"]}
    assert {"left_heel", "figure2_right_toe"} <= effectors and len(effectors) == 8
    motions = [each.motion.decode().split("MOTION\n")[1].splitlines()[2:] for each in (outputs, *alone)]
    rows = [[line.split() for line in lines] for lines in motions]
    assert rows[0] == [a + b for a, b in zip(rows[1], rows[2], strict=True)]


def test_inspect_lists_every_figure_of_a_file() -> None:
    first = exports.bvh(walker(60).clip)
    second = exports.bvh(artefacts.turned(walker(60, 2).clip, 0.4, (2.0, 1.0)))
    found = inspect_file(side_by_side(first, second), "two.bvh", SETTINGS)
    told = describe(found)
    assert len(found["figures"]) == 2
    for number, figure in enumerate(found["figures"], start=1):
        assert f"figure {number}: 2 legs of {figure['leg_length_m']:.3f} m" in told
        for leg in figure["legs"]:
            assert f"{leg['name']} leg: {leg['hip']} > {leg['knee']} > {leg['ankle']} > {leg['toe']}" in told
    assert "figure" not in describe(inspect_file(first, "one.bvh", SETTINGS))


# ---- nothing to do, and doing it twice --------------------------------------------------------------


@pytest.mark.parametrize("gait", ["walk", "turn", "stairs"])
def test_a_clean_walk_comes_back_as_the_same_file(gait: str) -> None:
    data = exports.bvh(make(Gait(name=gait, duration=2.5, fps=60.0)).clip)
    outputs = clean_file(data, "walk.bvh", SETTINGS)
    assert outputs.status == "unchanged" and outputs.motion == data
    assert {plant["outcome"] for plant in outputs.report["plants"]} == {"kept"}


@pytest.mark.parametrize("fps", [30, 120])
def test_a_cleaned_file_is_its_own_cleaned_file(fps: int) -> None:
    skating = artefacts.scale_root(walker(fps).clip, 1.08, height=False)
    once = clean_file(exports.bvh(skating), "walk.bvh", SETTINGS)
    assert once.status == "cleaned"
    again = clean_file(once.motion, "walk.bvh", SETTINGS)
    assert again.status == "unchanged" and again.motion == once.motion


def test_a_clip_without_contacts_is_the_same_file() -> None:
    data = exports.bvh(artefacts.drift(walker(60).clip, 0.2))
    for contacts in ((), (Contact(0, len(walker(60).clip), wish="forbid"),)):
        labels = Labels(dict.fromkeys(walker(60).contacts.names, contacts))
        outputs = clean_file(data, "walk.bvh", SETTINGS, labels=labels)
        assert outputs.status == "unchanged" and outputs.motion == data and outputs.report["plants"] == []


@pytest.mark.parametrize("frames", [3, 4, 6])
def test_a_clip_of_a_few_frames_is_cleaned_or_left(frames: int) -> None:
    clip = artefacts.drift(walker(60).clip, 2.0).frames(slice(0, frames))
    outputs = clean_file(exports.bvh(clip), "walk.bvh", SETTINGS)
    assert np.isfinite(decode(outputs.motion).values).all() and len(decode(outputs.motion).values) == frames


# ---- the same motion, however it is written ---------------------------------------------------------


@pytest.mark.parametrize("spelling", [
    Spelling(unit_m=1.0, decimals=8), Spelling(unit_m=0.0254, decimals=8), Spelling(unit_m=1.0, up="z", decimals=8),
    Spelling(order="XYZ", decimals=8),
], ids=["metres", "inches", "metres, z up", "other order"])  # fmt: skip
def test_units_and_axes_make_no_difference(spelling: Spelling) -> None:
    usual, other = wandering(Spelling(decimals=8)), wandering(spelling)
    rows = ("effector", "start", "end", "outcome")
    told, same = ([[plant[key] for key in rows] for plant in each.report["plants"]] for each in (usual, other))
    assert told == same and told
    one, two = (heights_and_spans(each.motion) for each in (usual, other))
    assert np.abs(one - two).max() < 1e-4


@cache
def wandering(spelling: Spelling) -> Outputs:
    """A walker that wanders, written in some way and cleaned."""
    skating = artefacts.wander(walker(30).clip, 0.04, slowest=1.0)
    return clean_file(exports.bvh(skating, spelling), "walk.bvh", SETTINGS)


def heights_and_spans(written: bytes) -> Floats:
    """(F, N) [m] what is the same in all axes: heights, and how far joints are from where the first one was first."""
    from footfix.motion.kinematics import forward

    at = forward(read(written, "walk.bvh", SETTINGS).clip).positions
    return np.concatenate([at[..., 1], np.linalg.norm(at - at[:1, :1], axis=-1)], axis=1)


# ---- labels -----------------------------------------------------------------------------------------


def test_labels_are_held_and_what_they_forbid_is_not() -> None:
    walk = walker(60)
    data = exports.bvh(artefacts.wander(walk.clip, 0.05, slowest=1.0))
    spans = {name: walk.contacts[name].contacts for name in walk.contacts.names}
    first, *others = spans["left_toe"]
    spans["left_toe"] = (replace(first, wish="forbid"), *(replace(c, wish="force") for c in others))
    outputs = clean_file(data, "walk.bvh", SETTINGS, labels=Labels(spans))
    rows = [(p["start"], p["end"]) for p in outputs.report["plants"] if p["effector"] == "left_toe"]
    assert rows == [(c.start, c.end) for c in others]
    slid = slides_of(outputs.motion, walk, "toe", "y")[: len(others) + 1]
    before = slides_of(data, walk, "toe", "y")[: len(others) + 1]
    assert max(slid[1:]) < 6.0 < max(before[1:])
