"""Calibration of a stream's figure, on its first seconds or on another clip of the same figure."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from footfix.detect.evidence import resample
from footfix.detect.run import detect_contacts
from footfix.detect.tracks import tracks_of
from footfix.enforce.leg import LegCalibration
from footfix.enforce.plant_faults import faults as faults_of
from footfix.enforce.task import task_of
from footfix.enforce.whole_clip import noises
from footfix.motion.clip import Bools, Clip, Floats
from footfix.notes import Note
from footfix.rig.find import find_rigs
from footfix.rig.followers import Follower, find_followers
from footfix.rig.motion_crop import crop
from footfix.rig.rig import Rig
from footfix.settings import Settings

LEAST = 0.3  # [s] least duration of motion to calibrate on
_USUAL_FAULT = 80  # [percentile] of the faults of a clip's plants


@dataclass(frozen=True, eq=False)
class Calibration:
    """A figure, and properties of its capture.

    Args:
        rig: its legs, soles and floor.
        mates: for each foot the other one of its pair.
        jitter: noise of the capture, in thousandths of a leg.
        legs: the calibration of each leg for enforcement.
        rest: (E,) [m] height of each effector's joint while it is planted, with the figure raised.
        tips: (legs,) [m] height of the toes' tips while the foot lies flat.
        lift: [m] by which the whole figure is raised.
        noise, white: (U,) of each unknown of enforcement.
        fault: [m] how far plants usually stray.
        belt: (3,) [m/s] velocity of the ground under planted feet, zeros on a floor at rest.
        followers: joints outside the legs that go along with a foot.
        notes: how each of these was found, and what is doubtful.
    """

    rig: Rig
    mates: tuple[int, ...]
    jitter: float
    legs: tuple[LegCalibration, ...]
    rest: Floats
    tips: Floats
    lift: float
    noise: Floats
    white: Bools
    fault: float
    belt: Floats
    followers: tuple[Follower, ...]
    notes: tuple[Note, ...]


def calibrate(clip: Clip, settings: Settings) -> Calibration:
    """Measure a figure.

    Args:
        clip: of the figure, moving or standing, metres, y up.
        settings: how rig and contacts are found, and contacts enforced.

    Raises:
        NoLegsError: it has no legs.
    """
    rigs = find_rigs(clip, settings.rig)
    rig = rigs[0]
    own = crop(clip, rig).clip(clip)
    contacts = detect_contacts(own, rig, settings.detect)
    task = task_of(own, rig, contacts, settings.enforce)
    sampled = resample(tracks_of(own, rig))
    noise, white = noises(task, rig)
    heights = settings.enforce.heights == "floor"
    footing = replace(task.footing, keep=(False,) * len(task.footing.plants))
    faults = faults_of(footing, task.legs, own.frame_time, heights=heights, edge=settings.enforce.pins.edge)
    fault = float(np.percentile(faults[np.isfinite(faults)], _USUAL_FAULT)) if np.isfinite(faults).any() else 0.0
    steps = np.diff(footing.ground, axis=0)
    moving = np.any(steps != 0.0, axis=1)
    belt = np.median(steps[moving], axis=0) / own.frame_time if moving.mean() > 0.5 else np.zeros(3)
    notes = (*rig.notes, *task.notes)
    if len(rigs) > 1:
        text = f"{len(rigs)} figures: the feet of the first are held, the others pass as they are"
        notes += (Note("one-figure", text, "warning"),)
    return Calibration(
        rig, sampled.mates, sampled.jitter, task.calibration, footing.floors.rest, footing.floors.tips, task.lift,
        noise, white, fault, np.asarray(belt), find_followers(own, rig), notes,
    )  # fmt: skip
