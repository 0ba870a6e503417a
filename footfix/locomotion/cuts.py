"""Where a cycle can be cut out of a clip: between two stances of the same foot, in poses that are alike."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from footfix.errors import InputError
from footfix.locomotion.cloud import clouds, distances
from footfix.locomotion.params import LoopParams
from footfix.locomotion.strides import Stride, find_strides, style_distances
from footfix.motion.clip import Clip, Floats, Ints
from footfix.motion.contacts import Contacts
from footfix.rig.rig import Rig

_MOST = 60  # cuts whose frames are looked at one by one, the likeliest of them
_CLEAR = 1.0 / 30.0  # [s] from the ends of a clip, so that the velocity of a cut is known
_BY_HAND = 0.25  # of a stride, by which one may differ from the usual one where one end is given
_BETTER = 0.85  # of the loss of style: more strides must leave less than this to be worth it


@dataclass(frozen=True)
class Cut:
    """A cycle of a clip.

    Args:
        start, end: its first frame, and the frame whose pose is the first one's.
        leg: index among `Rig.legs`, of the foot that stands at both; -1 where the frames are given.
        strides: how many it has.
        gap: [m] root mean square distance of the joints of both ends.
        loss: [m] by how much the clip's other strides differ from its own; 0 where there are none.
        stands: the stances that its ends lie in.
    """

    start: int
    end: int
    leg: int
    strides: int
    gap: float
    loss: float = 0.0
    stands: tuple[tuple[int, int], tuple[int, int]] = ((0, 0), (0, 0))

    @property
    def cost(self) -> float:
        """[m] by which cuts are ranked."""
        return self.gap + 0.5 * self.loss


def find_cuts(clip: Clip, rig: Rig, contacts: Contacts, params: LoopParams) -> tuple[Cut, ...]:
    """The cuts of a clip, the best one first.

    Args:
        clip: F frames.
        rig: its legs.
        contacts: when the feet are planted.
        params: what is asked for.

    Raises:
        InputError: it holds no cycle, or not the one that is asked for.
    """
    if params.start is not None and params.end is not None:
        return (_given(clip, params),)
    strides = find_strides(contacts, rig)
    if not any(strides):
        raise InputError(f"no cycle found: {_told(contacts, rig)}", hint="--start and --end say where one lies")
    if params.start is not None or params.end is not None:
        return (_half_given(clip, strides, params),)
    rough = [cut for own in strides if own for cut in _rough(clip, rig, own, params)]
    if not rough:
        asked = f"{params.strides} strides on end" if params.strides else "a whole stride"
        raise InputError(f"no cycle found: the clip does not hold {asked} ({_told(contacts, rig)})")
    cuts = [_fine(clip, cut, params) for cut in _likeliest(rough)]
    near = params.farthest * rig.leg_length
    good = [cut for cut in cuts if cut.gap <= near]
    if not good:
        best = min(cuts, key=lambda cut: cut.gap)
        raise InputError(
            f"no cycle found: the most alike poses of the same foot, frames {best.start} and {best.end}, are "
            f"{1000.0 * best.gap:.0f} mm apart in the mean, more than {1000.0 * near:.0f}",
            hint="loop.farthest allows more",
        )
    return _ranked(good, params.style * rig.leg_length)


def _told(contacts: Contacts, rig: Rig) -> str:
    """What was found instead of a cycle."""
    from footfix.locomotion.strides import stances

    counts = ", ".join(f"{leg.name} {len(stances(contacts, rig, k))}" for k, leg in enumerate(rig.legs))
    return f"a cycle needs two plants of one foot and one of the other between them; plants found: {counts}"


def _given(clip: Clip, params: LoopParams) -> Cut:
    start, end = params.start or 0, params.end or 0
    if not 0 <= start < end < len(clip):
        raise InputError(f"frames {start} to {end} are no part of a clip of {len(clip)} frames (0 to {len(clip) - 1})")
    if end - start < 4:
        raise InputError(f"frames {start} to {end} are too few for a cycle")
    return Cut(start, end, -1, params.strides or 0, _gaps(clip, np.array([start]), np.array([end]), params)[0, 0])


def _half_given(clip: Clip, strides: Sequence[Sequence[Stride]], params: LoopParams) -> Cut:
    """One end is given: the other is a usual stride away, or several, where the poses are most alike."""
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
    gap = _gaps(clip, first, last, params)
    a, b = np.unravel_index(np.argmin(gap), gap.shape)
    return Cut(int(first[a]), int(last[b]), -1, count, float(gap[a, b]))


def _gaps(clip: Clip, first: Ints, last: Ints, params: LoopParams) -> Floats:
    return distances(clouds(clip, first, params.window), clouds(clip, last, params.window))


def _rough(clip: Clip, rig: Rig, strides: Sequence[Stride], params: LoopParams) -> list[Cut]:
    """All cuts of one leg, from the middles of stances, with the loss of style of each."""
    apart = style_distances(clip, rig, strides) * rig.leg_length
    counts = [params.strides] if params.strides else range(1, params.most_strides + 1)
    found = []
    for count in counts:
        for k in range(len(strides) - count + 1):
            own = strides[k : k + count]
            if any(a.second != b.first for a, b in zip(own[:-1], own[1:], strict=True)):
                continue
            others = np.delete(apart[:, k : k + count], np.arange(k, k + count), axis=0)
            loss = float(np.median(others.min(axis=1))) if len(others) else 0.0
            stands = (own[0].first, own[-1].second)
            a, b = ((start + end) // 2 for start, end in stands)
            found.append(Cut(a, b, strides[0].leg, count, 0.0, loss, stands))
    if not found:
        return []
    middles = sorted({frame for cut in found for frame in (cut.start, cut.end)})
    poses = clouds(clip, np.array(middles), params.window)
    gap = distances(poses, poses)
    at = {frame: k for k, frame in enumerate(middles)}
    return [replace(cut, gap=float(gap[at[cut.start], at[cut.end]])) for cut in found]


def _likeliest(rough: Sequence[Cut]) -> list[Cut]:
    """Of each number of strides the best few."""
    counts = sorted({cut.strides for cut in rough})
    each = max(4, _MOST // len(counts))
    return [
        cut
        for count in counts
        for cut in sorted((c for c in rough if c.strides == count), key=lambda cut: cut.cost)[:each]
    ]


def _fine(clip: Clip, cut: Cut, params: LoopParams) -> Cut:
    """The cut at those frames of its stances in which the poses are most alike; K takes the middles."""
    if params.method == "kim-neff":
        return cut
    clear = max(1, round(_CLEAR / clip.frame_time))
    first, last = (_frames_of(span, clear, len(clip)) for span in cut.stands)
    gap = _gaps(clip, first, last, params)
    a, b = np.unravel_index(np.argmin(gap), gap.shape)
    return replace(cut, start=int(first[a]), end=int(last[b]), gap=float(gap[a, b]))


def _frames_of(span: tuple[int, int], clear: int, frames: int) -> Ints:
    """The frames of a stance, but for those at the ends of the clip."""
    start, end = max(span[0], clear), min(span[1], frames - clear)
    return np.arange(start, end) if end > start else np.array([(span[0] + span[1]) // 2])


def _ranked(cuts: Sequence[Cut], style: float) -> tuple[Cut, ...]:
    """As few strides as tell the style; among those the best cut first, then the others by their cost."""
    best = {count: min((c for c in cuts if c.strides == count), key=lambda cut: cut.cost)
            for count in sorted({cut.strides for cut in cuts})}  # fmt: skip
    chosen, *more = best.values()
    for cut in more:
        if chosen.loss <= style:
            break
        if cut.loss < _BETTER * chosen.loss and cut.gap <= 1.5 * chosen.gap:
            chosen = cut
    return (chosen, *sorted((cut for cut in cuts if cut is not chosen), key=lambda cut: cut.cost))
