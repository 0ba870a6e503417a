"""Variants of takes, so that what is fitted to a few people holds for other people, floors, rigs and faults.

What a retargeted, drifting, noisy, in-place, slow or fast clip does to the tracks of a good one is put into the
good one; the contacts stay what they were. Takes are also walked up and down stairs, landed on the forefoot, played
backwards in time, and cut short.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
from fit_takes import POINTS, RATE, Take, parts

from footfix.detect.evidence import STEP, Sampled, catmull_rom, evidence, resample
from footfix.detect.network import HEEL, SWING, TOE
from footfix.detect.tracks import FootTracks, Tracks
from footfix.motion import rotation
from footfix.motion.clip import Bools, Floats
from footfix.motion.contacts import runs
from footfix.motion.smoothing import savgol

Random = np.random.Generator
SHORT = (0.5, 1.5)  # [s] of a short clip
FPS = (24, 25, 30, 50, 60, 100, 120, 150, 200, 300)


def variant(take: Take, random: Random | None) -> tuple[list[tuple[tuple[Floats, ...], Bools]], float]:
    """Evidence of a take, changed at random (as it is where no random is given).

    Returns:
        For each clip that it is cut into the curves of each foot (n, columns) and the allowed states (n, 2, 4);
        and how much the variant counts.
    """
    weight = 0.3 if take.calm else 2.0 if take.swift else 1.0
    rate, fps = RATE, take.fps
    if random is not None:
        take, rate, fps, weight = _changed(take, random, weight)
    sampled, first = as_captured(take, rate, fps, random)
    steps = len(sampled.tracks)
    at = np.round(first + np.arange(steps) * STEP * rate).astype(np.intp)
    allowed = take.allowed[np.minimum(at, len(take.allowed) - 1)]
    return [(evidence(sampled, part), allowed[part]) for part in _cuts(steps, random)], weight


def _cuts(steps: int, random: Random | None) -> list[slice]:
    """Clips that a take is cut into, one in three so short that each holds a stride or two and ends anywhere."""
    if random is None or random.random() < 0.67:
        return [slice(0, steps)]
    edges = np.cumsum([0, *np.round(random.uniform(*SHORT, steps) / STEP)]).astype(np.intp)
    edges = edges[edges < steps - SHORT[0] / STEP]
    return [slice(int(a), int(b)) for a, b in pairwise([*edges, steps])]


def as_captured(take: Take, rate: float, fps: float, random: Random | None) -> tuple[Sampled, int]:
    """What detection samples of a take of some rate [Hz] that a clip holds at some fps, and at which step it starts.

    With random given the clip starts anywhere between two frames, and one in three is noisy.
    """
    every = max(round(rate / fps), 1)
    first = 0 if random is None else int(random.integers(every))
    clip = replace(take, **{p: getattr(take, p)[first::every] for p in POINTS})
    frame_time = every / rate
    if random is not None and random.random() < 0.35:
        clip = _noisy(clip, frame_time, random)
    feet = tuple(FootTracks("", *(getattr(clip, p)[:, k] for p in POINTS[1:])) for k in (0, 1))
    return resample(Tracks(clip.pelvis, feet, 1.0, frame_time)), first


def _changed(take: Take, random: Random, weight: float) -> tuple[Take, float, float, float]:
    """The take with faults, its rate [Hz] once it is quicker or slower, frames a second, and its weight."""

    def now(share: float) -> bool:
        return bool(random.random() < share)

    if now(0.12):
        take, weight = backwards_in_time(take), 0.4 * weight  # landing is not leaving in reverse
    if take.kind == "jump" and now(0.5):
        take = on_one_foot(take, random)
    stairs = now(0.25)
    if now(0.5 if stairs else 0.4 if "run" in take.kind else 0.1) and take.subject != "walker" and not take.calm:
        take = on_forefoot(take, random)
    if stairs:
        take = on_stairs(take, random)
    if now(0.5):
        take = with_wrong_soles(take, random)
    rate = RATE * (float(np.exp(random.uniform(-0.35, 0.35))) if now(0.6) else 1.0)
    if "run" in take.kind and now(0.4):
        rate *= random.uniform(1.0, 1.8)  # towards a sprint
    if take.kind == "jump" and now(0.6):
        rate *= random.uniform(1.0, 2.5)  # towards hopping
    take = take.moved(_shift(take, rate, random))
    fps = float(random.choice(FPS)) if now(0.6) else take.fps
    return take, rate, fps, weight


def _shift(take: Take, rate: float, random: Random) -> Floats:
    """(N, 3) what skating, drifting, floating, tilted and in-place clips add to every point."""
    count, level = len(take.pelvis), np.array([1.0, 0.0, 1.0])
    times = np.arange(count) / rate
    shift = np.zeros((count, 3))
    if random.random() < 0.35:  # the root's way scaled, as by a retarget
        shift += (random.uniform(0.75, 1.25) - 1.0) * take.pelvis * (level if random.random() < 0.5 else 1.0)
    if random.random() < 0.35:
        shift[:, ::2] += random.normal(0.0, 0.08, 2) * times[:, None]
    if random.random() < 0.25:
        shift[:, ::2] += random.uniform(0.0, 0.06) * wander(random, count, rate, random.uniform(0.5, 3.0), 2)
    if random.random() < 0.25:
        shift[:, 1:2] += random.uniform(0.0, 0.05) * wander(random, count, rate, random.uniform(1.0, 4.0), 1)
    if random.random() < 0.15:  # a floor that is not level
        shift[:, 1] += (take.pelvis - take.pelvis[0])[:, ::2] @ random.normal(0.0, 0.05, 2)
    kind = random.random()
    if kind < 0.15 and not take.calm:  # on a treadmill
        speed = (take.pelvis[-1] - take.pelvis[0]) / times[-1] * level
        shift -= speed * times[:, None] * (1.0 if random.random() < 0.5 else random.uniform(0.3, 1.3))
    elif 0.15 <= kind < 0.21:  # in place
        shift -= take.pelvis * level
    elif 0.21 <= kind < 0.23:  # hung up by the pelvis
        shift -= take.pelvis
    return shift


def wander(random: Random, count: int, rate: float, seconds: float, width: int) -> Floats:
    """(count, width) a smooth random curve of deviation about 1 that turns every so many seconds."""
    knots = random.normal(size=(max(int(count / rate / seconds) + 3, 4), width))
    return np.asarray(catmull_rom(knots, (len(knots) - 1 - 1e-6) / max(count - 1, 1))[:count])


def backwards_in_time(take: Take) -> Take:
    """The take played from its end."""
    flipped = {p: getattr(take, p)[::-1] for p in (*POINTS, "allowed", "stands")}
    return replace(take, **flipped)


def on_one_foot(take: Take, random: Random) -> Take:
    """With one foot held up all the time, so that the other one hops."""
    k, count = int(random.integers(2)), len(take.pelvis)
    held: dict[str, Any] = {p: np.array(getattr(take, p)) for p in POINTS[2:]}
    place = np.array([random.normal(0.0, 0.1), -random.uniform(0.5, 0.8), random.normal(-0.15, 0.15)])
    place = place + 0.05 * wander(random, count, RATE, 0.5, 3)
    ankle = take.hip[:, k] + place
    for p in held:
        held[p][:, k] = ankle + (held[p][:, k] - take.ankle[:, k])
    allowed, stands = take.allowed.copy(), take.stands.copy()
    allowed[:, k] = [True, False, False, False]
    stands[:, k] = False
    return replace(replace(take, **held), allowed=allowed, stands=stands)


def with_wrong_soles(take: Take, random: Random) -> Take:
    """With sole points a little off, along the foot and up or down."""
    along = take.toe - take.heel
    along = along / (np.linalg.norm(along, axis=-1, keepdims=True) + 1e-9)
    up = np.cross(np.cross(along, [0.0, 1.0, 0.0]), along)
    up = up / (np.linalg.norm(up, axis=-1, keepdims=True) + 1e-9)
    off = [
        along * random.normal(0.0, 0.025, (1, 2, 1)) + up * random.normal(0.0, deviation, (1, 2, 1))
        for deviation in (0.013, 0.007)
    ]
    return replace(take, heel=take.heel + off[0], toe=take.toe + off[1])


def on_forefoot(take: Take, random: Random) -> Take:
    """With feet that land on the ball, the heel sinking later or not at all, as down stairs and in a sprint."""
    times = np.arange(len(take.pelvis)) / RATE
    # a heel held up less than this may as well be a sole point that was guessed too high
    landing, held = random.uniform(0.2, 0.8), random.uniform(0.12, 0.3) * (random.random() < 0.25)  # [rad]
    before, after = random.uniform(0.1, 0.25), random.uniform(0.06, 0.25)  # [s]
    feet: dict[str, Any] = {p: np.array(getattr(take, p)) for p in ("ankle", "heel", "toe")}
    allowed = take.allowed.copy()
    for k in (0, 1):
        pitch = np.zeros(len(times))
        for a, b in runs(take.stands[:, k]):
            since, until = times - times[a], times[b - 1] - times
            pitch = np.maximum(pitch, landing * _fall(np.abs(since) / np.where(since < 0.0, before, after)))
            pitch = np.maximum(pitch, held * _fall(-np.minimum(since, until) / before))
        turned = _heel_up(feet["ankle"][:, k], feet["heel"][:, k], feet["toe"][:, k], pitch)
        for p, track in turned.items():
            feet[p][:, k] = track
        for a, b in runs(~allowed[:, k, SWING]):
            allowed[a:b, k] = _parts_on_forefoot(take, k, slice(a, b), feet["heel"][a:b, k, 1], feet["toe"][a:b, k, 1])
    return replace(take, allowed=allowed, **feet)


def _heel_up(ankle: Floats, heel: Floats, toe: Floats, pitch: Floats) -> dict[str, Floats]:
    """A foot (each n, 3) turned heel up by angles (n,) [rad], its lowest point as high as before."""
    side = np.cross([0.0, 1.0, 0.0], toe - heel)
    side /= np.linalg.norm(side, axis=1, keepdims=True) + 1e-9
    turn = rotation.from_rotation_vector(side * pitch[:, None])
    ankle, raised = (toe + rotation.rotate(turn, point - toe) for point in (ankle, heel))
    down = np.minimum(heel[:, 1], toe[:, 1]) - np.minimum(raised[:, 1], toe[:, 1])
    points = {"ankle": ankle, "heel": raised, "toe": toe}
    return {p: point + down[:, None] * [0.0, 1.0, 0.0] for p, point in points.items()}


def _parts_on_forefoot(take: Take, k: int, stance: slice, heel: Floats, toe: Floats) -> Bools:
    """(n, 4) which parts may stand in a stance whose foot was turned, and its heel and toe now have these heights."""
    lies = np.quantile(take.heel[stance, k, 1], 0.2) - np.quantile(take.toe[stance, k, 1], 0.2)
    allowed = parts(heel, toe)
    allowed[heel - toe > lies + 0.02, HEEL:TOE] = False
    allowed[:, TOE] |= ~allowed[:, HEEL:].any(axis=1)
    return allowed


def _fall(u: Floats) -> Floats:
    """1 where u is zero or less, falling to 0 at 1, smoothly."""
    return np.asarray(0.5 + 0.5 * np.cos(np.pi * np.clip(u, 0.0, 1.0)))


def on_stairs(take: Take, random: Random) -> Take:
    """With each stance one step higher than the last, or lower, of a few; the swings lead from step to step."""
    step = random.choice([-1.0, 1.0]) * random.uniform(0.06, 0.24)
    stances = sorted((a, b, k) for k in (0, 1) for a, b in runs(take.stands[:, k]) if b - a > 0.05 * RATE)
    if not 2 <= len(stances) <= 60:
        return take
    level = random.integers(len(stances)) if random.random() < 0.5 else 0  # so many stances come before the stairs
    last = level + random.integers(1, 7) if random.random() < 0.5 else len(stances)  # one step is a curb
    heights = step * np.clip(np.arange(len(stances)) - level, 0, last - level)
    lift = np.zeros((len(take.pelvis), 2))
    for k in (0, 1):
        mine = [(a, b, h) for (a, b, foot), h in zip(stances, heights.tolist(), strict=True) if foot == k]
        if not mine:
            continue
        lift[: mine[0][1], k] = mine[0][2]
        for (_, off, low), (strike, end, high) in pairwise(mine):
            share = np.linspace(0.0, 1.0, strike - off)
            early = random.uniform(1.0, 1.7)  # up: the foot is up early; down: it comes down late
            share = np.minimum(share * early, 1.0) if high > low else 1.0 - np.minimum((1.0 - share) * early, 1.0)
            lift[off:strike, k] = low + (high - low) * share**2 * (3.0 - 2.0 * share)
            lift[strike:end, k] = high
        lift[mine[-1][1] :, k] = mine[-1][2]
    body = savgol(lift.mean(axis=1), 1.0 / RATE, seconds=0.6, degree=1)
    up = np.array([0.0, 1.0, 0.0])
    feet = {p: getattr(take, p) + lift[:, :, None] * up for p in ("ankle", "heel", "toe")}
    hip = take.hip + body[:, None, None] * up
    return replace(take, pelvis=take.pelvis + body[:, None] * up, hip=hip, **feet)


def _noisy(take: Take, frame_time: float, random: Random) -> Take:
    """With every joint turning at random, a fraction of a degree; each moves all that hangs from it."""
    count = len(take.pelvis)
    degrees = random.choice([0.1, 0.2, 0.4, 0.6]) * random.uniform(0.5, 1.2)
    smooth = random.random() < 0.3

    def turn(*shape: int) -> Floats:
        size = int(np.prod(shape))
        flat = wander(random, count, 1.0 / frame_time, 0.06, size) if smooth else random.normal(size=(count, size))
        return np.asarray(np.radians(degrees) * flat.reshape(count, *shape))

    root, thigh, shin, foot = turn(1, 3), turn(2, 3), turn(2, 3), turn(2, 3)
    hip = take.hip + np.cross(root, take.hip - take.pelvis[:, None])
    leg = take.ankle - take.hip
    ankle = take.ankle + hip - take.hip + np.cross(root + thigh, leg) + np.cross(shin, 0.5 * leg)
    whole = root + thigh + shin + foot
    moved = {p: getattr(take, p) + ankle - take.ankle + np.cross(whole, getattr(take, p) - take.ankle)
             for p in ("heel", "toe")}  # fmt: skip
    return replace(take, hip=hip, ankle=ankle, **moved)
