"""The timeline of blended walks: which time of which walk each frame shows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from footfix.locomotion.follow.blend_weight import Transition, handed
from footfix.locomotion.follow.key_times import Keys
from footfix.locomotion.follow.prepared_walk import Walk
from footfix.motion.clip import Bools, Floats, Ints

_FINE = 16  # steps per frame in which a blend's clock is integrated
_ROUNDS = 6  # iterations between weights and time


@dataclass(frozen=True, eq=False)
class Zone:
    """A stretch of frames in which at most two walks are blended.

    Args:
        frames: `[start, end)` of the timeline.
        walks: index of the walk before, and after.
        at: for either (F,) its moment [frames of its round], in all frames of the timeline.
        weight: (F,) of the second walk.
        time: (F,) the generic times [strides] of both; meaningless where only one is shown.
    """

    frames: slice
    walks: tuple[int, int]
    at: tuple[Floats, Floats]
    weight: Floats
    time: Floats


@dataclass(frozen=True, eq=False)
class Timeline:
    """Which time of which walk each frame shows.

    Args:
        zones: one after the other.
        gone: (F,) [m] distance walked, not reduced by curves; 0 at frame `first`.
        first: frames before the start.
        frame_time: [s].
        keys: of each walk.
        transitions: the blends.
    """

    zones: tuple[Zone, ...]
    gone: Floats
    first: int
    frame_time: float
    keys: tuple[Keys, ...]
    transitions: tuple[Transition, ...] = field(default_factory=tuple)

    def __len__(self) -> int:
        return len(self.gone)

    def blended(self) -> Bools:
        """Mark the frames (F,) in which two walks are blended."""
        weight = self.weight()
        return np.asarray((weight > 0.0) & (weight < 1.0))

    def weight(self) -> Floats:
        """Get the weight of the second of two walks, (F,); 0 where only one is shown."""
        return np.concatenate([np.where(z.at[0] is z.at[1], 0.0, z.weight[z.frames]) for z in self.zones])

    def leads(self) -> Ints:
        """Get the index of the walk with the greater weight, (F,)."""
        return np.concatenate([np.where(z.weight[z.frames] >= 0.5, z.walks[1], z.walks[0]) for z in self.zones])


@dataclass(frozen=True)
class Pace:
    """Scale of a walk's stride time and length, relative to the capture.

    Args:
        time: factor on the duration of a stride.
        stride: factor on its length.
    """

    time: float = 1.0
    stride: float = 1.0


@dataclass(frozen=True, eq=False)
class Piece:
    """Walk `k` from a time [s] on, with its frame and the distance walked [m] at that time."""

    k: int
    since: float
    frame: float
    gone: float


START = Piece(0, 0.0, 0.0, 0.0)


@dataclass(frozen=True, eq=False)
class Blend:
    """One blend in fine steps: times [s], frames of both walks, weight and distance [m]."""

    before: Piece
    then: Piece
    times: Floats
    at: tuple[Floats, Floats]
    weight: Floats
    gone: Floats

    def lay(
        self, walks: Sequence[Walk], keys: Sequence[Keys], paces: Sequence[Pace], time: Floats, where: slice
    ) -> tuple[Zone, Floats]:
        """Make the zone of the blend."""
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
            return Zone(where, (a, b), (one, one), weight, one), gone
        generic = np.concatenate([keys[a].time(one[~after]), keys[b].time(two[after])])
        two[~after] = keys[b].frame(generic[~after])
        one[after] = keys[a].frame(generic[after])
        return Zone(where, (a, b), (one, two), weight, generic), gone


def make_timeline(
    walks: Sequence[Walk], keys: Sequence[Keys], paces: Sequence[Pace], wanted: Sequence[Transition],
    frames: int | None, lead: int, frame_time: float, piece: Piece = START,
) -> Timeline:  # fmt: skip
    """Make the timeline of walks one after the other, each blended into the next.

    In a blend the phase advances at the weighted mean rate of both walks.

    Args:
        walks: in order.
        keys: of each.
        paces: of each.
        wanted: the transitions, in order; their times are those of the start.
        frames: from the start on; None until the last blend is over.
        lead: frames before the start, and after the end.
        frame_time: [s].
        piece: what the first walk shows at the start.
    """
    blends = lay_blends(walks, keys, paces, wanted, piece)
    if frames is None:
        frames = int(np.ceil(blends[-1].times[-1] / frame_time)) + 1
    time: Floats = np.asarray(np.arange(-lead, frames + lead) * frame_time, dtype=np.float64)
    cuts = [0]
    for one, two in pairwise(blends):
        cuts.append(int(np.searchsorted(time, 0.5 * (one.times[-1] + two.times[0]))))
    cuts.append(len(time))
    if not blends:
        at, gone = _uniform(walks, paces, piece, time)
        zone = Zone(slice(0, len(time)), (0, 0), (at, at), np.zeros(len(time)), at)
        return Timeline((zone,), gone, lead, frame_time, tuple(keys))
    zones, far = [], []
    for blend, a, b in zip(blends, cuts[:-1], cuts[1:], strict=True):
        zone, gone = blend.lay(walks, keys, paces, time, slice(a, b))
        zones.append(zone)
        far.append(gone[a:b])
    return Timeline(tuple(zones), np.concatenate(far), lead, frame_time, tuple(keys), tuple(wanted))


def lay_blends(
    walks: Sequence[Walk], keys: Sequence[Keys], paces: Sequence[Pace], wanted: Sequence[Transition],
    piece: Piece = START,
) -> list[Blend]:  # fmt: skip
    """Compute the blends in order, starting from the first walk's frame at the start."""
    blends = list[Blend]()
    for change in wanted:
        blends.append(_blend(walks, keys, paces, piece, change))
        piece = blends[-1].then
    return blends


def time_at(
    gone: float, walks: Sequence[Walk], keys: Sequence[Keys], paces: Sequence[Pace], wanted: Sequence[Transition]
) -> float:  # fmt: skip
    """Compute after which time [s] walks have covered a distance [m], not reduced by curves."""
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
    """Compute the last walk's frame at a time [s] after all transitions, and the distance walked until then [m]."""
    blends = lay_blends(walks, keys, paces, wanted)
    at, gone = _uniform(walks, paces, blends[-1].then if blends else START, np.array([time]))
    return float(at[0]), float(gone[0])


def _uniform(walks: Sequence[Walk], paces: Sequence[Pace], piece: Piece, time: Floats) -> tuple[Floats, Floats]:
    """Compute the frames (F,) of a walk that is shown alone, and the distances walked (F,) [m]."""
    walk, pace = walks[piece.k], paces[piece.k]
    at = piece.frame + (time - piece.since) / (walk.clip.frame_time * pace.time)
    return at, piece.gone + (at - piece.frame) * walk.length * pace.stride / walk.frames


def _to(one: Keys, other: Keys, frames: Floats) -> Floats:
    """Convert frames (F,) of a walk to those of another at the same generic times."""
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
    steps = [np.diff(each) for each in (one, two)]
    dt = [step * walks[k].clip.frame_time * paces[k].time for k, step in zip((a, b), steps, strict=True)]
    ds = [step * walks[k].length * paces[k].stride / walks[k].frames for k, step in zip((a, b), steps, strict=True)]
    weight, part, since = _weights(*dt)
    times = change.start + since
    if not same:
        step = walks[b].clip.frame_time * paces[b].time
        times = _on_whole_frames(times, float(two[-1]), step, walks[0].clip.frame_time)
    far = gone[0] + np.append(0.0, np.cumsum((1.0 - part) * ds[0] + part * ds[1]))
    return Blend(piece, Piece(b, float(times[-1]), float(two[-1]), float(far[-1])), times, (one, two), weight, far)


def _weights(one: Floats, two: Floats) -> tuple[Floats, Floats, Floats]:
    """Compute blend weights that are smooth in time, where time itself advances by the weighted mean of both walks.

    With weights smooth in phase, a walk with short strides would be blended in too fast at first.

    Args:
        one, two: (n,) [s] that steps take in either walk.

    Returns:
        (n + 1,) weights of the second, their means (n,) over steps, and (n + 1,) [s] since the start.
    """
    weight = handed(np.linspace(0.0, 1.0, len(one) + 1))
    for _ in range(_ROUNDS):
        part = 0.5 * (weight[1:] + weight[:-1])
        since = np.append(0.0, np.cumsum((1.0 - part) * one + part * two))
        weight = handed(since / since[-1])
    return weight, part, since


def _on_whole_frames(times: Floats, frame: float, step: float, frame_time: float) -> Floats:
    """Stretch a blend by up to half a frame, (n,) [s], smoothly, so that the next walk shows its very frames after it.

    Between frames interpolation would change the sharpness of strikes.

    Args:
        times: (n,) [s] of the blend.
        frame: of the next walk at its end.
        step: [s] that a frame of it takes.
        frame_time: [s].
    """
    if abs(step - frame_time) > 1e-6 * frame_time:
        return times
    off = times[-1] / frame_time - frame
    u = (times - times[0]) / (times[-1] - times[0])
    return np.asarray(times + (round(off) - off) * frame_time * handed(u))
