"""What was found in a part of a clip, or in frames that are not repeated, counted among all frames."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from walks import rig_of
from walks import short_walk as walk

from footfix.enforce.correction import Correction
from footfix.enforce.footplant import Footplant
from footfix.enforce.original_frames import repeated, uncropped
from footfix.enforce.run import Enforcement
from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats
from footfix.motion.duplicate_frames import doubled
from footfix.notes import Note
from footfix.rig.motion_crop import Crop

UP = np.array([0.0, 1.0, 0.0])


def turned(degrees: Floats) -> Clip:
    """A walker whose every joint is turned about the vertical by so much in each frame (F,)."""
    clip = walk(duration=2.0).clip.frames(np.zeros(len(degrees), dtype=int))
    turns = rotation.from_axis_angle(np.tile(UP, (len(degrees), 1)), np.radians(degrees))
    return replace(clip, rotations=np.repeat(turns[:, None], len(clip.skeleton), axis=1))


def found(clip: Clip, frames: slice, shift: Floats, more: float = 10.0) -> Enforcement:
    """An enforcement of some frames: the root shifted (n, 3) [m], a knee turned by 10 degrees more."""
    rig = rig_of(walk())
    knee = rig.legs[0].knee
    turn = rotation.from_axis_angle(UP[None], np.radians([more]))
    rotations = rotation.multiply(turn, clip.rotations[frames, knee])[:, None]
    plants = (Footplant(0, 1, "left_toe", 0, "toe", 2, 5, held=((2, 4),)),)
    notes = (Note("some", "thing", start=1, end=3),)
    return Enforcement(plants, Correction(rig.root, shift, (knee,), rotations), notes, np.tile(UP, (len(shift), 1)))


def degrees_more(clip: Clip, done: Enforcement) -> Floats:
    """(F,) [degrees] by which the corrected joint is turned more than it was captured."""
    captured = clip.rotations[:, done.correction.joints[0]]
    more = rotation.multiply(done.correction.rotations[:, 0], rotation.inverse(captured))
    return np.asarray(np.degrees(rotation.to_rotation_vector(more)[:, 1]))


# A pose held for three frames, a fifth, two fifths and four fifths of the way to the motion, and the same back.
WAY = np.array([0.0, 0.0, 0.0, 10.0, 20.0, 40.0, *[50.0] * 6, 40.0, 15.0, 0.0, 0.0])
SHARE = np.array([0.0, 0.0, 0.0, 0.2, 0.4, 0.8, *[1.0] * 6, 0.8, 0.3, 0.0, 0.0])
MOTION = Crop(6, 12, len(WAY))


def test_frames_that_lead_to_the_motion_lead_over_to_its_correction() -> None:
    clip = turned(WAY)
    shift = np.outer(np.array([1.0, 2.0, 3.0, 4.0, 5.0, 6.0]), [0.01, 0.0, -0.02])
    done = uncropped(found(clip, MOTION.within, shift), clip, MOTION)
    edge = np.where(np.arange(len(WAY)) < 8, shift[0, 0], shift[-1, 0])
    whole = SHARE * edge
    whole[6:12] = shift[:, 0]
    assert done.correction.root_shift[:, 0] == pytest.approx(whole)
    assert degrees_more(clip, done) == pytest.approx(10.0 * SHARE, abs=1e-9)
    still = SHARE == 0.0
    assert np.array_equal(done.correction.rotations[still, 0], clip.rotations[still, done.correction.joints[0]])


def test_plants_notes_and_ground_are_counted_from_the_start_of_the_clip() -> None:
    clip = turned(WAY)
    done = uncropped(found(clip, MOTION.within, np.zeros((6, 3))), clip, MOTION)
    (plant,), (note,) = done.plants, done.notes
    assert (plant.start, plant.end, plant.held) == (8, 11, ((8, 10),))
    assert (note.start, note.end) == (7, 9)
    assert done.ground.shape == (len(WAY), 3)
    assert np.array_equal(done.ground[6:12], np.tile(UP, (6, 1)))


def test_a_correction_without_joints_and_one_of_the_whole_clip() -> None:
    clip = turned(WAY)
    rootless = found(clip, MOTION.within, np.tile(UP, (6, 1)))
    rootless = replace(rootless, correction=Correction(0, np.tile(UP, (6, 1)), (), np.zeros((6, 0, 4))))
    done = uncropped(rootless, clip, MOTION)
    assert done.correction.rotations.shape == (len(WAY), 0, 4)
    assert done.correction.root_shift[:, 1] == pytest.approx(SHARE)
    whole = found(clip, slice(None), np.zeros((len(WAY), 3)))
    assert uncropped(whole, clip, Crop(0, len(WAY), len(WAY))) is whole


def test_what_was_the_same_stays_the_same() -> None:
    once = turned(np.arange(20.0))
    clip = once.frames(np.repeat(np.arange(20), 2))  # each frame written twice
    thin = doubled(clip)
    assert thin
    kept = np.flatnonzero(np.diff(np.concatenate([[-1.0], np.repeat(np.arange(20.0), 2)])) != 0.0)
    shift = np.outer(np.arange(len(thin.clip(clip))), [0.01, 0.0, 0.0])
    done = repeated(found(clip, kept, shift), clip, thin)
    assert np.array_equal(done.correction.root_shift[0::2], done.correction.root_shift[1::2])
    assert done.correction.root_shift[0::2, 0] == pytest.approx(0.01 * np.arange(20))
    assert degrees_more(clip, done) == pytest.approx(np.full(40, 10.0))
    (plant,) = done.plants
    assert (plant.start, plant.end, plant.held) == (4, 10, ((4, 8),))
    same = found(once, slice(None), np.zeros((20, 3)))
    assert repeated(same, once, doubled(once)) is same


def test_repeats_that_differ_by_rounding_keep_what_they_differ_by_where_nothing_is_corrected() -> None:
    once = turned(np.arange(20.0))
    noise = np.where(np.arange(40) % 2, 1e-5, 0.0)  # [degrees]
    clip = turned(np.repeat(np.arange(20.0), 2) + noise)
    thin = doubled(clip)
    done = found(once, slice(None), np.zeros((20, 3)))
    half = done.correction.rotations.copy()
    knee = done.correction.joints[0]
    half[:10, 0] = once.rotation(knee)[:10]  # the first ten frames need nothing
    done = replace(done, correction=replace(done.correction, rotations=half))
    back = repeated(done, clip, thin).correction.rotations[:, 0]
    assert np.array_equal(back[:20], clip.rotation(knee)[:20])
    assert np.array_equal(back[20::2], back[21::2])
