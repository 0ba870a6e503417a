"""All legs of a stream together are what enforcement says of each by itself."""

from __future__ import annotations

from dataclasses import fields

import numpy as np
import pytest
from streams import figure, legs_of, state

from footfix.detect.tracks import tracks_of
from footfix.enforce.correction import apply
from footfix.enforce.leg import LEG, ROOT, LegTracks
from footfix.enforce.leg import tracks as leg_tracks
from footfix.enforce.whole_clip import correction as whole_correction
from footfix.motion.clip import Floats
from footfix.stream.history import History
from footfix.stream.leg_rotations import Turner
from footfix.stream.legs import LegMeasurer, states_of


def alike(ours: LegTracks, known: LegTracks) -> bool:
    arrays = [each.name for each in fields(known) if isinstance(getattr(known, each.name), np.ndarray)]
    assert len(ours.points) == len(known.points)
    assert (ours.leg, ours.bends, ours.turns) == (known.leg, known.bends, known.turns)
    pairs = [(getattr(ours, name), getattr(known, name)) for name in arrays]
    return all(np.allclose(a, b, atol=1e-12) for a, b in [*pairs, *zip(ours.points, known.points, strict=True)])


@pytest.mark.parametrize("name", ["walk_skate", "turn", "walk_skate without toes"])
def test_legs_and_feet_are_those_of_a_whole_clip(name: str) -> None:
    sample_name, *bare = name.split()
    part, clip, pose, legs = figure(sample_name, bare=bool(bare))
    assert all((leg.toe is None) == bool(bare) for leg in part.known.rig.legs)
    known = leg_tracks(clip, part.known.rig, pose, part.known.legs)
    assert all(alike(ours, theirs) for ours, theirs in zip(legs.apart(), known, strict=True))
    places = legs.places()
    for k, leg in enumerate(known):
        for point in range(len(leg.points) + 1):
            assert np.allclose(places[:, point, k], leg.place(point), atol=1e-12)
    _, feet = LegMeasurer(part, pose.joints)(pose, clip.frame_time)
    expected = tracks_of(clip, part.known.rig, pose)
    assert np.allclose(feet.feet[1].heel, expected.feet[1].heel, atol=1e-12)
    assert np.allclose(feet.feet[0].toe, expected.feet[0].toe, atol=1e-12)


def test_stacking_taking_apart_and_remembering_loses_nothing() -> None:
    part, clip, pose, legs = figure("walk_skate")
    again = legs_of(legs.apart())
    past = History(legs.kinds, pose.joints, clip.skeleton, clip.frame_time, 5, 64)
    past.append(np.zeros((60, 5)), clip, legs, pose)
    for ours, theirs in ((again, legs), (past.legs(0), legs), (past.legs(20), legs.frames(slice(20, None)))):
        assert all(alike(a, b) for a, b in zip(ours.apart(), theirs.apart(), strict=True))
    assert np.array_equal(past.pose(10, 30).rotations, pose.rotations[10:30])
    assert np.array_equal(past.clip(10, 30).rotations, clip.rotations[10:30])
    assert np.array_equal(past.clip(10, 30).positions, clip.positions[10:30])
    assert part.known.rig.legs == legs.kinds.legs


def test_points_move_with_the_unknowns_as_differences_say() -> None:
    _, _, _, legs = figure("walk_skate")
    x, step = state(legs, 0.1), 1e-6
    at = legs.flexion.shape[0]

    def places(x: Floats) -> Floats:
        return states_of(legs, x[:ROOT], x[ROOT:].reshape(at, LEG, -1).swapaxes(0, 1)).places

    jacobian = states_of(legs, x[:ROOT], x[ROOT:].reshape(at, LEG, -1).swapaxes(0, 1)).jacobian
    for unknown in range(ROOT + LEG):
        moved = x.copy()
        moved[unknown] += step  # of the root and the first leg
        slope = (places(moved) - places(x))[:, :, 0] / step
        assert np.allclose(jacobian[0, :, :, unknown].reshape(-1, 3, 4), slope.transpose(2, 0, 1), atol=1e-5)


@pytest.mark.parametrize("name", ["walk_skate", "turn"])
def test_rotations_of_a_state_are_those_of_a_whole_clip(name: str) -> None:
    part, clip, pose, legs = figure(name)
    x = state(legs, 0.05)
    x[ROOT : ROOT + LEG] = 0.0  # one leg keeps its rotations
    shift = x[:ROOT].T
    columns = [slice(ROOT + LEG * k, ROOT + LEG * (k + 1)) for k in range(len(legs.kinds.legs))]
    known = whole_correction(clip, part.known.rig, pose, legs.apart(), x, columns, shift)
    turner = Turner(part, pose.joints, legs.kinds, frame_time=10.0)  # in which joints may turn as they like
    turned = turner.turn(pose, legs, x)
    assert not turned.late.any()
    found = turner.correction(clip, turned, shift)
    quickly, slowly = turner.corrected(clip, turned, shift), apply(clip, found)
    assert np.array_equal(quickly.rotations, slowly.rotations)
    assert np.array_equal(quickly.positions, slowly.positions)
    assert set(found.joints) == set(known.joints)
    ours, theirs = apply(clip, found), apply(clip, known)
    assert np.allclose(np.abs(np.sum(ours.rotations * theirs.rotations, axis=-1)), 1.0, atol=1e-12)
    assert np.allclose(ours.positions, theirs.positions, atol=1e-12)
