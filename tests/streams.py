"""Streams of sample clips, as several tests look at them."""

from __future__ import annotations

from functools import cache

import numpy as np
from conftest import SAMPLES

import footfix
from footfix.detect.tracks import Foot, Tracks
from footfix.enforce.leg import LEG, ROOT
from footfix.enforce.task import posed_joints
from footfix.formats.bvh.document import Document
from footfix.motion.clip import Clip, Floats
from footfix.motion.kinematics import Pose, forward
from footfix.settings import Settings
from footfix.stream.calibration import calibrate
from footfix.stream.legs import Legs, Measure
from footfix.stream.part import Part, part_of

FRAMES = 150  # of a sample that are streamed


@cache
def sample(name: str) -> Document:
    """A sample clip as a file, in metres and y up."""
    document = footfix.load(str(SAMPLES / f"{name}.bvh"))
    assert isinstance(document, Document)
    return document


@cache
def streamed(name: str, look_ahead: float = 0.15) -> tuple[Floats, list[object], int]:
    """The rows of a sample as they come out, the frames, and how many came out with each that came in at most."""
    document = sample(name)
    stream = footfix.Stream(document, look_ahead)
    frames, most = [], 0
    for row in document.values[:FRAMES]:
        due = stream.push(row)
        most = max(most, len(due))
        frames += due
    frames += stream.close()
    return np.stack([frame.values for frame in frames]), list(frames), most


def cut(tracks: Tracks, start: int, stop: int) -> Tracks:
    """Some frames of tracks."""
    part = slice(start, stop)
    feet = tuple(
        Foot(f.side, f.hip[part], f.ankle[part], f.heel[part], f.toe[part], None if f.knee is None else f.knee[part])
        for f in tracks.feet
    )
    return Tracks(tracks.pelvis[part], feet, tracks.leg_length, tracks.frame_time)


def figure(name: str) -> tuple[Part, Clip, Pose, Legs]:
    """A figure, some frames of it, their pose and its legs."""
    clip = sample(name).clip.frames(slice(60))
    part = part_of(clip.skeleton, calibrate(clip, Settings()))
    own = Clip.from_tracks(
        part.skeleton, [clip.position(joint) for joint in part.joints],
        [clip.rotation(joint) for joint in part.joints], clip.frame_time,
    )  # fmt: skip
    pose = forward(own, posed_joints(part.skeleton, part.known.rig))
    return part, own, pose, Measure(part, pose.joints)(pose, clip.frame_time)[0]


def state(legs: Legs, size: float) -> Floats:
    shape = (ROOT + LEG * len(legs.kinds.legs), legs.flexion.shape[1])
    return np.random.default_rng(4).normal(size=shape) * size
