"""Lyard's root-only correction."""

from __future__ import annotations

import artefacts
import numpy as np
import pytest
from walks import cleaned, rig_of, slides, walk

from footfix.enforce.root import RootParams, correction, cubic_roots
from footfix.enforce.run import EnforceParams


def test_cubic_roots_are_numpys() -> None:
    rng = np.random.default_rng(0)
    coefficients = rng.normal(size=(300, 4))
    for c, found in zip(coefficients, cubic_roots(coefficients), strict=True):
        expected = np.roots(c)
        expected = np.sort(expected[np.abs(expected.imag) < 1e-9].real)
        assert np.allclose(np.sort(found[np.isfinite(found)]), expected, atol=1e-6)


def test_cubic_roots_of_squares_lines_and_threefold_roots() -> None:
    found = cubic_roots(np.array([
        [0.0, 1.0, -3.0, 2.0], [0.0, 0.0, 2.0, -1.0], [1.0, -3.0, 3.0, -1.0], [0.0, 0.0, 0.0, 1.0],
        [0.0, 1.0, 0.0, 1.0],
    ]))  # fmt: skip
    assert np.allclose(np.sort(found[0, :2]), [1.0, 2.0])
    assert np.isclose(found[1, 0], 0.5)
    assert np.allclose(found[2], 1.0, atol=1e-5)
    assert np.isnan(found[3:]).all()


@pytest.mark.parametrize("gait", ["walk", "run", "turn", "backwards", "stairs"])
@pytest.mark.parametrize(
    "artefact",
    [
        lambda clip: artefacts.drift(clip, 0.05),
        lambda clip: artefacts.wander(clip, 0.05, slowest=1.0),
        lambda clip: artefacts.scale_root(clip, 0.9, height=False),
        lambda clip: artefacts.scale_root(clip, 1.1, height=False),
        lambda clip: artefacts.shake(clip, 0.5, slowest=0.3),
    ],
)
def test_the_root_alone_stills_single_support(gait: str, artefact) -> None:  # type: ignore[no-untyped-def]
    made = walk(gait)
    rig = rig_of(made)
    clip = artefact(made.clip)
    after, _ = cleaned(clip, rig, made.contacts, EnforceParams(method="root"))
    assert np.array_equal(after.rotations, clip.rotations)
    assert np.array_equal(after.positions[:, 1:], clip.positions[:, 1:])
    mask = made.contacts.mask()
    found = []
    for e in (1, 3):
        other = mask[:, [k for k in range(4) if k // 2 != e // 2]].any(axis=1)
        track = rig.tracks(rig.pose(after))[e]
        for contact in made.contacts.effectors[e].contacts:
            alone = track[contact.start : contact.end][~other[contact.start : contact.end]][:, [0, 2]]
            if len(alone) > 2:
                found.append(float(np.linalg.norm(alone - np.median(alone, axis=0), axis=1).max()))
    assert np.percentile(found, 90) <= 0.008


def test_in_flight_the_root_keeps_its_own_velocity() -> None:
    made = walk("run")
    rig = rig_of(made)
    clip = artefacts.scale_root(made.clip, 1.1, height=False)
    after, _ = cleaned(clip, rig, made.contacts, EnforceParams(method="root"))
    air = ~made.contacts.mask().any(axis=1)
    both = air[1:] & air[:-1]
    steps = [np.diff(each.positions[:, 0, [0, 2]], axis=0)[both] for each in (clip, after)]
    assert both.sum() > 10 and np.allclose(*steps, atol=1e-12)


def test_the_known_scale_of_a_scaled_path_is_undone() -> None:
    made = walk()
    rig = rig_of(made)
    clip = artefacts.scale_root(made.clip, 1.1, height=False)
    after, _ = cleaned(clip, rig, made.contacts, EnforceParams(method="root"))
    length = [np.linalg.norm((c.positions[-1] - c.positions[0])[0, [0, 2]]) for c in (made.clip, after)]
    assert np.isclose(*length, rtol=0.01)


@pytest.mark.parametrize("depth", [0.03, -0.04])
def test_one_offset_brings_the_plants_to_the_floor(depth: float) -> None:
    made = walk()
    rig = rig_of(made)
    after, _ = cleaned(artefacts.sink(made.clip, depth), rig, made.contacts, EnforceParams(method="root"))
    assert np.allclose(after.positions[:, 0, 1], made.clip.positions[:, 0, 1], atol=0.002)


def test_alpha_minimises_what_lyard_minimises() -> None:
    rng = np.random.default_rng(2)
    frames = 80
    root = np.zeros((frames, 3))
    root[:, 1] = 0.9 + 0.03 * np.sin(np.arange(frames) / 6.0)
    track = np.zeros((frames, 3))
    track[:, 1] = 0.4 * (root[:, 1] - 0.9) + 0.001 * rng.normal(size=frames) + 0.02
    planted, levels = np.ones((frames, 1), dtype=bool), np.zeros((frames, 1))
    shift = correction(root, [track], planted, levels, 1 / 30, 0.9, RootParams())[:, 1]
    best = np.sum((track[:, 1] + shift) ** 2)
    r = root[:, 1] - root[:, 1].mean()
    for offset, slope in ((0.001, 0.0), (-0.001, 0.0), (0.0, 0.02), (0.0, -0.02)):
        assert np.sum((track[:, 1] + shift + offset + slope * r) ** 2) > best


def test_a_pinned_end_comes_back() -> None:
    made = walk()
    rig = rig_of(made)
    clip = artefacts.drift(made.clip, 0.3)
    drifts, _ = cleaned(clip, rig, made.contacts, EnforceParams(method="root"))
    pinned, _ = cleaned(clip, rig, made.contacts, EnforceParams(method="root", root=RootParams(pin_end=True)))
    off = [np.linalg.norm((each.positions[-1] - clip.positions[-1])[0, [0, 2]]) for each in (drifts, pinned)]
    assert off[0] > 0.2 and off[1] < 1e-9
    # the way back is spread over the clip: no step of it is a jump
    steps = np.linalg.norm(np.diff((pinned.positions - clip.positions)[:, 0, [0, 2]], axis=0), axis=1)
    assert steps.max() < 0.01


def test_shared_between_root_and_legs() -> None:
    made = walk()
    rig = rig_of(made)
    clip = artefacts.sink(artefacts.wander(made.clip, 0.05, slowest=1.0), 0.01)
    after, found = cleaned(clip, rig, made.contacts, EnforceParams(method="both"))
    slid = slides(after, rig, made.contacts)
    assert max(slid["toe"] + slid["heel"]) < 1.0
    _, legs_alone = cleaned(clip, rig, made.contacts)
    moves = [np.abs(each.correction.root_shift[:, [0, 2]]).max() for each in (found, legs_alone)]
    assert moves[0] > 0.01 and moves[1] == 0.0
