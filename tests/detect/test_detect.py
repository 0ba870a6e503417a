"""The default detector holds what a contact detector must: the laws of symmetry, and contacts that are known."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import artefacts
import numpy as np
import pytest
from walker import Walk, make
from walker_plan import Gait

import footfix
from footfix.detect.auto import AutoParams, log_probabilities
from footfix.detect.evidence import resample
from footfix.detect.run import METHODS, DetectParams, Method, detect
from footfix.detect.tracks import tracks_of
from footfix.detect.weights import network
from footfix.formats import bvh
from footfix.formats.bvh.compose import compose
from footfix.measure import agreement
from footfix.motion import rotation
from footfix.motion.clip import Bools, Clip
from footfix.motion.contacts import Contacts
from footfix.rig.find import find_rig
from footfix.rig.units import infer_units

GAITS = ("walk", "run", "turn", "stairs", "backwards", "sideways", "jump")


@cache
def walk(name: str = "walk", fps: float = 60.0, seed: int = 1) -> Walk:
    return make(Gait(name=name, fps=fps, seed=seed))  # type: ignore[arg-type]


def contacts_of(clip: Clip, method: Method = "auto") -> Contacts:
    return detect(clip, find_rig(clip), DetectParams(method=method))


@cache
def found(name: str = "walk", fps: float = 60.0) -> Bools:
    return contacts_of(walk(name, fps).clip).mask()


def scores(mask: Bools, known: Contacts) -> list[float]:
    """F1 of each effector, 30 ms forgiven."""
    tolerance, true = round(0.03 / known.frame_time), known.mask()
    return [agreement.frames(mask[:, k], true[:, k], tolerance=tolerance).f1 for k in range(true.shape[1])]


def within_a_frame(one: Bools, other: Bools, frames: int = 1) -> bool:
    """Whether masks differ nowhere but this near to where the one starts or ends a contact."""
    return all(
        agreement.frames(other[:, k], one[:, k], tolerance=frames).f1 == 1.0 for k in range(one.shape[1])
    )


def all_of_it(clip: Clip) -> Clip:
    return artefacts.shake(artefacts.drift(artefacts.scale_root(clip, 0.85), 0.05), 0.4)


FAULTS: dict[str, Callable[[Clip], Clip]] = {
    "root scaled by 0.85": lambda clip: artefacts.scale_root(clip, 0.85),
    "root scaled by 1.15": lambda clip: artefacts.scale_root(clip, 1.15),
    "5 cm of drift": lambda clip: artefacts.drift(clip, 0.05),
    "0.4 degrees of noise": lambda clip: artefacts.shake(clip, 0.4),
    "all of it": all_of_it,
}


def test_contacts_of_clean_walkers_are_found() -> None:
    assert np.mean([scores(found(name), walk(name).contacts) for name in GAITS]) >= 0.96


@pytest.mark.parametrize("fault", list(FAULTS))
def test_contacts_are_found_in_spite_of(fault: str) -> None:
    results = [
        scores(contacts_of(FAULTS[fault](walk(name).clip)).mask(), walk(name).contacts) for name in GAITS
    ]
    assert np.mean(results) >= 0.92


@pytest.mark.parametrize("name", ["walk", "stairs"])
@pytest.mark.parametrize(
    ("change", "swapped"),
    [
        (lambda clip: artefacts.turned(clip, 2.0), False),
        (lambda clip: artefacts.turned(clip, 0.0, (30.0, -70.0)), False),
        (lambda clip: artefacts.sink(clip, 0.3), False),
        (lambda clip: artefacts.scaled(clip, 0.4), False),
        (artefacts.mirrored, True),
    ],
    ids=["turned", "moved", "sunk", "smaller", "mirrored"],
)  # fmt: skip
def test_contacts_do_not_depend_on_where_how_large_or_which_side(
    name: str, change: Callable[[Clip], Clip], swapped: bool
) -> None:
    mask = contacts_of(change(walk(name).clip)).mask()
    order = [2, 3, 0, 1] if swapped else [0, 1, 2, 3]
    assert within_a_frame(found(name), mask[:, order])


@pytest.mark.parametrize(("unit", "up"), [(1.0, "y"), (0.0254, "y"), (0.01, "z")])
def test_contacts_do_not_depend_on_the_units_and_axes_of_the_file(unit: float, up: str) -> None:
    clip = walk().clip
    if up == "z":
        tip = rotation.from_axis_angle(np.array([1.0, 0.0, 0.0]), np.array(np.pi / 2))
        positions, rotations = clip.positions.copy(), clip.rotations.copy()
        positions[:, 0] = rotation.rotate(tip, positions[:, 0])
        rotations[:, 0] = rotation.multiply(tip, rotations[:, 0])
        clip = replace(clip, positions=positions, rotations=rotations)
    document = bvh.decode(compose(clip, unit_m=unit))
    seen = infer_units(document.clip)
    assert (seen.unit_m, seen.up) == (pytest.approx(unit), up)
    placed = document.placed(unit_m=seen.unit_m, up=seen.up).clip
    assert within_a_frame(found(), contacts_of(placed).mask())


@pytest.mark.parametrize("name", GAITS[::2])
def test_half_the_frames_give_the_same_contacts_to_one_frame(name: str) -> None:
    clip = walk(name, 120.0).clip
    half = replace(clip.frames(slice(0, None, 2)), frame_time=2.0 * clip.frame_time)
    full = found(name, 120.0)[::2]
    assert within_a_frame(full, contacts_of(half).mask())


def test_both_feet_of_a_figure_that_stands_stay_planted() -> None:
    clip = walk("stand").clip
    still = clip.frames(np.zeros(200, dtype=np.intp))
    assert contacts_of(still).mask().all()


def test_nothing_is_planted_in_flight() -> None:
    jumper = walk("jump", 120.0)
    true = jumper.contacts.mask().any(axis=1)
    flight = ~true & ~np.roll(true, 6) & ~np.roll(true, -6)
    assert flight.sum() > 30
    assert not found("jump", 120.0)[flight].any()


def test_planted_feet_that_move_with_a_belt_are_found() -> None:
    assert np.mean(scores(found("treadmill"), walk("treadmill").contacts)) >= 0.96


def test_a_lead_in_is_no_contact_and_changes_none() -> None:
    clip = walk().clip
    led = contacts_of(artefacts.t_pose_first(clip, 1)).mask()
    assert not led[0].any()
    assert within_a_frame(found(), led[1:])


def test_a_foot_without_a_toe_joint_still_has_both() -> None:
    clip = walk().clip
    kept = [j for j, name in enumerate(clip.skeleton.names) if "Toe" not in name]
    bare = bvh.decode(_without(clip, kept)).placed(unit_m=0.01).clip
    contacts = contacts_of(bare)
    assert contacts.names == ("left_heel", "left_toe", "right_heel", "right_toe")
    assert np.mean(scores(contacts.mask(), walk().contacts)) >= 0.9


def _without(clip: Clip, kept: list[int]) -> bytes:
    skeleton = clip.skeleton
    new = {old: k for k, old in enumerate(kept)}
    less = replace(
        skeleton,
        names=tuple(skeleton.names[j] for j in kept),
        parents=np.array([new.get(int(skeleton.parents[j]), -1) for j in kept]),
        offsets=skeleton.offsets[kept],
        end_parents=np.zeros(0, np.intp), end_offsets=np.zeros((0, 3)),
        translates=skeleton.translates[kept], rotates=skeleton.rotates[kept],
    )  # fmt: skip
    return compose(Clip(less, clip.positions[:, kept], clip.rotations[:, kept], clip.frame_time))


def test_a_plant_rolls_from_heel_to_toe() -> None:
    contacts = contacts_of(walk().clip)
    for side in ("left", "right"):
        heels, toes = contacts[f"{side}_heel"].contacts, contacts[f"{side}_toe"].contacts
        rolled = [(h, t) for h in heels for t in toes if h.start < t.start < h.end and t.end < contacts.frames]
        assert len(rolled) >= 2
        assert all(h.start < t.start < h.end < t.end for h, t in rolled)


def test_confidence_is_a_share_and_lower_where_a_clip_is_bad() -> None:
    clean, bad = contacts_of(walk().clip), contacts_of(artefacts.shake(walk().clip, 3.0))
    means = []
    for contacts in (clean, bad):
        said = [each.confidence for effector in contacts.effectors for each in effector.contacts]
        assert all(0.0 <= confidence <= 1.0 for confidence in said)
        means.append(np.mean(said))
    assert means[0] > means[1]


@pytest.mark.parametrize(("factor", "told"), [(0.2, True), (1.0, False), (5.0, True)])
def test_a_frame_rate_that_no_walk_has_is_told(factor: float, told: bool) -> None:
    clip = make(Gait(duration=8.0)).clip
    notes = contacts_of(replace(clip, frame_time=clip.frame_time * factor)).notes
    assert ("frame-rate-implausible" in {note.id for note in notes}) == told


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("frame_time", [33.3, 1e-7])
def test_a_frame_time_that_is_a_slip_is_told_and_costs_nothing(method: Method, frame_time: float) -> None:
    clip = walk("walk", 30.0).clip
    rig, params = find_rig(clip), DetectParams(method=method)
    contacts = detect(replace(clip, frame_time=frame_time), rig, params)
    assert "frame-rate-implausible" in {note.id for note in contacts.notes}
    assert np.array_equal(contacts.mask(), detect(clip, rig, params).mask())
    assert contacts.frame_time == frame_time


def test_chunks_change_nothing() -> None:
    clip = walk("turn").clip
    sampled = resample(tracks_of(clip, find_rig(clip)))
    _, at_once = log_probabilities(sampled, AutoParams(), network())
    _, in_chunks = log_probabilities(sampled, AutoParams(), network(), chunk=70)
    for whole, parts in zip(at_once, in_chunks, strict=True):
        assert parts == pytest.approx(whole, abs=1e-9)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("frames", [0, 1, 2, 3, 5, 9])
def test_short_clips_have_contacts_of_their_length(method: Method, frames: int) -> None:
    clip = walk().clip
    contacts = detect(clip.frames(slice(0, frames)), find_rig(clip), DetectParams(method=method))
    assert contacts.mask().shape == (frames, 4)


def test_the_package_is_the_function_of_the_api() -> None:
    # by now the package has been imported, which puts it in the function's place
    clip = walk().clip
    assert np.array_equal(footfix.detect(clip, find_rig(clip)).mask(), found())


def test_one_leg_or_four_are_contacts_too() -> None:
    clip = walk().clip
    rig = find_rig(clip)
    one = replace(rig, legs=rig.legs[:1], soles=rig.soles[:2])
    known = replace(walk().contacts, effectors=walk().contacts.effectors[:2])
    assert np.mean(scores(detect(clip, one).mask(), known)) > 0.8
    # fore and hind legs that do the same, in an order that pairs no neighbours
    legs = tuple(replace(rig.legs[k], name=name) for k, name in ((0, "a"), (1, "b"), (1, "c"), (0, "d")))
    soles = tuple(replace(rig.soles[2 * (k in (1, 2)) + part], leg=k) for k in range(4) for part in (0, 1))
    mask = detect(clip, replace(rig, legs=legs, soles=soles)).mask()
    assert np.array_equal(mask[:, :2], mask[:, 6:])
    assert np.array_equal(mask[:, 2:4], mask[:, 4:6])
