"""Run one detector over a clip, or over its motion range alone."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Literal, get_args

import numpy as np

from footfix.detect.adaptive import AdaptiveParams, adaptive
from footfix.detect.auto import AutoParams, auto
from footfix.detect.foot_locks import let_go
from footfix.detect.lyard import LyardParams, lyard
from footfix.detect.threshold import ThresholdParams, threshold
from footfix.detect.tracks import Finding, Tracks, tracks_of
from footfix.motion.clip import Clip
from footfix.motion.contacts import Contacts
from footfix.motion.duplicate_frames import DuplicateFrames, doubled
from footfix.notes import Note
from footfix.rig.gait_in_place import carried, gait_in_place
from footfix.rig.motion_crop import crop
from footfix.rig.repeated_rounds import Rounds, rounds_of
from footfix.rig.rig import Rig

Method = Literal["auto", "threshold", "adaptive", "lyard"]
METHODS: tuple[Method, ...] = get_args(Method)

# A frame rate outside these is a mistake (milliseconds for seconds), and would cause absurd amounts of work.
_SLOWEST, _QUICKEST, _ASSUMED = 2.0, 2000.0, 30.0  # [fps]


@dataclass(frozen=True, kw_only=True)
class DetectParams:
    """Which detector, and the parameters of each.

    Args:
        method: "auto" (ours), "threshold" (Kim & Neff), "adaptive" (Glardon et al.) or "lyard" (Lyard &
            Magnenat-Thalmann).
        threshold, adaptive, lyard, auto: their parameters.
    """

    method: Method = "auto"
    threshold: ThresholdParams = field(default_factory=ThresholdParams)
    adaptive: AdaptiveParams = field(default_factory=AdaptiveParams)
    lyard: LyardParams = field(default_factory=LyardParams)
    auto: AutoParams = field(default_factory=AutoParams)


def detect(clip: Clip, rig: Rig, params: DetectParams = DetectParams()) -> Contacts:
    """Find when heel and toe of each foot are planted; frames before and after the motion range are left out.

    Args:
        clip: in metres, y up.
        rig: its legs and sole points.
        params: which detector.

    Returns:
        Contacts for each sole point of the rig, with notes on what is doubtful.
    """
    motion = crop(clip, rig)
    own = motion.clip(clip)
    thin = doubled(own)
    rounds = None if any(motion.cut) else rounds_of(thin.clip(own), rig, "find")
    return motion.contacts_back(detect_over(own, rig, params, thin, rounds))


def detect_over(clip: Clip, rig: Rig, params: DetectParams, thin: DuplicateFrames, rounds: Rounds | None) -> Contacts:
    """Find the contacts of a clip without lead-in frames, leaving out repeated frames; a cycle as several rounds.

    Args:
        clip: F frames in metres, y up.
        rig: its legs and sole points.
        params: which detector.
        thin: which of the frames repeat the one before.
        rounds: of the other frames, where the clip is a cycle.
    """
    if rounds:
        return thin.contacts_back(rounds.contacts_back(detect_contacts(rounds.clip, rig, params)))
    return thin.contacts_back(detect_contacts(thin.clip(clip), rig, params))


def detect_contacts(clip: Clip, rig: Rig, params: DetectParams = DetectParams()) -> Contacts:
    """Find when heel and toe of each foot are planted, in a clip without lead-in frames.

    Args:
        clip: in metres, y up.
        rig: its legs and sole points.
        params: which detector.

    Returns:
        Contacts for each sole point of the rig, with notes on what is doubtful.
    """
    pose = rig.pose(clip)
    gait = gait_in_place(rig, pose, clip.frame_time)
    if gait is not None:  # a gait in place: planted feet move with the ground, so motion relative to it counts
        pose = rig.pose(carried(clip, rig, gait.passed))
    # Legs that stand on their toes have no heel that bears weight: the network is fitted to estimated soles there.
    tracks = tracks_of(clip, rig, pose, mesh=params.method == "lyard", watched=params.method == "auto")
    finding = find(tracks, params)
    # detectors answer heel, toe for each leg; the rig may list its sole points in another order
    order = [2 * sole.leg + (sole.part == "toe") for sole in rig.soles]
    confidence = None if finding.confidence is None else finding.confidence[:, order]
    contacts = rig.no_contacts(clip).with_mask(finding.mask[:, order], confidence)
    return replace(contacts, method=params.method, notes=finding.notes)


def find(tracks: Tracks, params: DetectParams) -> Finding:
    """Detect contacts from tracks alone."""
    if len(tracks) < 2:
        return Finding(np.zeros((len(tracks), 2 * len(tracks.feet)), dtype=np.bool_))
    if not _SLOWEST <= 1.0 / tracks.frame_time <= _QUICKEST:
        text = (
            f"no motion is captured at {1.0 / tracks.frame_time:.4g} fps; contacts were looked for "
            f"as if it were {_ASSUMED:.0f} fps"
        )
        finding = find(replace(tracks, frame_time=1.0 / _ASSUMED), params)
        return finding._replace(notes=(*finding.notes, Note("frame-rate-implausible", text, "warning")))
    finding = _by_method(tracks, params)
    return finding._replace(mask=let_go(finding.mask, tracks))


def _by_method(tracks: Tracks, params: DetectParams) -> Finding:
    if params.method == "threshold":
        return threshold(tracks, params.threshold)
    if params.method == "adaptive":
        return adaptive(tracks, params.adaptive, params.threshold)
    if params.method == "lyard":
        return lyard(tracks, params.lyard)
    return auto(tracks, params.auto)
