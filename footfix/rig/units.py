"""Find the unit and the up axis of a clip, which a BVH file does not give."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from footfix.errors import UsageError
from footfix.motion.clip import Clip, Floats
from footfix.motion.lead_in import motion_range
from footfix.notes import Note
from footfix.rig.frame_sample import Sample, sample
from footfix.rig.leg_assignment import Figure, figures
from footfix.rig.params import RigParams

AXES = ("y", "z", "-y", "-z", "x", "-x")  # likelier first

# (name, metres per unit, leg lengths [m] that make it likely), in the order of preference.
_UNITS = (
    ("metres", 1.0, 0.35, 1.3),
    ("inches", 0.0254, 0.70, 1.0),
    ("centimetres", 0.01, 0.35, 1.3),
    ("millimetres", 0.001, 0.35, 1.3),
    ("decimetres", 0.1, 0.6, 1.2),
    ("CMU units, 17.7 to the metre", 1.0 / 17.7, 0.7, 1.12),
    ("metres, of a small figure", 1.0, 0.12, 0.35),
)
_MISTAKEN = (0.0254, 0.01, 0.001)  # units in which files that ought to be in metres are written
_TYPICAL_LEG = 0.9  # [m]
_GROWN_UP = (0.7, 1.05)  # [m] length of most adults' legs
_CLEAR = 0.25  # least lead in evidence of the chosen up axis
_AS_AT_REST = 0.6  # least lead over the one of y and z along which the figure stands at rest,
_STANDS = 0.8  # its hips at least so high over its ankles [leg lengths]


@dataclass(frozen=True)
class FileUnits:
    """The unit and the up axis found for a clip.

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


def infer_units(
    clip: Clip, params: RigParams | None = None, frame_range: slice | None = None, *, metric: bool = False
) -> FileUnits:  # fmt: skip
    """Find metres per unit and the up axis of a clip.

    Args:
        clip: in the units and axes of its file.
        params: what is known beforehand.
        frame_range: the frames that are motion; found where they are not given.
        metric: whether the file's format requires metres, y up. Then another unit is chosen only where the figure is
            as large as it would be in centimetres, millimetres or inches.

    Raises:
        NoLegsError: the clip has no legs to measure by.
    """
    params = params or RigParams()
    if params.up is not None and params.up not in AXES:
        raise UsageError(f"rig.up must be one of {', '.join(AXES)}, not {params.up!r}")
    seen = sample(clip, motion_range(clip) if frame_range is None else frame_range)
    figure = figures(seen, params, y_up=False)[0]
    unit, unit_notes, unit_origin = _unit(figure.length)
    if metric and unit not in _MISTAKEN:
        unit, unit_notes, unit_origin = 1.0, (), "the file's format"
    up, up_notes = ("y", ()) if metric else _up(seen, figure)
    up_origin = "config" if params.up else "the file's format" if metric else "motion"
    return FileUnits(
        unit_m=params.unit_m or unit,
        up=params.up or up,
        notes=(() if params.unit_m else unit_notes) + (() if params.up else up_notes),
        origins={"unit_m": "config" if params.unit_m else unit_origin, "up": up_origin},
    )


def _unit(leg: float) -> tuple[float, tuple[Note, ...], str]:
    for name, unit, least, most in _UNITS:
        if least <= leg * unit <= most:
            return unit, _other_units(leg, name), f"leg length {leg:.4g} taken as {name}"
    unit = _TYPICAL_LEG / leg
    note = Note(
        "unit-unknown",
        f"a leg of {leg:.4g} fits no usual unit; taken to be {_TYPICAL_LEG} m long; set rig.unit_m if you know better",
    )
    return unit, (note,), f"leg length {leg:.4g} scaled to {_TYPICAL_LEG} m"


def _other_units(leg: float, chosen: str) -> tuple[Note, ...]:
    """Make a note on another unit that would give the figure the size of an adult, where the chosen one does not."""
    sizes = {name: leg * unit for name, unit, _, _ in _UNITS}
    usual = [name for name, size in sizes.items() if _GROWN_UP[0] <= size <= _GROWN_UP[1]]
    if not usual or chosen in usual:
        return ()
    other = f"in {usual[0]} it would be {sizes[usual[0]]:.2f} m"
    text = f"a leg of {leg:.4g} is taken as {chosen}, {sizes[chosen]:.2f} m; {other}"
    return (Note("unit-ambiguous", text),)


def _up(seen: Sample, figure: Figure) -> tuple[str, tuple[Note, ...]]:
    """Find the likeliest axis; where the motion hardly tells, as of somebody crawling, that of the rest pose."""
    by_axis = {axis: sum(evidence.values()) for axis, evidence in scores(seen, figure).items()}
    best, second = sorted(AXES, key=lambda axis: -by_axis[axis])[:2]
    rest = next((axis for axis in ("y", "z") if _at_rest(seen, figure) @ vector(axis) > _STANDS), best)
    if by_axis[best] - by_axis[rest] < _AS_AT_REST and rest != best:
        best, second = rest, best
    if by_axis[best] - by_axis[second] < _CLEAR:
        text = f"up is taken to be {best}; {second} is nearly as likely; set rig.up if it is"
        return best, (Note("up-ambiguous", text, "warning"),)
    return best, ()


def scores(seen: Sample, figure: Figure) -> dict[str, dict[str, float]]:
    """Score the evidence for each axis being up: axis -> kind of evidence -> score.

    An upright trunk scores 1.5 for one axis and almost nothing for the others, which decides. Where the figure lies,
    crawls or turns cartwheels, other evidence must outweigh a trunk along the wrong axis: the lowest joint keeps one
    height, that height is zero, much of the body is near it, and the figure does not travel far upwards.
    """
    ankles = np.mean([seen.places[:, limb.ankle] for limb in figure.limbs], axis=0)
    hips = np.mean([seen.places[:, limb.hip] for limb in figure.limbs], axis=0)
    lean = ((hips - ankles) / figure.length + 0.5 * _unit_vectors(_trunk(seen, figure) - hips)).mean(axis=0)
    rest = _at_rest(seen, figure)
    evidence = {}
    for axis in AXES:
        up = vector(axis)
        heights = seen.places @ up
        ground = _ground(heights, figure.length)
        thick = float(np.quantile(np.ptp(heights, axis=1), 0.9)) > 0.08 * figure.length  # else a flat figure
        steady = _steady(heights, figure.length)
        at_zero = float(np.exp(-(((ground / figure.length - 0.03) / 0.08) ** 2)))
        evidence[axis] = {
            "lean": float(lean @ up),
            "steady": 0.6 * thick * steady,
            "zero": (0.2 + 0.6 * steady) * thick * at_zero,
            "lying": 0.6 * thick * _lying(heights, ground, figure.length),
            "travel": -0.5 * float(np.clip(np.ptp(hips @ up) / figure.length - 1.5, 0.0, 1.0)),
            "rest": 0.3 * float(rest @ up),
            "usual": 0.03 * (len(AXES) - AXES.index(axis)),
        }
    return evidence


def _trunk(seen: Sample, figure: Figure) -> Floats:
    """Compute the middle of all joints except the legs, (S, 3)."""
    legs = {joint for limb in figure.limbs for joint in seen.below(limb.branch)}
    others = [joint for joint in range(len(seen.skeleton)) if joint not in legs]
    return np.asarray(seen.places[:, others].mean(axis=1))


def _at_rest(seen: Sample, figure: Figure) -> Floats:
    """Compute the vector (3,) from ankles to hips in the rest pose, in leg lengths."""
    bones = seen.skeleton.offsets
    spans = [-np.sum([bones[joint] for joint in limb.chain[1:]], axis=0) for limb in figure.limbs]
    return np.asarray(np.nan_to_num(np.mean(spans, axis=0)) / figure.length)


def _ground(heights: Floats, leg: float) -> float:
    """Find the height to which the lowest joint comes back most often."""
    lowest = np.sort(heights.min(axis=1))
    band = 0.05 * leg
    count = np.searchsorted(lowest, lowest + band, side="right") - np.arange(len(lowest))
    first = int(np.argmax(count))
    return float(np.median(lowest[first : first + int(count[first])]))


def _steady(heights: Floats, leg: float) -> float:
    """Measure how steadily the lowest joint stays at one height, 0 to 1."""
    low, high = np.quantile(heights.min(axis=1), [0.1, 0.9])
    return float(np.exp(-(high - low) / (0.15 * leg)))


def _lying(heights: Floats, ground: float, leg: float) -> float:
    """Measure how much of the body is down on the ground, 0 to 1: all of it where somebody lies."""
    return float((np.abs(heights - ground) < 0.2 * leg).mean())


def vector(axis: str) -> Floats:
    """Make the unit vector (3,) of an axis, "-z" for instance."""
    unit = np.zeros(3)
    unit["xyz".index(axis[-1])] = -1.0 if axis.startswith("-") else 1.0
    return unit


def _unit_vectors(vectors: Floats) -> Floats:
    return np.asarray(vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-12))
