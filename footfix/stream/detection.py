"""Detection that goes along: what `detect.auto` says of a clip, said of its newest frames while they come in.

What each moment shows is weighed anew until it is so old that nothing more is decided of it. The path through the
states of a foot is found over the last second every time, and what has been told already stays.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from footfix.detect import fitted
from footfix.detect.auto import AutoParams, grounded
from footfix.detect.evidence import LIFT, STEP
from footfix.detect.kneeling import carrying
from footfix.detect.network import FLAT, HEEL, TOE, Network
from footfix.detect.path import EARLY, Stretch, resting, stretches
from footfix.detect.stepping import stands
from footfix.detect.timing import timed_by
from footfix.detect.tracks import Foot, Tracks
from footfix.motion.clip import Bools, Floats
from footfix.stream.filters import filtered
from footfix.stream.grid import FOOT, PAST, Grid
from footfix.stream.over_ground import OverGround
from footfix.stream.ring import Ring
from footfix.stream.stepping import overtaking, stepping
from footfix.stream.weigh import weigh

_REACH = 31  # steps that the network looks ahead and behind
_SETTLE = 0.15  # [s] before what is to be told, in which the answers may still change
_PATH = 1.2  # [s] over which the path is found
_KNEES = 0.5  # [s] over which feet of kneeling figures are looked at


@dataclass(frozen=True, eq=False)
class Seen:
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
    """Answer for all feet together: what `Network.logits` says of the last `count` of some curves (n, E).

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

    def weigh(self) -> None:
        """Weigh what the newest frames show."""
        places = self._grid.steps.last(round(PAST / STEP))
        count = min(max(self._open, self._grid.steps.end - self._answers.end), len(places))
        self._facing = self._over.facing()
        curves = weigh(places, self._facing, count + _REACH, self._mates, self._jitter)
        answered = logits(fitted.network(), curves, count)
        answers = grounded(
            answered.reshape(-1, answered.shape[-1]), curves[:, -count:].reshape(-1, curves.shape[-1]), self._params
        ).reshape(answered.shape)
        velocity = self._over.velocity(count)
        steps = stepping(answers, self._mates, velocity, self._over.speed(len(places)), self._params.stepping)
        swings = overtaking(places[:, 0, ::2], velocity, self._params.overtaking)
        answers = stands(answers, 1.0 - (1.0 - steps) * (1.0 - swings))
        self._answers.replace(self._grid.steps.end - count, answers.swapaxes(0, 1))

    def see(self, first: int) -> Seen:
        """Say which soles are planted from frame `first` on, by what was weighed."""
        end = self._frames.end
        answers = self._answers.last(self._path)
        last = len(answers)
        offset = self._answers.end - last
        brakes, tips = self._accelerations(last)
        down = np.zeros((end - first, 2 * len(self._mates)), dtype=np.bool_)
        sure = np.zeros_like(down, dtype=np.float64)
        lands, leaves = [], []
        frames = np.arange(first, end)
        at = np.clip(frames * self._per_frame - offset, 0, last - 1).astype(np.intp)
        for k in range(len(self._mates)):
            found = stretches(answers[:, k], self._params.switch, self._params.roll)
            found = timed_by(found, brakes[:, k], tips[:, k], fitted.timing())
            heel, toe = self._masks(found, offset, first, end)
            down[:, 2 * k], down[:, 2 * k + 1] = self._finished(heel, toe, k, first)
            p = np.exp(answers[at, k])
            sure[:, 2 * k], sure[:, 2 * k + 1] = p[:, HEEL] + p[:, FLAT], p[:, FLAT] + p[:, TOE]
            ends = {s.end for s in found}
            begins = {s.start for s in found}
            lands.append(tuple((t + offset) / self._per_frame for t in sorted(begins - ends) if np.isfinite(t)))
            leaves.append(tuple((t + offset) / self._per_frame for t in sorted(ends - begins) if np.isfinite(t)))
        return Seen(first, down, sure, tuple(lands), tuple(leaves))

    def _accelerations(self, last: int) -> tuple[Floats, Floats]:
        """(last, feet) each: what `detect.timing` calls braking and tipping, over the last steps."""
        places = self._grid.steps.last(last)
        pitch = np.unwrap(np.arctan2(places[:, 4::FOOT, 1] - places[:, 3::FOOT, 1], self._facing.ahead[-last:]), axis=0)
        both = filtered(np.concatenate([places[:, 2::FOOT, 1], pitch], axis=1), seconds=LIFT, degree=2, derivative=2)
        return both[:, : len(self._mates)], both[:, len(self._mates) :]

    def _masks(self, found: Sequence[Stretch], offset: int, first: int, end: int) -> tuple[Bools, Bools]:
        """Heel and toe in contact in frames `[first, end)`; a frame that a landing hardly misses counts as after it."""
        early = min(EARLY, 0.5 * self._per_frame)
        heel, toe = np.zeros(end - first, dtype=np.bool_), np.zeros(end - first, dtype=np.bool_)
        for start, stop, state in found:
            a = first if start == -np.inf else int(np.ceil((start + offset - early) / self._per_frame - 1e-9))
            b = end if stop == np.inf else int(np.ceil((stop + offset) / self._per_frame - 1e-9))
            span = slice(max(a - first, 0), max(b - first, 0))
            heel[span] |= state in (HEEL, FLAT)
            toe[span] |= state in (FLAT, TOE)
        return heel, toe

    def _finished(self, heel: Bools, toe: Bools, k: int, first: int) -> tuple[Bools, Bools]:
        """Heel and toe of a foot without gaps in which they don't rise, and without feet that are dragged."""
        places = self._frames.view(first)  # (n, feet, 3, 3)
        feet = tuple(
            Foot(side, p[:, 0], p[:, 0], p[:, 0], p[:, 1], p[:, 2])
            for side, p in zip(self._sides, places.swapaxes(0, 1), strict=True)
        )
        tracks = Tracks(places[:, 0, 0], feet, self._leg_length, self._frame_time)
        both, out = heel | toe, []
        lowest = places[:, :, :2, 1].min(axis=(1, 2))
        kneels = bool((places[:, k, 2, 1] - lowest < self._params.kneeling.low * self._leg_length).any())
        for part, point in ((heel, feet[k].heel), (toe, feet[k].toe)):
            down = resting(part, both, point[:, 1], self._params.rise * self._leg_length)
            out.append(carrying(down, tracks, feet[k], point, self._params.kneeling) if kneels else down)
        return out[0], out[1]
