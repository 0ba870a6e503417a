"""How large a clip's figure is, and which way is up: the two things a BVH file does not say."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from footfix.errors import UsageError
from footfix.motion.clip import Clip, Floats
from footfix.motion.leadin import motion_proper
from footfix.notes import Note
from footfix.rig.find import legs_of, no_legs
from footfix.rig.limbs import Pair
from footfix.rig.params import RigParams
from footfix.rig.sample import Sample, sample

AXES = ("y", "z", "-y", "-z", "x", "-x")  # likelier first

# (name, metres per unit, leg lengths [m] that make it likely), in the order of preference.
_UNITS = (
    ("metres", 1.0, 0.35, 1.3),
    ("inches", 0.0254, 0.70, 1.0),
    ("centimetres", 0.01, 0.35, 1.3),
    ("millimetres", 0.001, 0.35, 1.3),
    ("decimetres", 0.1, 0.6, 1.2),
    ("CMU units, 17.7 to the metre", 1.0 / 17.7, 0.78, 1.1),
)
_TYPICAL_LEG = 0.9  # [m]


@dataclass(frozen=True)
class Survey:
    """What a clip in file units and axes says about its scale and its up axis.

    Args:
        unit_m: metres per unit of the file.
        up: the file's up axis.
        notes: what is doubtful.
        origins: how each was found.
    """

    unit_m: float
    up: str
    notes: tuple[Note, ...] = ()
    origins: Mapping[str, str] = field(default_factory=dict)


def survey(clip: Clip, params: RigParams | None = None) -> Survey:
    """Finds metres per unit and the up axis of a clip.

    Args:
        clip: in the units and axes of its file.
        params: what is known beforehand.

    Raises:
        NoLegsError: without legs there is nothing to measure by, and nothing to clean.
    """
    params = params or RigParams()
    if params.up is not None and params.up not in AXES:
        raise UsageError(f"rig.up must be one of {', '.join(AXES)}, not {params.up!r}")
    seen = sample(clip, motion_proper(clip))
    roots = np.flatnonzero(clip.skeleton.parents < 0).tolist()
    pair = next((found for found in (legs_of(seen, root) for root in roots) if found is not None), None)
    if pair is None:
        raise no_legs(clip)
    unit, unit_notes, unit_origin = _unit(pair.length)
    up, up_notes = _up(seen, pair)
    return Survey(
        unit_m=params.unit_m or unit,
        up=params.up or up,
        notes=(() if params.unit_m else unit_notes) + (() if params.up else up_notes),
        origins={"unit_m": "config" if params.unit_m else unit_origin, "up": "config" if params.up else "motion"},
    )


def _unit(leg: float) -> tuple[float, tuple[Note, ...], str]:
    for name, unit, least, most in _UNITS:
        if least <= leg * unit <= most:
            return unit, (), f"leg length {leg:.4g} taken as {name}"
    unit = _TYPICAL_LEG / leg
    note = Note(
        "unit-unknown",
        f"a leg of {leg:.4g} fits no usual unit; it is taken to be {_TYPICAL_LEG} m long; set rig.unit_m if you know better",
    )
    return unit, (note,), f"leg length {leg:.4g} scaled to {_TYPICAL_LEG} m"


def _up(seen: Sample, pair: Pair) -> tuple[str, tuple[Note, ...]]:
    ankles = np.mean([seen.places[:, limb.ankle] for limb in pair.limbs], axis=0)
    hips = np.mean([seen.places[:, limb.hip] for limb in pair.limbs], axis=0)
    body = (hips - ankles) / pair.length + 0.5 * _unit_vectors(seen.places.mean(axis=1) - hips)
    lean = body.mean(axis=0)
    scores = {
        axis: float(lean @ vector(axis)) + 0.6 * _steady(seen, axis, pair.length) - 0.02 * AXES.index(axis)
        for axis in AXES
    }
    best = max(AXES, key=lambda axis: scores[axis])
    second = max((axis for axis in AXES if axis != best), key=lambda axis: scores[axis])
    if scores[best] - scores[second] < 0.2:
        return best, (
            Note(
                "up-ambiguous",
                f"up is taken to be {best}; {second} is nearly as likely; set rig.up if it is",
                "warning",
            ),
        )
    return best, ()


def vector(axis: str) -> Floats:
    """The unit vector (3,) of an axis, "-z" for instance."""
    unit = np.zeros(3)
    unit["xyz".index(axis[-1])] = -1.0 if axis.startswith("-") else 1.0
    return unit


def _unit_vectors(vectors: Floats) -> Floats:
    return np.asarray(vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-12))


def _steady(seen: Sample, axis: str, leg: float) -> float:
    """How steadily the lowest point of the body returns to one height, 0 to 1, if this axis is up."""
    lowest = (seen.places @ vector(axis)).min(axis=1)
    low, high = np.quantile(lowest, [0.1, 0.9])
    return float(np.exp(-(high - low) / (0.15 * leg)))
