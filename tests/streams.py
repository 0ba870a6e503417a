"""Streams of sample clips, as several tests look at them."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import numpy as np
from conftest import SAMPLES
from exports import without_toes

import footfix
from footfix.detect.tracks import FootTracks, Tracks
from footfix.enforce.leg import LEG, ROOT, LegTracks
from footfix.enforce.pins import Pins
from footfix.enforce.task import posed_joints
from footfix.formats.bvh.document import Document
from footfix.motion.clip import Clip, Floats
from footfix.motion.kinematics import Pose, forward
from footfix.settings import Settings
from footfix.stream.calibration import calibrate
from footfix.stream.legs import POINTS, Kinds, LegMeasurer, Legs
from footfix.stream.pins import Stacked
from footfix.stream.subskeleton import Subskeleton, part_of

FRAMES = 110  # of a sample that are streamed


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
        FootTracks(
            f.side, f.hip[part], f.ankle[part], f.heel[part], f.toe[part], None if f.knee is None else f.knee[part]
        )
        for f in tracks.feet
    )
    return Tracks(tracks.pelvis[part], feet, tracks.leg_length, tracks.frame_time)


def figure(name: str, *, bare: bool = False) -> tuple[Subskeleton, Clip, Pose, Legs]:
    """A figure (`bare`: without its toe joints), some frames of it, their pose and its legs."""
    clip = sample(name).clip.frames(slice(60))
    clip = without_toes(clip) if bare else clip
    part = part_of(clip.skeleton, calibrate(clip, Settings()))
    own = Clip.from_tracks(
        part.skeleton, [clip.position(joint) for joint in part.joints],
        [clip.rotation(joint) for joint in part.joints], clip.frame_time,
    )  # fmt: skip
    pose = forward(own, posed_joints(part.skeleton, part.known.rig))
    return part, own, pose, LegMeasurer(part, pose.joints)(pose, clip.frame_time)[0]


def state(legs: Legs, size: float) -> Floats:
    shape = (ROOT + LEG * len(legs.kinds.legs), legs.flexion.shape[1])
    return np.random.default_rng(4).normal(size=shape) * size


def legs_of(legs: Sequence[LegTracks]) -> Legs:
    """Legs of a whole clip, stacked."""
    names = ("hip", "ankle", "line", "thigh", "shank", "axis", "toe_hinge", "reach")
    some = {name: np.stack([getattr(leg, name) for leg in legs], axis=1) for name in names}
    soles = np.stack([np.stack(leg.points[:2], axis=1) for leg in legs], axis=2)
    tip = np.stack([leg.points[2] if len(leg.points) > 2 else np.zeros_like(leg.hip) for leg in legs], axis=1)
    flexion, least = (np.stack([getattr(leg, name) for leg in legs]) for name in ("flexion", "least"))
    kinds = Kinds(
        tuple(leg.leg for leg in legs), tuple(len(leg.points) > 2 for leg in legs),
        tuple(leg.bends for leg in legs), tuple(leg.turns for leg in legs),
    )  # fmt: skip
    return Legs(kinds, **some, soles=soles, tip=tip, flexion=flexion, least=least)


def pins_stacked(pins: Sequence[Sequence[Pins]]) -> Stacked:
    """Pins of a whole clip, stacked; a point that a leg does not have asks for nothing."""
    out = Stacked.none(np.zeros((3, POINTS, len(pins), len(pins[0][0].draw))), np.zeros(3))
    for k, own in enumerate(pins):
        for point, pin in enumerate(own):
            for name in ("hold", "slip", "stands", "level", "draw", "lowest", "place", "placed"):
                getattr(out, name)[..., point, k, :] = getattr(pin, name)
        if own[-1].rise is not None:
            out.rise[k] = own[-1].rise
    return out
