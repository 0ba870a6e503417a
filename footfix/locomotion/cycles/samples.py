"""Normalised cycles of captured walks and runs: straight, closed, of equal duration and size.

Source: P. Glardon, R. Boulic, D. Thalmann, Robust on-line adaptive footplant detection and enforcement for
locomotion, The Visual Computer 22 (2006), section 3: cycles without travel, in normalised time, of which phase 0 is the
right heel strike.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from footfix.locomotion.loop.closing import close
from footfix.locomotion.loop.cut_search import Cut
from footfix.locomotion.loop.params import LoopParams
from footfix.locomotion.loop.point_cloud import clouds, distances, fit
from footfix.locomotion.loop.root_motion import Travel, root_in_world, straightened, with_root
from footfix.locomotion.loop.strides import Stride, find_strides, stances
from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats
from footfix.motion.contacts import Contacts
from footfix.rig.rig import Rig

GRAVITY = 9.81  # [m/s^2]
PHASES = 32  # samples of a cycle: harmonics up to the 15th

Gait = Literal["walk", "run"]


@dataclass(frozen=True, kw_only=True)
class SampleParams:
    """Which strides count as cycles of a straight, steady gait.

    Args:
        turn: greatest turn of the figure in a cycle [rad].
        unsteady: greatest ratio of the durations of the two halves of a cycle [factor].
        apart: greatest difference of the poses at its ends, root mean square over the joints [leg lengths].
        slowest: least speed, as v / sqrt(g l) [1].
        askew: greatest angle between facing and travel [rad].
        lopsided: how far from the middle of the cycle the left foot may strike, as a share of the cycle [share].
    """

    turn: float = 0.3
    unsteady: float = 1.35
    apart: float = 0.15
    slowest: float = 0.08
    askew: float = 0.6
    lopsided: float = 0.1


@dataclass(frozen=True, eq=False)
class Sample:
    """One captured cycle, sampled at even phases from a right strike on.

    Args:
        places: (N, 3) [leg lengths] of the root: to the left of the line it goes along, over the floor, and ahead of
            where its mean speed has it.
        turns: (N, J, 4) xyzw: of the root to the direction of travel, of each other joint in its parent's frame.
        speed: v / sqrt(g l).
        frequency: [cycles] in the time sqrt(l / g).
        contacts: (E, 2) phases at which each effector is set down and lifted; NaN where it never is.
        duty: share of the cycle in which a foot stands, mean of both.
        source: the file.
        start, end: its frames there.
        style: name of the style.
    """

    places: Floats
    turns: Floats
    speed: float
    frequency: float
    contacts: Floats
    duty: float
    source: str = ""
    start: int = 0
    end: int = 0
    style: str = ""

    @property
    def gait(self) -> Gait:
        """Tell walk from run: a run has a flight, so each foot stands for less than half of the cycle."""
        return "run" if self.duty < 0.5 else "walk"


@dataclass(frozen=True)
class Sampled:
    """The cycles of a clip.

    Args:
        samples: the usable ones.
        left_out: reason -> number of strides left out.
    """

    samples: tuple[Sample, ...]
    left_out: Mapping[str, int] = field(default_factory=dict)


def sample_cycles(clip: Clip, rig: Rig, contacts: Contacts, ground: Floats, params: SampleParams) -> Sampled:
    """Extract the cycles of a clip, from each strike of a foot to its next, for the foot with more of them.

    Args:
        clip: F frames, metres, y up.
        rig: its two legs.
        contacts: when each sole point is planted; the effectors in the order of `rig.soles`.
        ground: (F, 3) [m] how far the ground under planted feet has moved, as on a treadmill.
        params: which strides are usable.
    """
    sides = [leg.side for leg in rig.legs]
    if sorted(sides) != ["left", "right"]:
        return Sampled((), {"not a figure with a left and a right leg": 1})
    if np.any(ground):
        place, turn = root_in_world(clip, rig.root)
        clip = with_root(clip, rig.root, place - ground, turn)
    strides = find_strides(contacts, rig)
    taken = [_of_foot(clip, rig, contacts, strides[sides.index(side)], params) for side in ("right", "left")]
    return max(taken, key=lambda each: len(each.samples))


def _of_foot(clip: Clip, rig: Rig, contacts: Contacts, strides: Sequence[Stride], params: SampleParams) -> Sampled:
    reasons: Counter[str] = Counter()
    found = []
    for stride in strides:
        taken = _taken(clip, rig, contacts, stride, params)
        if isinstance(taken, str):
            reasons[taken] += 1
        else:
            found.append(replace(taken, start=stride.first[0], end=stride.second[0]))
    return Sampled(tuple(found), dict(reasons))


def _taken(clip: Clip, rig: Rig, contacts: Contacts, stride: Stride, params: SampleParams) -> Sample | str:
    """Make the cycle of a stride, or say why it is not usable."""
    start, end = stride.first[0], stride.second[0]
    if start == 0 or end - start < 8:
        return "it begins before the clip does"
    length = end - start
    loop = LoopParams()
    travel = fit(clip, rig, start, end, loop.window)
    if abs(travel.yaw) > params.turn:
        return "it turns"
    ends = clouds(clip, rig, np.array([start, end]), loop.window)
    if distances(ends, ends)[0, 1] > params.apart * rig.leg_length:
        return "it ends in another pose than it begins in"
    place = root_in_world(clip, rig.root)[0][[start, (start + end) // 2, end]][:, [0, 2]]
    halves = np.linalg.norm(np.diff(place, axis=0), axis=1) + 1e-9
    distance = float(halves.sum())
    froude = float(np.sqrt(GRAVITY * rig.leg_length))
    if distance / (length * clip.frame_time) < params.slowest * froude:
        return "it does not get ahead"
    if halves.max() > params.unsteady * halves.min():
        return "its speed changes"
    phases = _contact_phases(contacts, rig, stride.leg, start, length)
    if phases is None:
        return "a foot's contacts in it are not all known"
    on, duty, other = phases
    if abs(other - 0.5) > params.lopsided:
        return "the other foot does not strike in its middle"
    closed = close(clip, rig, Cut(start, end, -1, 1, 0, 0.0), loop)
    cycle, way = straightened(closed.clip, rig.root, closed.travel)
    sample = _normalised(cycle, rig, way, on, duty, length * clip.frame_time, params)
    if isinstance(sample, str) or rig.legs[stride.leg].side == "right":
        return sample
    return shifted(sample, other)


def _contact_phases(
    contacts: Contacts, rig: Rig, first: int, start: int, length: int
) -> tuple[Floats, float, float] | None:
    """Find the phases of each effector's contact (E, 2), the duty factor, and when the other foot strikes.

    The foot that strikes first stands from the start of the cycle on, the other one from within it. None where the
    clip ends in one of these stances.
    """
    phases = np.full((len(rig.soles), 2), np.nan)
    duties, strikes = [], []
    for number in (first, 1 - first):
        low, high = (-0.25, 0.25) if number == first else (0.2, 0.8)
        own = [s for s in stances(contacts, rig, number) if low <= (s[0] - start) / length < high]
        if len(own) != 1 or own[0][1] >= contacts.frames:
            return None
        a, b = own[0]
        duties.append((b - a) / length)
        strikes.append((a - start) / length)
        for k, sole in enumerate(rig.soles):
            if sole.leg == number:
                parts = [c for c in contacts.effectors[k].contacts if c.wish != "forbid" and c.start < b and c.end > a]
                if parts:
                    phases[k] = [(parts[0].start - start) / length, (parts[-1].end - start) / length]
    return phases, float(np.mean(duties)), strikes[1]


def shifted(sample: Sample, phase: float) -> Sample:
    """Start a cycle at another phase, interpolating poses by their harmonics."""
    middle = mean_turns(sample.turns)
    vectors = rotation.to_rotation_vector(rotation.multiply(rotation.inverse(middle), sample.turns))
    moved = shift_phases(vectors, phase)
    return replace(
        sample,
        places=shift_phases(sample.places, phase),
        turns=rotation.multiply(middle, rotation.from_rotation_vector(moved)),
        contacts=_within(sample.contacts - phase),
    )


def _within(spans: Floats) -> Floats:
    """Shift the phases (E, 2) of each foot's contacts by whole cycles, so that it lands from phase -0.25 to 0.75."""
    pairs = spans.reshape(-1, 2, 2)  # heel and toe of each leg
    first = np.nanmin(np.where(np.isfinite(pairs[..., 0]), pairs[..., 0], np.inf), axis=1)
    return np.asarray((pairs - np.floor(first + 0.25)[:, None, None]).reshape(-1, 2))


def shift_phases(values: Floats, phase: float) -> Floats:
    """Begin periodic samples (N, ...) at another phase."""
    spectrum = np.fft.rfft(values, axis=0)
    turn = np.exp(2j * np.pi * phase * np.arange(len(spectrum)))
    return np.fft.irfft(spectrum * turn.reshape(-1, *[1] * (values.ndim - 1)), n=len(values), axis=0)


def _normalised(
    cycle: Clip, rig: Rig, travel: Travel, contacts: Floats, duty: float, seconds: float, params: SampleParams
) -> Sample | str:
    """Make a sample of a closed, straight cycle."""
    place, turn = root_in_world(cycle, rig.root)
    distance = float(np.hypot(travel.x, travel.z))
    back = rotation.about_vertical(-np.arctan2(travel.x, travel.z))
    place = rotation.rotate(back, place - np.linspace(0.0, 1.0, len(cycle))[:, None] * travel.shift)[:-1]
    turn = rotation.multiply(back, turn)[:-1]
    place = place - [place[:, 0].mean(), rig.floor, place[:, 2].mean()]
    joints = len(cycle.skeleton)
    turns = np.stack([turn if j == rig.root else cycle.rotation(j)[:-1] for j in range(joints)], axis=1)
    if abs(_facing(cycle, rig, back)) > params.askew:
        return "it goes sideways or backwards"
    leg = rig.leg_length
    return Sample(
        places=_at_even_phases(place) / leg,
        turns=_resampled(turns),
        speed=distance / seconds / float(np.sqrt(GRAVITY * leg)),
        frequency=float(np.sqrt(leg / GRAVITY)) / seconds,
        contacts=contacts,
        duty=duty,
    )


def _facing(cycle: Clip, rig: Rig, back: Floats) -> float:
    """Compute the mean angle from the direction of travel to where the hips face [rad]."""
    pose = rig.pose(cycle)
    by = {leg.side: pose.position(leg.hip) for leg in rig.legs}
    across = rotation.rotate(back, by["left"] - by["right"]).mean(axis=0)
    return float(np.arctan2(-across[2], across[0]))


def _resampled(turns: Floats) -> Floats:
    """Resample rotations (L, J, 4) of one round at even phases, (N, J, 4), by their harmonics."""
    middle = mean_turns(turns)
    vectors = rotation.to_rotation_vector(rotation.multiply(rotation.inverse(middle), turns))
    return rotation.multiply(middle, rotation.from_rotation_vector(_at_even_phases(vectors)))


def _at_even_phases(values: Floats) -> Floats:
    """Resample values (L, ...) of one round at even phases, (N, ...), by the harmonics that N samples can hold.

    The highest one that the shorter of both can hold is a cosine alone. (scipy.signal does the same, but loading it
    takes longer than all the rest of this package.)
    """
    shorter = min(len(values), PHASES)
    harmonics = np.fft.rfft(values, axis=0)[: shorter // 2 + 1]
    if shorter % 2 == 0 and len(values) != PHASES:
        harmonics[-1] = (2.0 if len(values) > PHASES else 0.5) * harmonics[-1].real
    return np.fft.irfft(harmonics, PHASES, axis=0) * (PHASES / len(values))


def mean_turns(turns: Floats) -> Floats:
    """Average rotations (L, J, 4) to (J, 4): the eigenvector of sum q q^T with the largest eigenvalue."""
    _, vectors = np.linalg.eigh(np.einsum("lja,ljb->jab", turns, turns))
    return np.ascontiguousarray(vectors[..., -1])
