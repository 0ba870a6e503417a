"""When walks blend into the next along a path, and which time of which walk each frame shows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from footfix.enforce.params import EnforceParams
from footfix.errors import UsageError
from footfix.locomotion.follow.balance import end_effectors
from footfix.locomotion.follow.blend_schedule import Pace, Timeline, frame_at, make_timeline, time_at
from footfix.locomotion.follow.blend_weight import Transition, blend_length, check_order
from footfix.locomotion.follow.key_times import Keys
from footfix.locomotion.follow.params import FollowParams
from footfix.locomotion.follow.path import Path
from footfix.locomotion.follow.prepared_walk import Walk
from footfix.locomotion.follow.stride import Way
from footfix.locomotion.follow.transition_duration import Handover, Length, choose_length
from footfix.notes import Note

_MOST = 300_000  # greatest number of frames
_LEAD = 1.6  # strides before the start and after the end that are computed and cut off


@dataclass(frozen=True)
class At:
    """Where a walk begins.

    Args:
        seconds: [s] after the start, or
        metres: [m] on the path; one of them.
    """

    seconds: float | None = None
    metres: float | None = None


def transitions_of(
    walks: Sequence[Walk], keys: Sequence[Keys], paces: Sequence[Pace], ats: Sequence[At], path: Path, way: Way,
    params: FollowParams, holding: EnforceParams,
) -> tuple[tuple[Transition, ...], tuple[Note, ...]]:  # fmt: skip
    """Find when each walk blends into the next, and for how long (K 6.2).

    Args:
        walks: in order.
        keys, paces, ats: of each its key-times, its changed stride time and length, and where it begins.
        path: the path.
        way: distances on the path by distances walked.
        params: with the limits on blends.
        holding: how footplants are enforced.

    Returns:
        The transitions, and notes.

    Raises:
        UsageError: a walk begins before the one ahead of it in the list.
    """
    rig, skeleton = walks[0].rig, walks[0].clip.skeleton
    ends = end_effectors(skeleton, rig)
    found: list[Transition] = []
    starts = [0.0]
    notes = []

    def begins(at: At) -> float:
        return at.seconds if at.seconds is not None else time_at(way.gone(at.metres or 0.0), walks, keys, paces, found)

    for k in range(1, len(walks)):
        start = begins(ats[k])
        starts.append(start)
        check_order(starts, [walk.name for walk in walks])
        if found and start < found[-1].end:
            found[-1] = replace(found[-1], end=start, clamped=True, peak=None)
            text = f"{walks[k].name} begins while {walks[k - 1].name} is still handed over to: that blend is shorter"
            notes.append(Note("blend-cut", text))
        frame, gone = frame_at(start, walks, keys, paces, found)
        over = Handover(
            (walks[k - 1], walks[k]), (keys[k - 1], keys[k]), (paces[k - 1], paces[k]), start, frame, holding, path,
            way, gone, params,
        )  # fmt: skip
        moment = float(keys[k - 1].time(np.array([frame]))[0])
        joint, asked = blend_length(*over.walks, over.keys, moment, ends)
        end = begins(ats[k + 1]) if k + 1 < len(walks) else params.seconds or begins(At(metres=path.length))
        took = choose_length(over, asked, end - start)
        if took.wait:
            notes.append(_waits(walks[k - 1], walks[k], took))
            start += took.wait
            gone = frame_at(start, walks, keys, paces, found)[1]
        found.append(Transition(
            k - 1, k, start, start + took.seconds, float(way.arc(np.array([gone]))[0]), skeleton.names[joint], asked,
            took.seconds != asked, took.peak, took.asked_peak,
        ))  # fmt: skip
    return tuple(found), tuple(notes)


def _waits(before: Walk, after: Walk, took: Length) -> Note:
    text = (
        f"{after.name} begins {took.wait:.2f} s later than asked: handed over from {before.name} just there, joints "
        "would be jolted, however long that took"
    )
    return Note("blend-waits", text)


def timeline_of(
    path: Path, way: Way, walks: Sequence[Walk], keys: Sequence[Keys], paces: Sequence[Pace],
    wanted: Sequence[Transition], params: FollowParams,
) -> tuple[Timeline, tuple[Note, ...]]:  # fmt: skip
    """Find which time of which walk each frame shows, until the path or the duration ends.

    Args:
        path: the path.
        way: distances on the path by distances walked.
        walks: in order.
        keys, paces: of each its key-times, and its changed stride time and length.
        wanted: the transitions.
        params: with the duration.

    Returns:
        The timeline, and notes.

    Raises:
        UsageError: a walk begins after the end, or there are too few frames or too many.
    """
    dt = walks[0].clip.frame_time
    whole = time_at(way.gone(path.length), walks, keys, paces, wanted)
    notes: tuple[Note, ...] = ()
    seconds = whole if params.seconds is None else params.seconds
    if seconds > whole and not path.closed:
        notes += (Note("path-ends", f"the path ends after {whole:.2f} s, before the {seconds:g} s asked for"),)
        seconds = whole
    for change in wanted:
        if change.start >= seconds:
            raise UsageError(
                f"{walks[change.after].name} is to begin after {change.start:.2f} s, but the walk ends after "
                f"{seconds:.2f} s, {path.length:.2f} m on"
            )
    frames = round(seconds / dt) + 1
    if not 2 <= frames <= _MOST:
        raise UsageError(f"{seconds:.2f} s are {frames} frames; 2 to {_MOST} can be made")
    lead = int(np.ceil(_LEAD * max(w.stride_seconds * p.time for w, p in zip(walks, paces, strict=True)) / dt)) + 2
    timeline = make_timeline(walks, keys, paces, wanted, frames, lead, dt)
    if params.seconds is None and not path.straight:  # the last frame is at the end of the path
        end = timeline.gone[lead + frames - 1]
        timeline = replace(timeline, gone=timeline.gone * (way.gone(path.length) / end))
    return timeline, notes
