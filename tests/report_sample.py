"""A small figure with known motion, its contacts and its report, for the tests of the report."""

from __future__ import annotations

import dataclasses
import json
from typing import Any

import numpy as np

from footfix.formats.contacts import encode_json
from footfix.motion import rotation
from footfix.motion.clip import Clip, Skeleton
from footfix.motion.contacts import Contact, Contacts
from footfix.report.web.motion import Motion, film
from footfix.rig.rig import Leg, Rig, SolePoint

# What a stranger may call a file or a joint.
HOSTILE = (
    "</script><script>window.pwned=1</script>",
    '"><img src=http://evil.example/x.png onerror="window.pwned=1">',
    "'onmouseover='window.pwned=1' ${style} $data <!-- ]]> <svg/onload=window.pwned=1>",
    "line\u2028and\u2029paragraph \u202eright to left \x00 \ud800 javascript:window.pwned=1",
    "//evil.example/share https://evil.example/?a=1&b=2 &lt;b&gt;",
)

_NAMES = (
    "Hips", "LeftUpLeg", "LeftLeg", "LeftFoot", "LeftToe", "RightUpLeg", "RightLeg", "RightFoot", "RightToe",
    "Spine", "Head", HOSTILE[0], HOSTILE[1],
)  # fmt: skip
_PARENTS = (-1, 0, 1, 2, 3, 0, 5, 6, 7, 0, 9, 9, 9)
_OFFSETS = (
    (0, 0.9, 0), (0.1, 0, 0), (0, -0.42, 0), (0, -0.4, 0), (0, -0.07, 0.13), (-0.1, 0, 0), (0, -0.42, 0),
    (0, -0.4, 0), (0, -0.07, 0.13), (0, 0.5, 0), (0, 0.25, 0), (0.2, -0.1, 0), (-0.2, -0.1, 0),
)  # fmt: skip


def walker(frames: int, fps: float = 120.0) -> Clip:
    """A figure that swings its legs and goes along z at 1.2 m/s."""
    names = _NAMES
    skeleton = Skeleton(names, np.array(_PARENTS), np.array(_OFFSETS), np.array([4, 8, 10]), np.full((3, 3), 0.05))
    t = np.arange(frames) / fps
    positions = np.broadcast_to(skeleton.offsets, (frames, len(names), 3)).copy()
    positions[:, 0, 2] = 1.2 * t
    positions[:, 0, 1] += 0.02 * np.cos(4.0 * np.pi * t)
    turns = rotation.identity((frames, len(names)))
    for joint, phase in ((1, 0.0), (5, np.pi)):
        swing = 0.4 * np.sin(2.0 * np.pi * t + phase)
        turns[:, joint] = rotation.from_axis_angle(np.array([[1.0, 0.0, 0.0]]), swing)
    return Clip(skeleton, positions, turns, 1.0 / fps)


def rig() -> Rig:
    legs = (Leg("left", "left", 1, 2, 3, 4, (1, 2, 3)), Leg("right", "right", 5, 6, 7, 8, (5, 6, 7)))
    soles = (
        SolePoint("left_heel", 0, "heel", 3, (0.0, -0.07, -0.05)),
        SolePoint("left_toe", 0, "toe", 4, (0.0, 0.0, 0.0)),
        SolePoint("right_heel", 1, "heel", 7, (0.0, -0.07, -0.05)),
        SolePoint("right_toe", 1, "toe", 8, (0.0, 0.0, 0.0)),
    )
    return Rig(0, 0, legs, soles, 0.82, 0.01)


def without_toe_joints() -> Rig:
    """The same, its toe joints taken for no part of its feet, which are held above where these are."""
    known = rig()
    soles = (dataclasses.replace(sole, held=(0.0, 0.04, 0.01)) if sole.part == "toe" else sole for sole in known.soles)
    legs = (dataclasses.replace(leg, toe=None) for leg in known.legs)
    return dataclasses.replace(known, legs=tuple(legs), soles=tuple(soles))


def corrected(clip: Clip) -> Clip:
    """The walker with its root shifted and one knee bent: a shift of all, and joints that move besides."""
    positions, rotations = clip.positions.copy(), clip.rotations.copy()
    t = np.arange(len(clip)) * clip.frame_time
    positions[:, 0] += 0.01 * np.stack([np.sin(t), -np.ones_like(t), np.cos(3.0 * t)], axis=1)
    rotations[:, 2] = rotation.from_axis_angle(np.array([[1.0, 0.0, 0.0]]), 0.1 + 0.1 * np.sin(t))
    return dataclasses.replace(clip, positions=positions, rotations=rotations)


def labelled(frames: int) -> Contacts:
    """Every effector planted 20 to 70 of each 120 frames, the first one forced and with a place."""
    clip = walker(4)
    spans = [(a + 20, min(a + 70, frames)) for a in range(0, frames - 20, 120)]
    contacts = tuple(Contact(a, b, 0.875, (0.125, 0.0, 1.5) if k == 0 else None) for k, (a, b) in enumerate(spans))
    contacts = (*(dataclasses.replace(each, wish="force") for each in contacts[:1]), *contacts[1:])
    blank = rig().no_contacts(clip)
    effectors = tuple(dataclasses.replace(each, joint=HOSTILE[0], contacts=contacts) for each in blank.effectors)
    return dataclasses.replace(blank, frames=frames, effectors=effectors, method="auto")


def contacts_document(frames: int) -> dict[str, Any]:
    source = {"file": HOSTILE[1], "sha256": "0" * 64, "frames": frames, "frame_time": 1.0 / 120.0}
    rig_entry = {"unit_m": 0.01, "up": "y", "leg_length_m": 0.82, "floor_m": 0.01}
    return dict(json.loads(encode_json(labelled(frames), source=source, rig=rig_entry, detector={"method": "auto"})))


def report_document(frames: int, **more: Any) -> dict[str, Any]:
    plants = [
        {
            "id": 0, "effector": effector.name, "start": contact.start, "end": contact.end,
            "held": [[contact.start, contact.end]],
            "slide_before_mm": 30.0 + 5.0 * k + e, "slide_after_mm": 0.5 * k + 0.125 * e, "penetration_after_mm": 0.25,
            "residual_mm": 1.0 * k, "outcome": "partly" if k else "pinned",
            "reason": f"stays up to {k} mm away" if k else "",
        }
        for e, effector in enumerate(labelled(frames).effectors)
        for k, contact in enumerate(effector.contacts)
    ]  # fmt: skip
    plants = [{**plant, "id": k} for k, plant in enumerate(plants)]
    return {
        "format": "footfix-report", "version": 1, "source": {"file": HOSTILE[1]}, "output": HOSTILE[4],
        "status": "cleaned", "method": "ik",
        "rig": {"root": HOSTILE[2], "floor_m": 0.012, "origins": {"floor": HOSTILE[0]}},
        "settings": {"detect": {"method": "auto"}},
        "before": {"slide_median_mm": 40.0, "penetration_mm": 12.0, "jitter_100m_s3": 0.5, "coverage": 0.4},
        "after": {"slide_median_mm": 1.0, "penetration_mm": 0.2, "jitter_100m_s3": 0.9, "coverage": 0.4},
        "plants": plants,
        "correction": {"root_path_drift_m": 0.012, "max_root_shift_mm": 17.0, "max_joint_rotation_deg": 11.0,
                       "largest_change_joint": HOSTILE[1], "largest_change_deg": 11.0, "largest_change_frame": 75},
        "notes": [
            {"id": "x", "severity": "warning", "text": HOSTILE[3], "joints": list(HOSTILE), "start": 3, "end": 9},
            {"id": "y", "severity": "note", "text": "a plain note", "line": 12},
        ],
        "seconds": {"clip": frames / 120.0},
        **more,
    }  # fmt: skip


def motion(frames: int) -> Motion:
    clip = walker(frames)
    return film(clip, corrected(clip), rig(), labelled(frames))
