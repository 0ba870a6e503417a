"""Handing one walk over to another: which moments belong together, how long it takes, and when which one leads."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise

import numpy as np

from footfix.errors import UsageError
from footfix.locomotion.walk import Walk
from footfix.motion.clip import Bools, Floats, Ints
from footfix.motion.kinematics import places
from footfix.motion.spline import Cubic, monotone

_FINE = 16  # steps a frame, in which a blend's clock is told
_STEEP = 0.04  # of a clip's 99th percentile of acceleration, that a blend may add
_BEND = 5.8  # of a quintic step in unit time: the most that it accelerates
_PHASES = 32  # at which two walks are compared


def ease(u: Floats) -> Floats:
    """A step from 0 to 1 over u from 0 to 1, at rest at both ends: 6 u^5 - 15 u^4 + 10 u^3."""
    u = np.clip(u, 0.0, 1.0)
    return np.asarray(u * u * u * (u * (6.0 * u - 15.0) + 10.0))


@dataclass(frozen=True, eq=False)
class Keys:
    """The key-times of a walk (K 6.1): its frame at each moment of a generic stride, and back.

    K leads linearly from key to key; here a monotone cubic does, so that no foot changes its speed at a key.

    Args:
        times: (n,) generic times [strides] of the keys of a round, from 0.
        frames: (n,) their frames.
        strides: of a round.
        length: [frames] of a round.
    """

    times: Floats
    frames: Floats
    strides: int
    length: int

    def frame(self, time: Floats) -> Floats:
        """Frames (F,) at generic times (F,)."""
        rounds = np.floor(time / self.strides)
        return np.asarray(self._curve(time - rounds * self.strides)[..., 0] + rounds * self.length)

    def time(self, frame: Floats) -> Floats:
        """Generic times (F,) at frames (F,)."""
        first = self.frames[0]
        rounds = np.floor((frame - first) / self.length)
        within = frame - rounds * self.length
        curve = self._curve
        fine = np.linspace(0.0, self.strides, 64 * len(self.times) + 1)
        time = np.interp(within, curve(fine)[:, 0], fine)
        for _ in range(4):  # Newton
            step = (curve(time)[..., 0] - within) / np.maximum(curve(time, 1)[..., 0], 1e-6)
            time = np.clip(time - step, 0.0, self.strides)
        return np.asarray(time + rounds * self.strides)

    @cached_property
    def _curve(self) -> Cubic:
        """Frames by times, with a round more on either side."""
        more = [(k * self.strides, k * self.length) for k in (-1, 0, 1, 2)]
        times = np.concatenate([self.times + t for t, _ in more])
        return monotone(times, np.concatenate([self.frames + f for _, f in more])[:, None])


def align(walks: Sequence[Walk]) -> tuple[Keys, ...]:
    """Key-times of walks: strikes of every leg, and lifts where all walks have them in one order.

    Walks of unlike numbers of strides are aligned stride by stride, which is what K's shorter clip as go-between does.
    """
    events = [_events(walk) for walk in walks]
    names = [name for name in events[0] if all(name in each for each in events)]
    strikes = [name for name in names if name[1] == "strike"]
    for wanted in (names, strikes, strikes[:1]):
        found = _aligned(walks, events, wanted)
        if found is not None:
            return found
    return tuple(Keys(np.zeros(1), np.zeros(1), walk.strides, walk.frames) for walk in walks)


def _events(walk: Walk) -> dict[tuple[int, str], Ints]:
    """Frames (strides,) of what happens once in each stride, counted from the first leg's strikes."""
    found: dict[tuple[int, str], Ints] = {}
    start = 0
    for leg in range(len(walk.rig.legs)):
        down, up = walk.strikes(leg)
        if len(down) != walk.strides:
            if leg == 0:
                return {}
            continue
        if leg == 0:
            start = int(down[0])
        for what, frames in (("strike", down), ("lift", up)):
            found[leg, what] = np.sort((frames - start) % walk.frames) + start
    return found


def _aligned(
    walks: Sequence[Walk], events: Sequence[dict[tuple[int, str], Ints]], names: Sequence[tuple[int, str]]
) -> tuple[Keys, ...] | None:
    """Key-times by some events; None where walks have them in different orders."""
    if not names:
        return None
    phases = []
    for walk, own in zip(walks, events, strict=True):
        first = own[names[0]].astype(np.float64)
        on = np.append(first, first[0] + walk.frames)
        inside = np.stack([(own[name] - first) / np.diff(on) for name in names])  # (events, strides)
        inside[1:] -= np.floor(inside[1:])
        phases.append(inside)
    orders = {tuple(np.argsort(column).tolist()) for each in phases for column in each.T}
    if len(orders) > 1:
        return None
    times = np.mean([each.mean(axis=1) for each in phases], axis=0)
    order = np.argsort(times)
    if np.any(np.diff(np.append(times[order], 1.0)) < 0.02):
        return None
    keys = []
    for walk, own, inside in zip(walks, events, phases, strict=True):
        first = own[names[0]].astype(np.float64)
        on = np.append(first, first[0] + walk.frames)
        frames = (first + inside * np.diff(on))[order]
        if np.any(np.diff(np.append(frames.T.ravel(), frames[0, 0] + walk.frames)) <= 0.0):
            return None
        at = times[order][:, None] + np.arange(walk.strides)
        keys.append(Keys(at.T.ravel(), frames.T.ravel(), walk.strides, walk.frames))
    return tuple(keys)


@dataclass(frozen=True)
class Transition:
    """One walk handed over to another.

    Args:
        before, after: index of either walk.
        start, end: [s] from the start, of the blend.
        metres: [m] on the path where it starts.
        effector: joint by which its length was told.
        asked: [s] its length by K 6.2.
        clamped: whether that was too short or too long.
    """

    before: int
    after: int
    start: float
    end: float
    metres: float
    effector: str
    asked: float
    clamped: bool


def blend_length(
    one: Walk, other: Walk, keys: tuple[Keys, Keys], at: float, ends: Sequence[int]
) -> tuple[int, float, float]:  # fmt: skip
    """Tell how long the change from one walk to another takes (K 6.2): dD / |T_a - T_b|, at equal phase.

    Args:
        one, other: the walks.
        keys: of either.
        at: generic time [strides] at which it starts.
        ends: the end effectors: head, hands and feet.

    Returns:
        The effector that differs most, the length by it [s], and the least [s] in which the blend itself accelerates
        no joint by much of what the walks do.
    """
    pair = tuple(zip((one, other), keys, strict=True))
    here = [places(walk.at(key.frame(np.array([at]))))[0, list(ends)] for walk, key in pair]
    apart = np.linalg.norm(here[1] - here[0], axis=1)
    most = int(np.argmax(apart))
    speeds = [_speed(walk, ends[most]) for walk in (one, other)]
    differ = abs(speeds[0] - speeds[1])
    asked = float(apart[most] / differ) if differ > 1e-9 else np.inf if apart[most] > 1e-9 else 0.0
    time = np.linspace(0.0, float(np.lcm(one.strides, other.strides)), _PHASES * one.strides, endpoint=False)
    whole = [places(walk.at(key.frame(time))) for walk, key in pair]
    gap = np.linalg.norm(whole[1] - whole[0], axis=2).max(axis=0)
    steep = np.max([_acceleration(walk) for walk in (one, other)], axis=0)
    floor = 0.2 * float(np.median(steep))
    least = float(np.sqrt(_BEND * gap / (_STEEP * np.maximum(steep, max(floor, 1e-6)))).max())
    return ends[most], asked, least


def _speed(walk: Walk, joint: int) -> float:
    """[m/s] of a joint in the world, in the mean."""
    track = places(walk.clip)[:, joint] + np.outer(np.arange(walk.frames + 1), [0.0, 0.0, walk.length / walk.frames])
    return float(np.linalg.norm(np.diff(track, axis=0), axis=1).mean()) / walk.clip.frame_time


def _acceleration(walk: Walk) -> Floats:
    """(J,) [m/s^2] the 99th percentile of each joint's acceleration."""
    place = places(walk.clip)
    second = np.diff(np.concatenate([place[-2:-1], place]), n=2, axis=0) / walk.clip.frame_time**2
    return np.asarray(np.percentile(np.linalg.norm(second, axis=2), 99.0, axis=0))


@dataclass(frozen=True, eq=False)
class Zone:
    """A stretch of frames in which at most two walks are blended.

    Args:
        frames: `[start, end)` of the timeline.
        walks: index of the walk before, and after.
        at: for either (F,) its moment [frames of its round], in all frames of the timeline.
        weight: (F,) how much of the second.
    """

    frames: slice
    walks: tuple[int, int]
    at: tuple[Floats, Floats]
    weight: Floats


@dataclass(frozen=True, eq=False)
class Timeline:
    """Which moment of which walk each frame shows.

    Args:
        zones: one after the other.
        gone: (F,) [m] that the walks have gone, without what curves take; 0 at frame `first`.
        first: frames before the start.
        frame_time: [s].
        transitions: the blends.
    """

    zones: tuple[Zone, ...]
    gone: Floats
    first: int
    frame_time: float
    transitions: tuple[Transition, ...] = field(default_factory=tuple)

    def __len__(self) -> int:
        return len(self.gone)

    def blended(self) -> Bools:
        """(F,) whether two walks are blended in a frame."""
        weights = [np.where(z.at[0] is z.at[1], 0.0, z.weight[z.frames]) for z in self.zones]
        weight = np.concatenate(weights)
        return np.asarray((weight > 0.0) & (weight < 1.0))

    def leads(self) -> Ints:
        """(F,) index of the walk that leads in each frame."""
        return np.concatenate([np.where(z.weight[z.frames] >= 0.5, z.walks[1], z.walks[0]) for z in self.zones])


@dataclass(frozen=True)
class Pace:
    """How a walk is gone otherwise than captured.

    Args:
        time: how much longer a stride takes.
        stride: how much longer it is.
    """

    time: float = 1.0
    stride: float = 1.0


@dataclass(frozen=True, eq=False)
class Piece:
    """Walk `k` from a time [s] on, at a frame, having gone so far [m]."""

    k: int
    since: float
    frame: float
    gone: float


START = Piece(0, 0.0, 0.0, 0.0)


@dataclass(frozen=True, eq=False)
class Blend:
    """One blend on fine steps: times [s], frames of either walk, weight and way [m]."""

    before: Piece
    then: Piece
    times: Floats
    at: tuple[Floats, Floats]
    weight: Floats
    gone: Floats

    def lay(
        self, walks: Sequence[Walk], keys: Sequence[Keys], paces: Sequence[Pace], time: Floats, where: slice
    ) -> tuple[Zone, Floats]:
        """The zone about it."""
        a, b = self.before.k, self.then.k
        one, gone = _uniform(walks, paces, self.before, time)
        two, gone_after = _uniform(walks, paces, self.then, time)
        inside = (time > self.times[0]) & (time < self.times[-1])
        after: Bools = time >= self.times[-1]
        one[inside] = np.interp(time[inside], self.times, self.at[0])
        weight = np.where(after, 1.0, 0.0)
        weight[inside] = np.interp(time[inside], self.times, self.weight)
        gone = np.where(after, gone_after, gone)
        gone[inside] = np.interp(time[inside], self.times, self.gone)
        if walks[a] is walks[b] and paces[a] == paces[b]:
            one[after] = two[after]
            return Zone(where, (a, b), (one, one), weight), gone
        two[~after] = _to(keys[a], keys[b], one[~after])
        one[after] = _to(keys[b], keys[a], two[after])
        return Zone(where, (a, b), (one, two), weight), gone


def make_timeline(
    walks: Sequence[Walk], keys: Sequence[Keys], paces: Sequence[Pace], wanted: Sequence[Transition],
    frames: int, lead: int, frame_time: float,
) -> Timeline:  # fmt: skip
    """Lay walks one after the other, blended where one is handed over to the next.

    While they are blended, time goes as the mean of both by their weights, phase for phase.

    Args:
        walks: in their order.
        keys: of each.
        paces: of each.
        wanted: the transitions, in order; their times are those of the start.
        frames: from the start on.
        lead: frames before the start, and after the end.
        frame_time: [s].
    """
    time: Floats = np.asarray(np.arange(-lead, frames + lead) * frame_time, dtype=np.float64)
    blends = lay_blends(walks, keys, paces, wanted)
    cuts = [0]
    for one, two in pairwise(blends):
        cuts.append(int(np.searchsorted(time, 0.5 * (one.times[-1] + two.times[0]))))
    cuts.append(len(time))
    if not blends:
        at, gone = _uniform(walks, paces, START, time)
        zone = Zone(slice(0, len(time)), (0, 0), (at, at), np.zeros(len(time)))
        return Timeline((zone,), gone, lead, frame_time)
    zones, far = [], []
    for blend, a, b in zip(blends, cuts[:-1], cuts[1:], strict=True):
        zone, gone = blend.lay(walks, keys, paces, time, slice(a, b))
        zones.append(zone)
        far.append(gone[a:b])
    return Timeline(tuple(zones), np.concatenate(far), lead, frame_time, tuple(wanted))


def lay_blends(
    walks: Sequence[Walk], keys: Sequence[Keys], paces: Sequence[Pace], wanted: Sequence[Transition]
) -> list[Blend]:  # fmt: skip
    """The blends one after the other, on their own clocks."""
    piece, blends = START, list[Blend]()
    for change in wanted:
        blends.append(_blend(walks, keys, paces, piece, change))
        piece = blends[-1].then
    return blends


def time_at(
    gone: float, walks: Sequence[Walk], keys: Sequence[Keys], paces: Sequence[Pace], wanted: Sequence[Transition]
) -> float:  # fmt: skip
    """[s] after which walks have gone so far [m], whatever curves take."""
    piece = START
    for blend in lay_blends(walks, keys, paces, wanted):
        if gone <= blend.gone[0]:
            break
        if gone < blend.gone[-1]:
            return float(np.interp(gone, blend.gone, blend.times))
        piece = blend.then
    walk, pace = walks[piece.k], paces[piece.k]
    return piece.since + (gone - piece.gone) / (walk.speed * pace.stride / pace.time)


def frame_at(
    time: float, walks: Sequence[Walk], keys: Sequence[Keys], paces: Sequence[Pace], wanted: Sequence[Transition]
) -> tuple[float, float]:  # fmt: skip
    """The frame of the last of the walks at a time [s] after all transitions, and what was gone till then [m]."""
    blends = lay_blends(walks, keys, paces, wanted)
    at, gone = _uniform(walks, paces, blends[-1].then if blends else START, np.array([time]))
    return float(at[0]), float(gone[0])


def _uniform(walks: Sequence[Walk], paces: Sequence[Pace], piece: Piece, time: Floats) -> tuple[Floats, Floats]:
    """(F,) frames and (F,) [m] of a walk that goes on by itself."""
    walk, pace = walks[piece.k], paces[piece.k]
    at = piece.frame + (time - piece.since) / (walk.clip.frame_time * pace.time)
    return at, piece.gone + (at - piece.frame) * walk.length * pace.stride / walk.frames


def _to(one: Keys, other: Keys, frames: Floats) -> Floats:
    """Frames (F,) of another walk at the same generic times."""
    return other.frame(one.time(frames)) if one is not other else frames


def _blend(
    walks: Sequence[Walk], keys: Sequence[Keys], paces: Sequence[Pace], piece: Piece, change: Transition
) -> Blend:  # fmt: skip
    a, b = change.before, change.after
    same = walks[a] is walks[b] and paces[a] == paces[b]
    at, gone = _uniform(walks, paces, piece, np.array([change.start]))
    strides = (change.end - change.start) / np.mean([walks[k].stride_seconds * paces[k].time for k in (a, b)])
    first = keys[a].time(at)[0]
    last = at[0] + strides * walks[a].frames / walks[a].strides
    if not same:
        last = keys[a].frame(np.array([first + strides]))[0]
    one = np.linspace(at[0], last, max(int(np.ceil((last - at[0]) * _FINE)), 8) + 1)
    two = one if same else _to(keys[a], keys[b], one)
    weight = ease((one - at[0]) / (last - at[0]))
    part = 0.5 * (weight[1:] + weight[:-1])
    steps = [np.diff(each) for each in (one, two)]
    dt = [step * walks[k].clip.frame_time * paces[k].time for k, step in zip((a, b), steps, strict=True)]
    ds = [step * walks[k].length * paces[k].stride / walks[k].frames for k, step in zip((a, b), steps, strict=True)]
    times = change.start + np.append(0.0, np.cumsum((1.0 - part) * dt[0] + part * dt[1]))
    far = gone[0] + np.append(0.0, np.cumsum((1.0 - part) * ds[0] + part * ds[1]))
    return Blend(piece, Piece(b, float(times[-1]), float(two[-1]), float(far[-1])), times, (one, two), weight, far)


def check_order(starts: Sequence[float], names: Sequence[str]) -> None:
    """See that walks begin one after the other.

    Raises:
        UsageError: they do not.
    """
    for k in range(1, len(starts)):
        if starts[k] <= starts[k - 1]:
            raise UsageError(f"{names[k]} is to begin before {names[k - 1]} has")
