"""Find the cycle of a clip that contains hardly more than one stride, from its similar ends."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from footfix.errors import InputError
from footfix.locomotion.loop.cut_search import Cut, find_cuts, jolts
from footfix.locomotion.loop.cyclic_contacts import wrapped
from footfix.locomotion.loop.existing_cycle import whole_cycle
from footfix.locomotion.loop.params import LoopParams
from footfix.locomotion.loop.point_cloud import clouds, distances
from footfix.locomotion.loop.strides import count_strides, stances, weights
from footfix.motion.clip import Bools, Clip, Floats
from footfix.motion.contacts import Contacts
from footfix.motion.kinematics import places
from footfix.rig.rig import Rig

_SHORT = 1.5  # longest clip treated as one stride, as a multiple of the cycle
_SHORTEST, _LONGEST = 0.3, 2.5  # [s] of a stride
_ENDS = 0.2  # share of the clip's frames at each end that are searched
_NEAR = 0.75  # factor on the allowed distance of poses, since motion before and after them is unknown
_SAME = 0.03  # [leg lengths] poses nearer than this are equal, whatever contacts say
_SURE = 0.06  # [s] uncertainty of contacts at the ends of a clip
_WHOLE = 0.01  # [leg lengths] the clip's own ends are preferred if they are at most this much worse than others
_MOST, _APART = 8, 0.06  # most cuts returned, and the least difference of their ends as a share of the clip
_MOVES = 0.4  # of the usual speed: a slower figure at the ends has taken a step, not walked a cycle


def cuts_of(clip: Clip, rig: Rig, contacts: Contacts, params: LoopParams) -> tuple[Clip, tuple[Cut, ...]]:
    """Find where a clip can be cut: the best cut first.

    A clip hardly longer than a round is a cycle as a whole, perhaps without its last frame, or contains one stride.

    Args:
        clip: F frames.
        rig: its legs.
        contacts: when the feet are planted.
        params: of the loop.

    Returns:
        The clip, with its missing last frame if any, and its cuts.

    Raises:
        InputError: it contains no cycle, or not the requested one.
    """
    given = params.start is not None or params.end is not None
    try:
        cuts = find_cuts(clip, rig, contacts, params)
        if given or len(clip) > _SHORT * (cuts[0].end - cuts[0].start):
            return clip, cuts
        more = _single(clip, rig, contacts, params)
        return clip, (*more, *cuts) if more and more[0].gap < cuts[0].gap else cuts
    except InputError:
        if given:
            raise
        whole = whole_cycle(clip, rig)
        cuts = _single(clip if whole is None else whole, rig, contacts, params, known=whole is not None)
        if not cuts:
            raise
        return whole or clip, cuts


def _single(clip: Clip, rig: Rig, contacts: Contacts, params: LoopParams, known: bool = False) -> tuple[Cut, ...]:
    """Find the cuts of a clip hardly longer than a cycle, the best first; the whole clip if that is known."""
    cuts = (Cut(0, len(clip) - 1, -1, 0, 0, 0.0),) if known else single_stride(clip, rig, contacts, params)
    counts = [count_strides(wrapped(contacts, cut.start, cut.end - cut.start), rig) for cut in cuts]
    found = (replace(cut, strides=count) for cut, count in zip(cuts, counts, strict=True))
    return tuple(cut for cut in found if params.strides in (None, cut.strides))


def single_stride(clip: Clip, rig: Rig, contacts: Contacts, params: LoopParams) -> tuple[Cut, ...]:
    """Find where to cut the one stride of a short clip, the best cut first; empty where it has none.

    Its ends are similar poses with the same feet planted; in between every foot is planted and lifted. This excludes
    half a stride, at whose ends the feet have changed places.

    Args:
        clip: F frames.
        rig: its legs.
        contacts: when the feet are planted.
        params: what is asked for.
    """
    frames = len(clip)
    if not _SHORTEST <= (frames - 1) * clip.frame_time <= _LONGEST or params.method == "kim-neff":
        return ()
    reach = int(_ENDS * frames)
    first, last = np.arange(reach + 1), np.arange(frames - 1 - reach, frames)
    gap = distances(clouds(clip, rig, first, 0.0), clouds(clip, rig, last, 0.0))
    down, speed = _planted(contacts, rig), _speeds(clip, rig)
    near = _SURE / clip.frame_time
    may, lifted = _near(down, near), _near(~down, near)
    alike = (may[:, first, None] & may[:, None, last]) | (lifted[:, first, None] & lifted[:, None, last])
    fit = np.all(alike, axis=0) | (gap <= _SAME * rig.leg_length)
    moves = speed >= _MOVES * np.median(speed)
    fit &= moves[first, None] & moves[last]
    fit &= (last - first[:, None]) * clip.frame_time >= _SHORTEST
    fit &= gap <= _NEAR * params.farthest * rig.leg_length
    cost = np.where(fit, gap + jolts(clip, rig, first, last), np.inf)
    if np.isfinite(cost[0, -1]) and cost[0, -1] <= cost.min() + _WHOLE * rig.leg_length:
        cost[0, -1] = 0.0
    found, beside = [], max(1, round(_APART * frames))
    for _ in range(_MOST):
        a, b = np.unravel_index(np.argmin(cost), cost.shape)
        if not cost[a, b] < np.inf:
            break
        within = down[:, first[a] : last[b]]
        if np.all(within.any(axis=1) & ~within.all(axis=1)):
            found.append(Cut(int(first[a]), int(last[b]), -1, 0, 0, float(gap[a, b])))
        cost[max(a - beside, 0) : a + beside + 1, max(b - beside, 0) : b + beside + 1] = np.inf
    return tuple(found)


def _planted(contacts: Contacts, rig: Rig) -> Bools:
    """Mark when heel or toe of a leg is planted, (legs, F)."""
    down = np.zeros((len(rig.legs), contacts.frames), dtype=np.bool_)
    for leg in range(len(rig.legs)):
        for start, end in stances(contacts, rig, leg):
            down[leg, start:end] = True
    return down


def _near(said: Bools, reach: float) -> Bools:
    """Extend a mask (legs, F) by some frames before and after."""
    n = max(1, round(reach))
    padded = np.pad(said, ((0, 0), (n, n)))
    return np.asarray(np.lib.stride_tricks.sliding_window_view(padded, 2 * n + 1, axis=1).any(axis=-1))


def _speeds(clip: Clip, rig: Rig) -> Floats:
    """Compute the root mean square of the joints' speeds, (F,) [m/s]."""
    step = np.diff(places(clip), axis=0) / clip.frame_time
    size = np.sqrt(np.einsum("fji,fji,j->f", step, step, weights(clip, rig)))
    return np.asarray(np.maximum(np.append(size, size[-1]), np.append(size[0], size)))
