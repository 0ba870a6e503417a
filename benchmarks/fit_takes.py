"""Takes to fit to: recordings whose contacts force plates measured, and made walkers whose contacts are known.

Every take is sampled at one high rate, in leg lengths, with the states that each foot may be in at each moment:
a plate knows that a foot stands, not which part of it, so heel and toe are then told by how high they are over
where they rest in that very stance, and left open where that is not clear.
"""

from __future__ import annotations

import json
import sys
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "sample_data"))

import walker
import walker_plan

from footfix.detect.evidence import catmull_rom
from footfix.detect.network import FLAT, HEEL, SWING, TOE
from footfix.detect.threshold import ThresholdParams, threshold
from footfix.detect.tracks import Tracks, tracks_of
from footfix.formats.bvh import decode
from footfix.measure import agreement
from footfix.motion.clip import Bools, Clip, Floats, Skeleton
from footfix.motion.contacts import runs
from footfix.motion.kinematics import forward
from footfix.motion.smoothing import savgol
from footfix.rig.find import find_rig
from footfix.rig.units import infer_units

RATE = 300.0  # [Hz]
POINTS = ("pelvis", "hip", "ankle", "heel", "toe")
CALM = ("stand", "squat", "sit")  # kinds of motion in which the figure goes nowhere
SWIFT = ("run", "jump", "sprint")  # kinds of which few were recorded
PUSH = 0.012  # [s] for which in these the toes may still push when the ball of a walker, which has none, is up


@dataclass(frozen=True, eq=False)
class Take:
    """One take of a biped.

    Args:
        name, subject, kind: which, whose and what.
        pelvis: (N, 3) [leg lengths].
        hip, ankle, heel, toe: (N, 2, 3) [leg lengths].
        allowed: (N, 2, 4) states that each foot may be in.
        stands: (N, 2) whether it stands, as far as anybody knows; where the plates are silent a detector says.
        fps: rate of the recording.
    """

    name: str
    subject: str
    kind: str
    pelvis: Floats
    hip: Floats
    ankle: Floats
    heel: Floats
    toe: Floats
    allowed: Bools
    stands: Bools
    fps: float

    def moved(self, change: Floats) -> Take:
        """With a displacement (N, 3) added to every point."""
        parts = {p: getattr(self, p) + (change if p == "pelvis" else change[:, None]) for p in POINTS}
        return replace(self, **parts)

    @property
    def calm(self) -> bool:
        return any(word in self.kind for word in CALM)

    @property
    def swift(self) -> bool:
        return any(word in self.kind for word in SWIFT)


def load_clip(path: Path) -> Clip:
    """A BVH file in metres, y up."""
    document = decode(path.read_bytes())
    seen = infer_units(document.clip)
    return document.placed(unit_m=seen.unit_m, up=seen.up).clip


def recorded(folder: Path, *, toes: bool = True) -> list[Take]:
    """The takes of a truth folder: `NAME.bvh` with `NAME.truth.json`.

    Args:
        folder: where they are.
        toes: False takes the toe joints away before anything is looked at.
    """
    takes = []
    for path in sorted(folder.glob("*.bvh")):
        truth = json.loads(path.with_suffix(".truth.json").read_text(encoding="utf-8"))
        clip = load_clip(path) if toes else without_toes(load_clip(path))
        tracks = tracks_of(clip, find_rig(clip))
        takes.append(_recorded(path.stem, truth, tracks))
    return takes


def without_toes(clip: Clip) -> Clip:
    """The clip without the joints that are called toes, and what hangs from them."""
    skeleton = clip.skeleton
    kept = [j for j, name in enumerate(skeleton.names) if "toe" not in name.lower()]
    new = {old: k for k, old in enumerate(kept)}
    ends = [e for e, parent in enumerate(skeleton.end_parents.tolist()) if parent in new]
    return Clip(
        Skeleton(
            tuple(skeleton.names[j] for j in kept),
            np.array([new.get(int(skeleton.parents[j]), -1) for j in kept]),
            skeleton.offsets[kept],
            np.array([new[int(skeleton.end_parents[e])] for e in ends], dtype=np.intp),
            skeleton.end_offsets[ends],
        ),
        clip.positions[:, kept], clip.rotations[:, kept], clip.frame_time,
    )  # fmt: skip


def _recorded(name: str, truth: dict[str, Any], tracks: Tracks) -> Take:
    def fine(x: Floats) -> Floats:
        return catmull_rom(x, 1.0 / (RATE * tracks.frame_time)) / tracks.leg_length

    points = {p: np.stack([fine(getattr(foot, p)) for foot in tracks.feet], axis=1) for p in POINTS[1:]}
    pelvis = fine(tracks.pelvis)
    allowed = np.stack(
        [
            _allowed(truth[side], truth["fps"], truth["frames"], points["heel"][:, k, 1], points["toe"][:, k, 1])
            for k, side in enumerate(("left", "right"))
        ],
        axis=1,
    )
    at = np.round(np.arange(len(pelvis)) / RATE / tracks.frame_time).astype(np.intp)
    guess = agreement.feet(threshold(tracks, ThresholdParams()).mask)[np.minimum(at, len(tracks) - 1)]
    known = ~allowed.all(axis=2)
    stands = np.where(known, ~allowed[:, :, SWING], guess)
    return Take(
        name, truth["subject"], truth["activity"], pelvis,
        allowed=allowed, stands=stands, fps=float(truth["fps"]), **points,
    )  # fmt: skip


def _allowed(side: dict[str, Any], fps: float, frames: int, heel: Floats, toe: Floats) -> Bools:
    """(N, 4) of one foot."""
    known = np.zeros(frames, dtype=np.bool_)
    for a, b in side["known"]:
        known[a:b] = True
    times = np.arange(len(heel)) / RATE
    told = known[np.minimum(np.round(times * fps).astype(np.intp), frames - 1)]
    stands = np.zeros(len(heel), dtype=np.bool_)
    allowed = np.ones((len(heel), 4), dtype=np.bool_)
    for a, b in side["contact"]:
        start = _event(a, known, fps, side["strike_s"])
        end = _event(b, known, fps, side["off_s"])
        stance = (times >= start) & (times < end)
        stands |= stance
        at = np.flatnonzero(stance & told)
        if len(at) > 2:
            allowed[at] = parts(heel[at], toe[at])
    allowed[told & ~stands] = [True, False, False, False]
    return allowed


def _event(frame: int, known: Bools, fps: float, events: list[float]) -> float:
    """[s] when a contact starts or ends: the crossing of the force if there is one, else between the frames."""
    if not (0 < frame < len(known)) or not (known[frame - 1] and known[frame]):
        return frame / fps
    near = [time for time in events if abs(time * fps - (frame - 0.5)) < 1.0]
    return float(near[0]) if near else (frame - 0.5) / fps


def parts(heel: Floats, toe: Floats) -> Bools:
    """(n, 4) which parts of the foot may stand, over one stance, from the heights of heel and toe [leg lengths]."""
    allowed = np.tile([False, True, True, True], (len(heel), 1))
    heel_rests, toe_rests = np.quantile(heel, 0.2), np.quantile(toe, 0.2)
    flat = (heel < heel_rests + 0.012) & (toe < toe_rests + 0.012)
    if flat.mean() <= 0.05:
        return allowed  # a stance in which the foot never lies flat says nothing about its parts
    heel_rise = savgol(heel, 1.0 / RATE, seconds=0.06, degree=2, derivative=1)  # [leg lengths/s]
    toe_rise = savgol(toe, 1.0 / RATE, seconds=0.06, degree=2, derivative=1)
    heel_down = (heel < heel_rests + 0.004) & (np.abs(heel_rise) < 0.05)
    heel_up = (heel > heel_rests + 0.02) | ((heel > heel_rests + 0.01) & (heel_rise > 0.15))
    early = np.arange(len(toe)) < np.argmax(toe < toe_rests + 0.008)
    toe_down = ((toe < toe_rests + 0.004) & (np.abs(toe_rise) < 0.05)) | (~early & heel_up)
    toe_up = early & (toe > toe_rests + 0.016) & (heel < heel_rests + 0.014)
    heel_up &= ~early
    allowed[heel_up, HEEL] = allowed[heel_up, FLAT] = False
    allowed[heel_down, TOE] = False
    allowed[toe_down, HEEL] = False
    allowed[toe_up, FLAT] = allowed[toe_up, TOE] = False
    allowed[~allowed.any(axis=1), HEEL:] = True
    return allowed


def made(count: int, seed: int, *, spread: float = 1.0) -> list[Take]:
    """Walkers of all gaits by turns, each in a style of its own.

    Args:
        count: how many.
        seed: of the styles.
        spread: how far the styles may be from the usual one.
    """
    random = np.random.default_rng(seed)
    usual = dict(walker_plan.STYLES)
    names = sorted(usual)
    takes = []
    for k in range(count):
        name = names[k % len(names)]
        for attempt in range(8):  # some styles ask more of a leg than it can reach
            walker_plan.STYLES[name] = _style(usual[name], random, spread * (1.0 - attempt / 8))
            try:
                takes.append(_made(f"{name} {k}", walker.make(_gait(name, usual[name].speed, random))))
                break
            except ValueError:
                continue
        walker_plan.STYLES[name] = usual[name]
    return takes


def _gait(name: str, speed: float, random: np.random.Generator) -> walker_plan.Gait:
    usual = random.random() < 0.3 or not speed
    return walker_plan.Gait(
        name=name,  # type: ignore[arg-type]
        speed=None if usual else abs(speed) * float(np.exp(random.uniform(-0.35, 0.3))),
        duration=random.uniform(2.5, 5.0), fps=RATE, leg=random.uniform(0.6, 1.0),
        seed=int(random.integers(1_000_000)), variation=random.uniform(0.3, 2.0), turn=random.uniform(-3.0, 3.0),
        rest=(0.6 * random.integers(2), 0.6 * random.integers(2)), soft=bool(random.random() < 0.15),
    )  # fmt: skip


_FACTOR = {
    "strike_rate": 0.3, "flat_at": 0.25, "off_pitch": 0.15, "off_rate": 0.2, "hump": 0.35, "clearance": 0.35,
    "touchdown": 0.4, "brake": 0.4, "push": 0.4, "sway": 0.3, "flight": 0.3, "twist": 0.4, "mid_pitch": 0.2,
}  # fmt: skip
_SHIFT = {"duty": 0.025, "over": 0.03, "strike_pitch": 0.1, "lift_at": 0.07, "half_width": 0.02, "tilt": 0.03}
_WITHIN = {"duty": (0.15, 0.85), "over": (0.3, 0.6), "flat_at": (0.06, 0.4), "lift_at": (0.46, 0.85)}


def _style(usual: walker_plan.Style, random: np.random.Generator, spread: float) -> walker_plan.Style:
    style: dict[str, Any] = {}
    for name, deviation in _FACTOR.items():
        value = np.asarray(getattr(usual, name)) * np.exp(random.normal(0.0, deviation * spread))
        style[name] = tuple(value.tolist()) if value.ndim else float(value)
    for name, deviation in _SHIFT.items():
        style[name] = float(getattr(usual, name) + random.normal(0.0, deviation * spread))
    for name, (low, high) in _WITHIN.items():
        style[name] = float(np.clip(style[name], low, high))
    return replace(usual, **style)


def _made(name: str, walk: walker.Walk) -> Take:
    pose, names = forward(walk.clip), list(walk.clip.skeleton.names)
    leg = walk.gait.leg

    def both(joint: str) -> Floats:
        tracks = [pose.position(names.index(side + joint)) for side in ("Left", "Right")]
        return np.stack(tracks, axis=1) / leg

    down = walk.contacts.mask()
    state = np.array([[SWING, TOE], [HEEL, FLAT]])[
        down[:, 0::2].astype(np.intp), down[:, 1::2].astype(np.intp)
    ]  # (N, 2)
    allowed: NDArray[np.bool_] = state[:, :, None] == np.arange(4)
    if any(word in name for word in SWIFT):
        for k in (0, 1):
            for _, off in runs(state[:, k] != SWING):
                allowed[off : off + round(PUSH * RATE), k, TOE] = True
    return Take(
        name, "walker", name.split()[0], pose.position(names.index("Hips")) / leg, both("UpLeg"), both("Foot"),
        np.stack([walk.tracks[0], walk.tracks[2]], axis=1) / leg,
        np.stack([walk.tracks[1], walk.tracks[3]], axis=1) / leg,
        allowed, state != SWING, 100.0,
    )  # fmt: skip
