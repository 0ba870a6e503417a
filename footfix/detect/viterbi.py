"""From probabilities to intervals: the best path through the states of a foot, over the whole clip at once."""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from footfix.detect.network import FLAT, HEEL, SWING, TOE
from footfix.motion.clip import Bools, Floats
from footfix.motion.contacts import runs
from footfix.motion.segments import segments as laid_out

_SLOW, _BRAKED = 0.25, 0.4  # of the steps of a contact, the slowest; of the farthest step, one that is short again
EARLY = 0.4  # grid steps: plates, the more so filtered ones, tell of a landing a little before the joints do


class Stretch(NamedTuple):
    """A foot in one state, from and to a time in grid steps; the ends of the clip are infinitely far."""

    start: float
    end: float
    state: int


def stretches(logits: Floats, switch: float, roll: float, *, since: float = 0.0) -> list[Stretch]:
    """Decide what a foot does, stretch by stretch.

    Args:
        logits: (n, 4) log probabilities of the states.
        switch: nats that landing or leaving costs.
        roll: nats that a change between heel, flat and toe costs.
        since: [grid steps] plants that end before that are not wanted.

    Returns:
        The planted stretches in order; those that touch are one plant that rolls.
    """
    stands = np.logaddexp(np.logaddexp(logits[:, HEEL], logits[:, FLAT]), logits[:, TOE])
    planted = stands - logits[:, SWING]  # (n,) log odds
    found = []
    two = np.stack([np.zeros_like(planted), planted], axis=1)
    for a, b, state in segments(two, switch):
        if state and b >= since:
            start = crossing(planted, a) if a > 0 else -np.inf
            end = crossing(-planted, b) if b < len(planted) else np.inf
            found += _rolling(logits[a:b, HEEL:], a, start, end, roll)
    return found


def _rolling(logits: Floats, first: int, start: float, end: float, roll: float) -> list[Stretch]:
    """One plant in its stretches of heel, flat and toe."""
    parts = segments(logits, roll)
    times = [start]
    for (_, at, state), (_, _, following) in pairwise(parts):
        inside = first + crossing(logits[:, following] - logits[:, state], at)
        times.append(min(max(inside, times[-1]), end))
    times.append(end)
    return [Stretch(times[k], times[k + 1], HEEL + part[2]) for k, part in enumerate(parts)]


def crossing(score: Floats, at: int) -> float:
    """Find where a score rises through zero, between the grid steps at - 1 and at; halfway where it does not."""
    before, after = score[at - 1], score[at]
    if before < 0.0 <= after:
        return float(at - 1 + before / (before - after))
    return at - 0.5


def segments(score: Floats, switch: float) -> list[tuple[int, int, int]]:
    """Find the path of greatest total score (n, S), each change of state costing `switch`: `[start, end)` and state.

    A change pays only where the best state changes, so that the dynamic programme runs over stretches of
    one best state, not over steps; where one of these is given up, its neighbours share it at the best step.
    """
    best = np.argmax(score, axis=1)
    edges = (np.flatnonzero(best[1:] != best[:-1]) + 1).tolist()
    if not edges:  # one state all along
        return [(0, len(best), int(best[0]))]
    edges = [0, *edges, len(best)]
    total = np.zeros((len(score) + 1, score.shape[1]))
    np.cumsum(score, axis=0, out=total[1:])
    at = total[edges]
    kept = _viterbi((at[1:] - at[:-1]).tolist(), switch)
    first = [0, *(k for k in range(1, len(kept)) if kept[k] != kept[k - 1])]
    states, runs_of = [kept[k] for k in first], best[edges[:-1]].tolist()
    bounds = [0]
    for k in range(1, len(first)):
        # anywhere between the last run that is best in the one state and the first that is best in the other
        one, other = states[k - 1], states[k]
        lower, upper = _disputed(runs_of, first, k, one, other)
        low, high = max(edges[lower], bounds[-1]), edges[upper]
        gain = total[low : high + 1, one] - total[low : high + 1, other]
        bounds.append(low + int(np.argmax(gain)))
    bounds.append(len(best))
    return [(bounds[k], bounds[k + 1], state) for k, state in enumerate(states) if bounds[k] < bounds[k + 1]]


def _disputed(best: list[int], first: list[int], k: int, one: int, other: int) -> tuple[int, int]:
    """The runs [lower, upper) about the k-th change that are best in neither of its two states."""
    begin, end = first[k - 1], first[k + 1] if k + 1 < len(first) else len(best)
    lower = upper = first[k]
    while lower > begin and best[lower - 1] != one:
        lower -= 1
    while upper < end and best[upper] != other:
        upper += 1
    return lower, upper


def _viterbi(rows: list[list[float]], switch: float) -> list[int]:
    """The best path (n,) through states (n, S), a change costing `switch`; of so few, lists are quicker than arrays."""
    value, came = rows[0], []
    for row in rows[1:]:
        top = max(value)
        best, changed = value.index(top), top - switch
        came.append([k if each >= changed else best for k, each in enumerate(value)])
        value = [max(each, changed) + own for each, own in zip(value, row, strict=True)]
    path = [value.index(max(value))]
    for back in reversed(came):
        path.append(back[path[-1]])
    return path[::-1]


def masks(found: list[Stretch], frames: int, per_frame: float) -> tuple[Bools, Bools]:
    """Mark the frames in which heel and toe (F,) are in contact, each frame being `per_frame` grid steps.

    A contact starts with the first frame after the landing and ends before the first after the leaving; a frame
    that a landing misses by less than `EARLY`, and less than half a frame, counts as after it.
    """
    early = min(EARLY, 0.5 * per_frame)
    heel, toe = np.zeros(frames, dtype=np.bool_), np.zeros(frames, dtype=np.bool_)
    for start, end, state in found:
        a = max(int(np.ceil((start - early) / per_frame - 1e-9)), 0) if start > 0.0 else 0
        b = frames if end == np.inf else int(np.ceil(end / per_frame - 1e-9))
        heel[a:b] |= state in (HEEL, FLAT)
        toe[a:b] |= state in (FLAT, TOE)
    return heel, toe


def resting(part: Bools, planted: Bools, height: Floats, rise: float) -> Bools:
    """Keep a part of a foot (F,) down all along where it seems to leave and come back but does not rise.

    Args:
        part: (F,) heel, or toe, in contact.
        planted: (F,) the foot is in contact.
        height: (F,) of the part.
        rise: in the same unit; less than this over where it left and came back is no rise.
    """
    out = part.copy()
    for a, b in runs(planted & ~part):
        if a > 0 and b < len(part) and part[a - 1] and part[b]:
            highest = max(float(height[a - 1]), float(height[b])) + rise
            out[a:b] = bool(np.all(height[a:b] < highest))
    return out


def landed(part: Bools, step: Floats, farthest: float) -> Bools:
    """Leave frames out at both ends of contacts in which a part of a foot (F,) still goes far in one frame.

    At few frames a second the frame in which a foot comes down may be one of the quickest of its swing. Where it is,
    the contact begins once the foot is braked. At the clip's own ends nothing lands or leaves.

    Args:
        part: (F,) heel, or toe, in contact.
        step: (F - 1,) from each frame to the next, over the ground.
        farthest: in the same unit; what goes so much farther than the contact does at its slowest has not landed.
    """
    out = part.copy()
    found = [(a, b) for a, b in runs(part) if b - a > 1]
    steps = laid_out([(a, b - 1) for a, b in found])
    slowest = steps.quantile(step[steps.frames], _SLOW).tolist()
    for (a, b), slow in zip(found, slowest, strict=True):
        inside = step[a : b - 1] - slow
        rests = np.flatnonzero(inside <= _BRAKED * farthest)
        if not len(rests):
            continue
        if a > 0 and inside[0] > farthest:
            out[a : a + int(rests[0])] = False
        if b < len(part) and inside[-1] > farthest:
            out[a + int(rests[-1]) + 2 : b] = False
    return out
