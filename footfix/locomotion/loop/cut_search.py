"""Find where to cut a cycle out of a clip: between two stances of the same foot, at similar poses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from footfix.errors import InputError
from footfix.locomotion.loop.params import LoopParams
from footfix.locomotion.loop.point_cloud import clouds, distances, turns, unrest
from footfix.locomotion.loop.seam import BESIDE, FLOOR, accelerations
from footfix.locomotion.loop.strides import Stride, find_strides, stances, style_distances
from footfix.motion.clip import Clip, Floats, Ints
from footfix.motion.contacts import Contacts
from footfix.rig.rig import Rig

_MOST = 60  # most cuts that are refined frame by frame
_COARSE = 1.0 / 30.0  # [s] between the frames that cuts are compared at
_CLEAR = 1.0 / 30.0  # [s] least distance from the ends of a clip, so that velocities at a cut are known
_BY_HAND = 0.25  # greatest difference from the usual stride, as a share of it, where one end is given
_TURN = 0.06  # [m/rad] penalty for a stride that turns the figure: one millimetre per degree
_PERIOD = 0.3  # greatest difference of a cut's length from the time between stance starts, in strides
_STRANGE = 0.25  # [leg lengths] if strides differ by more, the clip is not a gait
_UNREST = 0.015  # [m] penalty for an end in violent motion
_SEEN = 0.04  # [leg lengths] penalty for each multiple of its usual acceleration that a joint has at the seam
_OFF_BEAT = 0.1  # [leg lengths/s] penalty for the difference between a cut's length and its strides
_UNSEEN = 0.5  # multiple of the usual acceleration without penalty
_NEARLY = 0.03  # [leg lengths] greatest increase of pose distance accepted for a calmer seam
_STRIKE = 0.02  # [m] penalty for an end at a strike
_NEAR_STRIKE = 6  # frames before and after a strike that get it
_BETTER = 0.85  # more strides are chosen only if they reduce the loss of style to this share


@dataclass(frozen=True)
class Cut:
    """A cycle of a clip.

    Args:
        start, end: its first frame, and the frame whose pose is the first one's.
        leg: index among `Rig.legs`, of the foot that stands at both; -1 where the frames are given.
        strides: how many it has.
        frames: its length by the starts of its stances; 0 where the frames are given.
        gap: [m] root mean square distance of the joints of both ends.
        loss: [m] mean difference of the clip's other strides from its own; 0 where there are none.
        turn: [rad] by which it turns the figure.
        unrest: [m] penalty for violent motion at its ends.
        stands: the stances that its ends lie in.
    """

    start: int
    end: int
    leg: int
    strides: int
    frames: int
    gap: float
    loss: float = 0.0
    turn: float = 0.0
    unrest: float = 0.0
    stands: tuple[tuple[int, int], tuple[int, int]] = ((0, 0), (0, 0))

    @property
    def cost(self) -> float:
        """Compute the cost by which cuts are ranked [m]."""
        return self.gap + 0.5 * self.loss + self.unrest + _TURN * abs(self.turn)


def find_cuts(clip: Clip, rig: Rig, contacts: Contacts, params: LoopParams) -> tuple[Cut, ...]:
    """Find the cuts of a clip, the best one first.

    Args:
        clip: F frames.
        rig: its legs.
        contacts: when the feet are planted.
        params: of the loop.

    Raises:
        InputError: it contains no cycle, or not the requested one.
    """
    if params.start is not None and params.end is not None:
        return (_given(clip, rig, params),)
    strides = find_strides(contacts, rig)
    if not any(strides):
        raise InputError(f"no cycle found: {_told(contacts, rig)}", hint="--start and --end say where one lies")
    if params.start is not None or params.end is not None:
        return (_half_given(clip, rig, strides, params),)
    rough = [cut for own in strides if own for cut in _rough(clip, rig, own, params)]
    if not rough:
        asked = f"{params.strides} strides on end" if params.strides else "a whole stride"
        raise InputError(f"no cycle found: the clip does not hold {asked} ({_told(contacts, rig)})")
    rough_at = _UNREST * unrest(clip, rig) + _STRIKE * _near_strikes(contacts, rig)
    cuts = _fine(clip, rig, _likeliest(rough), rough_at, params)
    good = [cut for cut in cuts if cut.gap <= params.farthest * rig.leg_length]
    if not good:
        raise InputError(_no_match(cuts, params.farthest * rig.leg_length), hint="loop.farthest allows more")
    alike = [cut for cut in good if cut.loss <= _STRANGE * rig.leg_length]
    if not alike:
        least = min(cut.loss for cut in good)
        text = f"no two strides are alike, {1000.0 * least:.0f} mm apart in the mean: that is no walk and no run"
        raise InputError(f"no cycle found: {text}", hint="--start and --end cut whatever is asked for")
    return _ranked(alike, params.style * rig.leg_length)


def _near_strikes(contacts: Contacts, rig: Rig) -> Floats:
    """Mark with 1 (F,) the frames near a strike."""
    strikes = np.zeros(contacts.frames, dtype=np.bool_)
    strikes[[start for leg in range(len(rig.legs)) for start, _ in stances(contacts, rig, leg) if start > 0]] = True
    around = np.lib.stride_tricks.sliding_window_view(np.pad(strikes, _NEAR_STRIKE), 2 * _NEAR_STRIKE + 1)
    return np.asarray(around.any(axis=1), dtype=np.float64)


def _no_match(cuts: Sequence[Cut], near: float) -> str:
    best = min(cuts, key=lambda cut: cut.gap)
    if not np.isfinite(best.gap):
        return "no cycle found: no two plants of one foot are a stride apart"
    return (
        f"no cycle found: the most alike poses of the same foot, frames {best.start} and {best.end}, are "
        f"{1000.0 * best.gap:.0f} mm apart in the mean, more than {1000.0 * near:.0f}"
    )


def _told(contacts: Contacts, rig: Rig) -> str:
    """Describe what was found instead of a cycle."""
    counts = ", ".join(f"{leg.name} {len(stances(contacts, rig, k))}" for k, leg in enumerate(rig.legs))
    return f"a cycle needs two plants of one foot and one of the other between them; plants found: {counts}"


def _given(clip: Clip, rig: Rig, params: LoopParams) -> Cut:
    start, end = params.start or 0, params.end or 0
    if not 0 <= start < end < len(clip):
        raise InputError(f"frames {start} to {end} are no part of a clip of {len(clip)} frames (0 to {len(clip) - 1})")
    if end - start < 4:
        raise InputError(f"frames {start} to {end} are too few for a cycle")
    gap = _gaps(clip, rig, np.array([start]), np.array([end]), params)
    return Cut(start, end, -1, params.strides or 0, 0, float(gap[0, 0]))


def _half_given(clip: Clip, rig: Rig, strides: Sequence[Sequence[Stride]], params: LoopParams) -> Cut:
    """Find the other end of a cut from a given one: one or several usual strides away, at the most similar pose."""
    usual = float(np.median([s.frames for own in strides for s in own]))
    count = params.strides or 1
    near, far = round((count - _BY_HAND) * usual), round((count + _BY_HAND) * usual)
    if params.start is not None:
        first, last = np.array([params.start]), np.arange(params.start + near, params.start + far + 1)
    else:
        first, last = np.arange((params.end or 0) - far, (params.end or 0) - near + 1), np.array([params.end or 0])
    first, last = (each[(each >= 0) & (each < len(clip))] for each in (first, last))
    if not (len(first) and len(last)):
        asked = f"from frame {params.start} on" if params.start is not None else f"up to frame {params.end}"
        text = f"{asked} there is no {'stride' if count == 1 else f'{count} strides'} of {usual:.0f} frames"
        raise InputError(f"no cycle found: {text} in the clip's {len(clip)} frames")
    gap = _gaps(clip, rig, first, last, params)
    a, b = np.unravel_index(np.argmin(gap), gap.shape)
    return Cut(int(first[a]), int(last[b]), -1, count, 0, float(gap[a, b]))


def _gaps(clip: Clip, rig: Rig, first: Ints, last: Ints, params: LoopParams) -> Floats:
    return distances(clouds(clip, rig, first, params.window), clouds(clip, rig, last, params.window))


def _rough(clip: Clip, rig: Rig, strides: Sequence[Stride], params: LoopParams) -> list[Cut]:
    """List all cuts of one leg, from the middles of stances, with the loss of style of each."""
    apart = style_distances(clip, rig, strides) * rig.leg_length
    counts = [params.strides] if params.strides else range(1, params.most_strides + 1)
    found = []
    for count in counts:
        for k in range(len(strides) - count + 1):
            own = strides[k : k + count]
            if any(a.second != b.first for a, b in pairwise(own)):
                continue
            others = np.delete(apart[:, k : k + count], np.arange(k, k + count), axis=0)
            loss = float(np.median(others.min(axis=1))) if len(others) else 0.0
            stands = (own[0].first, own[-1].second)
            a, b = ((start + end) // 2 for start, end in stands)
            frames = sum(stride.frames for stride in own)
            found.append(Cut(a, b, strides[0].leg, count, frames, 0.0, loss, stands=stands))
    if not found:
        return []
    middles = sorted({frame for cut in found for frame in (cut.start, cut.end)})
    poses = clouds(clip, rig, np.array(middles), params.window)
    gap, turn = distances(poses, poses), turns(poses, poses)
    at = {frame: k for k, frame in enumerate(middles)}
    pairs = [(at[cut.start], at[cut.end]) for cut in found]
    return [replace(cut, gap=float(gap[k]), turn=float(turn[k])) for cut, k in zip(found, pairs, strict=True)]


def _likeliest(rough: Sequence[Cut]) -> list[Cut]:
    """Choose the best few cuts for each number of strides."""
    counts = sorted({cut.strides for cut in rough})
    each = max(4, _MOST // len(counts))
    return [
        cut
        for count in counts
        for cut in sorted((c for c in rough if c.strides == count), key=lambda cut: cut.cost)[:each]
    ]


def _fine(clip: Clip, rig: Rig, cuts: Sequence[Cut], rough_at: Floats, params: LoopParams) -> list[Cut]:
    """Move cuts to the frames of their stances with the most similar, calm poses; K takes the middles."""
    if params.method == "kim-neff":
        return list(cuts)
    clear = max(1, round(_CLEAR / clip.frame_time))
    stands = {span: _frames_of(span, clear, len(clip)) for cut in cuts for span in cut.stands}
    every = max(1, round(_COARSE / clip.frame_time))  # of the first frames; with all last ones, all periods are tried
    needed = np.unique(np.concatenate(list(stands.values())))
    poses = clouds(clip, rig, needed, params.window)
    found = []
    for cut in cuts:
        first, last = (stands[span] for span in cut.stands)
        first = first[(len(first) - 1) % every // 2 :: every]
        gap = distances(*(poses.some(np.searchsorted(needed, each)) for each in (first, last)))
        odd = np.abs(last - first[:, None] - cut.frames) > _PERIOD * cut.frames / cut.strides
        gap = np.where(odd, np.inf, gap)
        cost = gap + rough_at[first][:, None] + rough_at[last]
        a, b = np.unravel_index(np.argmin(cost), gap.shape)
        best, rough = float(gap[a, b]), float(rough_at[first[a]] + rough_at[last[b]])
        found.append(replace(cut, start=int(first[a]), end=int(last[b]), gap=best, unrest=rough))
    return found


def calmer(clip: Clip, rig: Rig, cut: Cut, params: LoopParams) -> Cut:
    """Move a cut to the frames of its two stances at which its seam is probably least visible.

    Near a seam no joint should accelerate more than elsewhere in the round: a heel strike at only one of both ends
    would show as a jerk.

    Args:
        clip: F frames.
        rig: its legs.
        cut: with known stances.
        params: of the loop.
    """
    if cut.leg < 0 or params.method == "kim-neff":
        return cut
    clear = max(1, round(_CLEAR / clip.frame_time))
    first, last = (_frames_of(span, clear, len(clip)) for span in cut.stands)
    gap = _gaps(clip, rig, first, last, params)
    odd = np.abs(last - first[:, None] - cut.frames) > _PERIOD * cut.frames / cut.strides
    far = gap > cut.gap + _NEARLY * rig.leg_length
    cost = (
        gap
        + jolts(clip, rig, first, last)
        + _OFF_BEAT * rig.leg_length * clip.frame_time * _off_beat(cut, first, last, len(clip))
    )
    a, b = np.unravel_index(np.argmin(np.where(odd | far, np.inf, cost)), gap.shape)
    return replace(cut, start=int(first[a]), end=int(last[b]), gap=float(gap[a, b]))


def _off_beat(cut: Cut, first: Ints, last: Ints, frames: int) -> Floats:
    """Compute how much rounds differ from the time between starts, or ends, of both stances, (N, M) [frames]."""
    (a, b), (c, d) = cut.stands
    told = [c - a] * (a > 0) + [d - b] * (d < frames) or [cut.frames]
    length = last - first[:, None]
    return np.asarray(np.min([np.abs(length - each) for each in told], axis=0), dtype=np.float64)


def jolts(clip: Clip, rig: Rig, first: Ints, last: Ints) -> Floats:
    """Compute the penalty (N, M) [m] of seams for accelerations near them that exceed those elsewhere.

    Args:
        clip: F frames.
        rig: its root and size.
        first, last: (N,), (M,) the frames of the two ends, in order.
    """
    sharp = accelerations(clip.frames(slice(first[0], last[-1] + 1)), rig)
    a, b, near = first - first[0], last - first[0], BESIDE
    middle = (a[-1] + b[0]) // 2
    until = np.maximum.accumulate(sharp[: middle + 1][::-1], axis=0)[::-1]  # the largest from a frame to the middle
    since = np.maximum.accumulate(sharp[middle:], axis=0)  # and from there to a frame
    inside = until[np.minimum(a + near + 1, middle)][:, None], since[np.maximum(b - near - 1 - middle, 0)][None]
    after = np.stack([sharp[k : k + near + 1].max(axis=0) for k in a])[:, None]
    before = np.stack([sharp[max(k - near, 0) : k + 1].max(axis=0) for k in b])[None]
    own = np.maximum(np.maximum(*inside), FLOOR)
    ratio = (np.maximum(after, before) / own).max(axis=-1)
    return np.asarray(_SEEN * rig.leg_length * np.maximum(ratio - _UNSEEN, 0.0))


def _frames_of(span: tuple[int, int], clear: int, frames: int) -> Ints:
    """List the frames of a stance, except those at the ends of the clip."""
    start, end = max(span[0], clear), min(span[1], frames - clear)
    return np.arange(start, end) if end > start else np.array([(span[0] + span[1]) // 2])


def _ranked(cuts: Sequence[Cut], style: float) -> tuple[Cut, ...]:
    """Rank cuts: first those with the fewest strides that represent the style, each group by cost."""
    best = {count: min((c for c in cuts if c.strides == count), key=lambda cut: cut.cost)
            for count in sorted({cut.strides for cut in cuts})}  # fmt: skip
    chosen, *more = best.values()
    for cut in more:
        if chosen.loss <= style:
            break
        if cut.loss < _BETTER * chosen.loss and cut.gap <= 1.5 * chosen.gap:
            chosen = cut
    return (chosen, *sorted((cut for cut in cuts if cut is not chosen), key=lambda cut: cut.cost))
