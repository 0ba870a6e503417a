"""Online detection: `detect.auto` on the newest frames as they arrive.

The evidence of each time step is updated until it is too old to matter. The state path of a foot is found over the last
second each time; contacts already given out are kept.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil, isfinite

import numpy as np

from footfix.detect import weights
from footfix.detect.auto import AutoParams, grounded
from footfix.detect.evidence import LIFT, STEP
from footfix.detect.kneeling import carrying
from footfix.detect.network import FLAT, HEEL, TOE, Network
from footfix.detect.stepping import stands
from footfix.detect.timing import timed_by
from footfix.detect.tracks import FootTracks, Tracks
from footfix.detect.viterbi import EARLY, Stretch, resting, stretches
from footfix.motion.clip import Bools, Floats
from footfix.stream.evidence import newest_evidence
from footfix.stream.filters import filtered
from footfix.stream.ground_velocities import OverGround
from footfix.stream.ring_buffer import Ring
from footfix.stream.stepping import overtaking, stepping
from footfix.stream.time_grid import FOOT, PAST, Grid

_REACH = 31  # steps that the network sees ahead and behind
_SETTLE = 0.15  # [s] before the frames to be given out, in which probabilities may still change
_PATH = 1.2  # [s] over which the path is found
_KNEES = 0.5  # [s] over which feet of kneeling figures are examined


@dataclass(frozen=True, eq=False)
class FoundContacts:
    """Contacts of the newest frames.

    Args:
        first: number of the first frame.
        down: (n, 2 feet) heel and toe of each foot in contact.
        sure: (n, 2 feet) the probability of that.
        lands, leaves: for each foot the moments [frames], in order, in that time.
    """

    first: int
    down: Bools
    sure: Floats
    lands: tuple[tuple[float, ...], ...]
    leaves: tuple[tuple[float, ...], ...]


def logits(network: Network, curves: Floats, count: int) -> Floats:
    """Compute `Network.logits` of the last `count` steps for all feet together.

    Args:
        network: the network.
        curves: (feet, n, E).
        count: how many answers are wanted.

    Returns:
        (feet, count, 4) log probabilities.
    """
    seen = (curves - network.mean) / network.spread  # (feet, n, E)
    n = seen.shape[1]
    at = np.arange(n - count, n)[:, None] + np.array(network.taps)  # (count, T)
    hidden = network.hidden.reshape(-1, network.hidden.shape[-1])  # (T E, H)
    total = seen.take(at, axis=1, mode="clip").reshape(len(seen), count, -1) @ hidden + network.hidden_bias
    z = np.tanh(np.tanh(total) @ network.mixing + network.mixing_bias) @ network.answer + network.answer_bias
    z -= z.max(axis=-1, keepdims=True)
    return np.asarray(z - np.log(np.exp(z).sum(axis=-1, keepdims=True)))


class Detector:
    """The detector of one figure in a stream."""

    def __init__(
        self, sides: Sequence[str], mates: Sequence[int], jitter: float, leg_length: float, frame_time: float,
        look_ahead: float, params: AutoParams,
    ) -> None:  # fmt: skip
        """Begin without frames.

        Args:
            sides: of the feet.
            mates: for each foot the other one of its pair.
            jitter: noise of the capture, in thousandths of a leg.
            leg_length: [m].
            frame_time: [s].
            look_ahead: [s] how long a frame waits for what follows it.
            params: the detector's.
        """
        self._sides, self._mates, self._jitter = tuple(sides), tuple(mates), jitter
        self._leg_length, self._frame_time, self._params = leg_length, frame_time, params
        self._per_frame = frame_time / STEP
        self._open = round((look_ahead + 1.0 / 30.0 + _SETTLE) / STEP) + round(self._per_frame)
        self._grid, self._over = Grid(len(self._mates), leg_length, frame_time), OverGround(mates)
        long = max(_PATH, 2.0 * look_ahead + 0.5)
        self._answers = Ring((len(self._mates), 4), round(long / STEP) + self._open)
        self._path = round(long / STEP)
        self._frames = Ring((len(self._mates), 3, 3), round(max(_KNEES, look_ahead + 0.3) / frame_time) + 4)

    def add(self, tracks: Tracks) -> None:
        """Take the next frames (n of them, with knees)."""
        feet = [np.stack([f.heel, f.toe, f.heel if f.knee is None else f.knee], axis=1) for f in tracks.feet]
        self._frames.append(np.stack(feet, axis=1))
        self._over.follow(self._grid.steps, self._grid.add(tracks))

    def compute_evidence(self) -> None:
        """Compute the features of the newest frames."""
        self._places = places = self._grid.steps.last(round(PAST / STEP))
        self._count = count = min(max(self._open, self._grid.steps.end - self._answers.end), len(places))
        self._facing = self._over.facing()
        curves = newest_evidence(places, self._facing, count + _REACH, self._mates, self._jitter)
        answered = logits(weights.network(), curves, count)
        self._answered = grounded(
            answered.reshape(-1, answered.shape[-1]), curves[:, -count:].reshape(-1, curves.shape[-1]), self._params
        ).reshape(answered.shape)

    def compute_probabilities(self) -> None:
        """Compute each foot's probabilities from these features and the motion of the whole figure."""
        velocity, speed = self._over.velocity(self._count), self._over.speed(len(self._places))
        steps = stepping(self._answered, self._mates, velocity, speed, self._params.stepping)
        swings = overtaking(self._places[:, 0, ::2], velocity, self._params.overtaking)
        answers = stands(self._answered, 1.0 - (1.0 - steps) * (1.0 - swings))
        self._answers.replace(self._grid.steps.end - self._count, answers.swapaxes(0, 1))

    def find_contacts(self, first: int) -> FoundContacts:
        """Find the contacts from frame `first` on by these probabilities."""
        end = self._frames.end
        answers = self._answers.last(self._path)
        last = len(answers)
        offset = self._answers.end - last
        since = first * self._per_frame - offset
        brakes, tips = self._accelerations(last)
        down = np.zeros((end - first, 2 * len(self._mates)), dtype=np.bool_)
        lands, leaves = [], []
        for k in range(len(self._mates)):
            found = stretches(answers[:, k], self._params.switch, self._params.roll, since=since)
            found = timed_by(found, brakes[:, k], tips[:, k], weights.timing())
            self._mark(found, offset - first * self._per_frame, down[:, 2 * k : 2 * k + 2])
            ends = {s.end for s in found}
            begins = {s.start for s in found}
            lands.append(tuple((t + offset) / self._per_frame for t in sorted(begins - ends) if isfinite(t)))
            leaves.append(tuple((t + offset) / self._per_frame for t in sorted(ends - begins) if isfinite(t)))
        at = np.minimum(np.maximum(np.arange(first, end) * self._per_frame - offset, 0.0), last - 1)
        p = np.exp(answers[at.astype(np.intp)])
        sure = (p[..., HEEL:TOE] + p[..., FLAT : TOE + 1]).reshape(down.shape)  # heel or flat, flat or toe
        return FoundContacts(first, self._finished(down, first), sure, tuple(lands), tuple(leaves))

    def _accelerations(self, last: int) -> tuple[Floats, Floats]:
        """Compute braking and tipping of `detect.timing` over the last steps, (last, feet) each."""
        places = self._grid.steps.last(last)
        pitch = np.arctan2(places[:, 4::FOOT, 1] - places[:, 3::FOOT, 1], self._facing.ahead[-last:])
        if np.any(np.abs(pitch[1:] - pitch[:-1]) > np.pi):
            pitch = np.unwrap(pitch, axis=0)
        both = filtered(np.concatenate([places[:, 2::FOOT, 1], pitch], axis=1), seconds=LIFT, degree=2, derivative=2)
        return both[:, : len(self._mates)], both[:, len(self._mates) :]

    def _mark(self, found: Sequence[Stretch], offset: float, down: Bools) -> None:
        """Mark when heel and toe are in contact, (n, 2); a frame just before a landing counts as after it.

        Args:
            found: the stretches.
            offset: [grid steps] from the first frame to the moment that stretches are counted from.
            down: (n, 2) what to mark.
        """
        early = min(EARLY, 0.5 * self._per_frame)
        for start, stop, state in found:
            a = 0 if start == -np.inf else max(ceil((start + offset - early) / self._per_frame - 1e-9), 0)
            b = len(down) if stop == np.inf else max(ceil((stop + offset) / self._per_frame - 1e-9), 0)
            down[a:b, 1 if state == TOE else 0 : 1 if state == HEEL else 2] = True

    def _finished(self, down: Bools, first: int) -> Bools:
        """Fill gaps of contacts (n, 2 feet) in which a part does not rise, and remove dragged feet."""
        places = self._frames.view(first)  # (n, feet, 3, 3)
        height = places[..., 1]
        both = down[:, ::2] | down[:, 1::2]  # (n, feet)
        gaps = both.repeat(2, axis=1) & ~down
        knees = height[:, :, 2] - height[:, :, :2].min(axis=(1, 2))[:, None]
        kneels = (knees < self._params.kneeling.low * self._leg_length).any(axis=0)
        out = down.copy()
        for column in np.flatnonzero(gaps.any(axis=0)).tolist():
            k, part = divmod(column, 2)
            out[:, column] = resting(
                down[:, column], both[:, k], height[:, k, part], self._params.rise * self._leg_length
            )
        for k in np.flatnonzero(kneels).tolist():
            tracks = self._tracks(places)
            for part in (0, 1):
                out[:, 2 * k + part] = carrying(
                    out[:, 2 * k + part], tracks, tracks.feet[k], places[:, k, part], self._params.kneeling
                )
        return out

    def _tracks(self, places: Floats) -> Tracks:
        """Lay out places (n, feet, 3, 3) of heels, toes and knees."""
        feet = tuple(
            FootTracks(side, p[:, 0], p[:, 0], p[:, 0], p[:, 1], p[:, 2])
            for side, p in zip(self._sides, places.swapaxes(0, 1), strict=True)
        )
        return Tracks(places[:, 0, 0], feet, self._leg_length, self._frame_time)
