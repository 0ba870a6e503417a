"""Viterbi decoding: from probabilities to the best path through the states of a foot over the whole clip."""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from footfix.detect.network import FLAT, HEEL, SWING, TOE
from footfix.motion.clip import Bools, Floats
from footfix.motion.contacts import runs
from footfix.motion.segments import segments as laid_out

_SLOW, _BRAKED = 0.25, 0.4  # quantile of a contact's steps that is slow; share of the longest step that is short
EARLY = 0.4  # grid steps: force plates, even more so filtered ones, report a landing a little before the joints show it


class Stretch(NamedTuple):
    """A foot in one state from one time to another [grid steps]; infinite at the ends of the clip."""

    start: float
    end: float
    state: int


def stretches(logits: Floats, switch: float, roll: float, *, since: float = 0.0) -> list[Stretch]:
    """Find the planted stretches of a foot by the best path through its states.

    Args:
        logits: (n, 4) log probabilities of the states.
        switch: cost of a landing or a lift-off [nats].
        roll: cost of a change between heel, flat and toe [nats].
        since: [grid steps] plants that end before this are left out.

    Returns:
        The planted stretches in order; adjoining ones are one plant that rolls from heel to toe.
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
    """Split one plant into its stretches of heel, flat and toe."""
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

    The path changes only where the best state does, so the dynamic programme runs over stretches of one best state,
    not over steps; where the path skips such a stretch, its neighbours divide it at the best step.
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
    """Find the runs [lower, upper) around the k-th change whose best state is neither of its two states."""
    begin, end = first[k - 1], first[k + 1] if k + 1 < len(first) else len(best)
    lower = upper = first[k]
    while lower > begin and best[lower - 1] != one:
        lower -= 1
    while upper < end and best[upper] != other:
        upper += 1
    return lower, upper


def _viterbi(rows: list[list[float]], switch: float) -> list[int]:
    """Find the best path (n,) through states (n, S); a change costs `switch`. Lists are faster here."""
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

    A contact starts with the first frame after the landing and ends before the first after the lift-off; a frame less
    than `EARLY`, and less than half a frame, before the landing counts as after it.
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
    """Fill gaps in the contacts of a part of a foot (F,) in which it does not rise.

    Args:
        part: (F,) heel, or toe, in contact.
        planted: (F,) the foot is in contact.
        height: (F,) of the part.
        rise: in the same unit; a gap is filled if the part rises less than this above both sides.
    """
    out = part.copy()
    for a, b in runs(planted & ~part):
        if a > 0 and b < len(part) and part[a - 1] and part[b]:
            highest = max(float(height[a - 1]), float(height[b])) + rise
            out[a:b] = bool(np.all(height[a:b] < highest))
    return out


def landed(part: Bools, step: Floats, farthest: float) -> Bools:
    """Leave out frames at both ends of contacts in which a part of a foot (F,) still moves far per frame.

    At few frames a second the frame in which a foot comes down may be one of the quickest of its swing. Where it is,
    the contact begins once the foot is braked. At the clip's own ends nothing lands or leaves.

    Args:
        part: (F,) heel, or toe, in contact.
        step: (F - 1,) from each frame to the next, over the ground.
        farthest: in the same unit; a step this much longer than the contact's slow ones is not contact.
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
