"""The cycle of a clip that holds one stride, and hardly more: its ends are alike."""

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

_SHORT = 1.5  # times a cycle, up to which a clip may hold one stride only, and no second plant to tell it
_SHORTEST, _LONGEST = 0.3, 2.5  # [s] of a stride
_ENDS = 0.2  # of the clip's frames, among which its ends are looked for
_NEAR = 0.75  # of the distance of poses that else are alike: nothing is known of how the figure came there, and goes on
_SAME = 0.03  # [leg lengths] poses so much alike are the same, whatever is said of the feet
_SURE = 0.06  # [s] as exactly the ends of plants are known at the ends of a clip
_WHOLE = 0.01  # [leg lengths] by which the clip's own ends may be worse than others
_MOST, _APART = 8, 0.06  # cuts that are told, whose ends lie elsewhere by more than this share of the clip's frames
_MOVES = 0.4  # of the usual speed: a figure that stands first and last has gone a step, which is no cycle


def cuts_of(clip: Clip, rig: Rig, contacts: Contacts, params: LoopParams) -> tuple[Clip, tuple[Cut, ...]]:
    """Find where a clip can be cut: the best cut first.

    One that is hardly more than a round is a cycle as a whole, and may lack its last frame; or its one stride is.

    Args:
        clip: F frames.
        rig: its legs.
        contacts: when the feet are planted.
        params: what is asked for.

    Returns:
        The clip, with the frame that it lacked, and its cuts.

    Raises:
        InputError: it holds no cycle, or not the one that is asked for.
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
    """The cycle of a clip that holds hardly more than one, the best cut first; all of it where that is known."""
    cuts = (Cut(0, len(clip) - 1, -1, 0, 0, 0.0),) if known else single_stride(clip, rig, contacts, params)
    counts = [count_strides(wrapped(contacts, cut.start, cut.end - cut.start), rig) for cut in cuts]
    found = (replace(cut, strides=count) for cut, count in zip(cuts, counts, strict=True))
    return tuple(cut for cut in found if params.strides in (None, cut.strides))


def single_stride(clip: Clip, rig: Rig, contacts: Contacts, params: LoopParams) -> tuple[Cut, ...]:
    """Find where the one stride of a short clip can be cut, the best cut first; nothing where it holds none.

    Its ends are poses that are alike, with the same feet planted; in between every foot is planted and lifted. So half
    a stride is none, since at its ends the feet have changed places.

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
    """(legs, F) whether heel or toe of a leg is planted."""
    down = np.zeros((len(rig.legs), contacts.frames), dtype=np.bool_)
    for leg in range(len(rig.legs)):
        for start, end in stances(contacts, rig, leg):
            down[leg, start:end] = True
    return down


def _near(said: Bools, reach: float) -> Bools:
    """(legs, F) whether something is so in any of the frames that are so near."""
    n = max(1, round(reach))
    padded = np.pad(said, ((0, 0), (n, n)))
    return np.asarray(np.lib.stride_tricks.sliding_window_view(padded, 2 * n + 1, axis=1).any(axis=-1))


def _speeds(clip: Clip, rig: Rig) -> Floats:
    """(F,) [m/s] root mean square of the joints' speeds."""
    step = np.diff(places(clip), axis=0) / clip.frame_time
    size = np.sqrt(np.einsum("fji,fji,j->f", step, step, weights(clip, rig)))
    return np.asarray(np.maximum(np.append(size, size[-1]), np.append(size[0], size)))
