"""The default detector: a small network gives probabilities of contact, and a best path over the clip decides."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import chain, pairwise

import numpy as np

from footfix.detect import weights
from footfix.detect.evidence import BODY, COLUMNS, OWN, STEP, Sampled, evidence, resample
from footfix.detect.kneeling import KneelingParams, carrying
from footfix.detect.network import FLAT, HEEL, SWING, TOE, Network
from footfix.detect.overtaking import OvertakingParams, overtaking
from footfix.detect.settling import SettlingParams, settled
from footfix.detect.stepping import SteppingParams, likely, stepping, velocities_of
from footfix.detect.timing import Timing, timed
from footfix.detect.tracks import Finding, FootTracks, Tracks
from footfix.detect.uncertainty import DoubtParams, frame_rate, unsure
from footfix.detect.viterbi import landed, masks, resting, stretches
from footfix.motion.clip import Bools, Floats
from footfix.motion.threads import at_once


@dataclass(frozen=True, kw_only=True)
class AutoParams:
    """Transition costs of the state path, and limits on planted feet.

    Args:
        switch: cost of a landing or a lift-off; a higher cost gives fewer and longer contacts [nats].
        roll: cost of a change between heel, flat and toe contact [nats].
        rise: [leg lengths] two contacts of one plant are joined if the heel or toe rises less than this in between.
        landing: [leg lengths] a foot that moves this much farther in one frame than in the slowest frame of its
            contact is still landing, or already leaving.
        highest: [leg lengths] greatest height of a planted foot's lowest point over the floor ahead and behind.
        steep: [leg lengths] height above `highest` that lowers the log odds of contact by one nat.
        rising: [leg lengths/s] vertical speed at which a foot has left the floor behind it, or has not reached the one
            ahead, with probability 0.5.
        stepping: when a foot that looks planted is stepping.
        overtaking: when a foot that moves ahead of the pelvis is swinging.
        settling: how much of the start and end of a step belongs to a contact.
        kneeling: when the feet of a kneeling figure are dragged.
        doubts: when to write notes on doubtful results.
    """

    switch: float = 3.0
    roll: float = 2.0
    rise: float = 0.01
    landing: float = 0.05
    highest: float = 0.065
    steep: float = 0.005
    rising: float = 2.0
    stepping: SteppingParams = field(default_factory=SteppingParams)
    overtaking: OvertakingParams = field(default_factory=OvertakingParams)
    settling: SettlingParams = field(default_factory=SettlingParams)
    kneeling: KneelingParams = field(default_factory=KneelingParams)
    doubts: DoubtParams = field(default_factory=DoubtParams)


PARTS, WAYS = ("heel", "toe"), ("ahead", "behind")
CHUNK = 12_000  # grid steps evaluated at a time, which bounds memory
_SHARP = 6.0  # exponent of the vertical speed in the odds
_MARGIN = 250  # grid steps around a chunk on which its evidence may depend


def auto(
    tracks: Tracks, params: AutoParams, network: Network | None = None, timing: Timing | None = None
) -> Finding:
    """Detect contacts of heel and toe from all evidence (see `evidence.py`), decided over the whole clip.

    The confidence of a contact is its mean probability. On people and walkers the network had not seen, contacts
    at 0.9 were right nine times in ten (`benchmarks/detection.py --confidence`).
    """
    sampled = resample(tracks)
    alone, answers = log_probabilities(sampled, params, weights.network() if network is None else network)
    when = weights.timing() if timing is None else timing
    per_frame = tracks.frame_time / STEP

    def parts(answer: Floats, k: int) -> tuple[Bools, Bools]:
        found = timed(stretches(answer, params.switch, params.roll), sampled, k, when)
        return masks(found, len(tracks), per_frame)

    def decided(k: int) -> list[Bools]:
        foot = tracks.feet[k]
        down = _finished(parts(answers[k], k), parts(alone[k], k), foot, tracks, params)
        return [
            carrying(part, tracks, foot, point, params.kneeling) for part, point in zip(down, foot.soles, strict=True)
        ]

    columns = list(chain.from_iterable(at_once([partial(decided, k) for k in range(len(answers))], len(tracks))))
    sure = [each for answer in answers for each in _parts(answer, len(tracks), per_frame)]
    notes = frame_rate(tracks, params.doubts)
    for foot, answer in zip(tracks.feet, answers, strict=True):
        planted = np.interp(np.arange(len(tracks)) * per_frame, np.arange(len(answer)), _planted(answer))
        notes += unsure(planted, tracks, foot.side, params.doubts)
    return Finding(np.stack(columns, axis=1), np.stack(sure, axis=1), notes)


def _finished(
    parts: tuple[Bools, Bools], looks: tuple[Bools, Bools], foot: FootTracks, tracks: Tracks, params: AutoParams
) -> tuple[Bools, Bools]:  # fmt: skip
    """Clean up the contacts (F,) of heel and toe: fill gaps in which they do not rise, leave out the ends of swings.

    Args:
        parts: (F,) heel and toe in contact, by all evidence.
        looks: (F,) heel and toe in contact, by the evidence of this foot alone.
        foot: tracks of this foot.
        tracks: tracks of the clip.
        params: limits on planted feet.
    """
    size = tracks.leg_length
    down = []
    for part, look, point in zip(parts, looks, foot.soles, strict=True):
        rests = resting(part, parts[0] | parts[1], point[:, 1], params.rise * size)
        place = point[:, ::2] / size
        step = np.linalg.norm(np.diff(place, axis=0), axis=1)
        down.append(settled(landed(rests, step, params.landing), look, place, tracks.frame_time, params.settling))
    return down[0], down[1]


def _planted(answer: Floats) -> Floats:
    return np.asarray(-np.expm1(answer[:, SWING]))


def log_probabilities(
    sampled: Sampled, params: AutoParams, network: Network, chunk: int = CHUNK
) -> tuple[tuple[Floats, ...], tuple[Floats, ...]]:
    """Compute each foot's log probabilities (n, 4), without and with regard to the other foot and the pelvis."""
    steps = len(sampled.tracks)
    count = max(-(-steps // chunk), 1)
    edges = [steps * k // count for k in range(count + 1)]  # of chunks of nearly the same length

    def answered_between(first: int, last: int) -> list[Floats]:
        low, high = max(first - _MARGIN, 0), min(last + _MARGIN, steps)
        part = slice(low, high)
        alone = tuple(grounded(network.logits(curves), curves, params) for curves in evidence(sampled, part))
        pelvis, feet = velocities_of(sampled.tracks, part)
        answered = stepping(alone, sampled.mates, pelvis, feet, params.stepping)
        answered = overtaking(answered, sampled.tracks.pelvis[part, ::2], pelvis, feet, params.overtaking)
        return [answer[first - low : last - low] for answer in (*alone, *answered)]

    found = at_once([partial(answered_between, *span) for span in pairwise(edges)], steps)
    whole = tuple(np.concatenate(answer) for answer in zip(*found, strict=True))
    return whole[: len(whole) // 2], whole[len(whole) // 2 :]


def grounded(answer: Floats, curves: Floats, params: AutoParams) -> Floats:
    """Rule out contact of a foot that is too high over its floor.

    That is the higher of the floors ahead and behind: a foot may stand on a stair that it has climbed, or will descend.
    But a foot that rises is leaving the floor behind it, and a foot that falls has yet to reach the one ahead.

    Args:
        answer: (n, 4) log probabilities.
        curves: (n, len(COLUMNS)) the evidence.
        params: how high a planted foot may be, and how fast it rises.
    """
    ahead, behind = (_columns(curves, f"over floor {way}", PARTS).min(axis=1) for way in WAYS)
    up, down = (likely(speed, params.rising, _SHARP) for speed in _leaving(curves))
    height = np.minimum(ahead, behind)  # (n,) [leg lengths] of the lowest point
    height += up * (behind - height) + down * (ahead - height)
    planted = np.logaddexp.reduce(answer[:, HEEL:], axis=1)
    odds = np.minimum(planted - answer[:, SWING], (params.highest - height) / params.steep)
    out = answer - planted[:, None] - np.logaddexp(0.0, -odds)[:, None]
    out[:, SWING] = -np.logaddexp(0.0, odds)
    return np.asarray(out)


def _leaving(curves: Floats) -> tuple[Floats, Floats]:
    """Compute how fast all of a foot rises, and how fast all of it falls, each (n,) 0 or more [leg lengths/s].

    What both feet have in common may be the root's: in files whose root does not move, the feet rise as the figure
    crouches. Unless the pelvis goes the same way: then the figure jumps, or comes down.
    """
    own, other = (_columns(curves, "rise", parts) for parts in (PARTS, [f"other {part}" for part in PARTS]))
    pelvis = BODY["pelvis rise"] * np.sinh(curves[:, COLUMNS.index("pelvis rise")])
    found = []
    for foot, mate, body in ((own, other, pelvis), (-own, -other, -pelvis)):
        slower = foot.min(axis=1)
        found.append(np.maximum(np.minimum(slower, np.maximum(slower - mate.max(axis=1), body)), 0.0))
    return found[0], found[1]


def _columns(curves: Floats, name: str, parts: Sequence[str]) -> Floats:
    """Get a feature of heel and toe in leg lengths and seconds, (n, 2)."""
    at = [COLUMNS.index(f"{part} {name}") for part in parts]
    return np.asarray(OWN[f"heel {name}"] * np.sinh(curves[:, at]))


def _parts(answer: Floats, frames: int, per_frame: float) -> tuple[Floats, Floats]:
    """Get the probabilities (F,) that the heel and the toe are in contact at each frame."""
    at, grid = np.arange(frames) * per_frame, np.arange(len(answer))
    p = np.exp(answer)
    return np.interp(at, grid, p[:, HEEL] + p[:, FLAT]), np.interp(at, grid, p[:, FLAT] + p[:, TOE])
