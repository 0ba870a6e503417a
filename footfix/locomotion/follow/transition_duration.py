"""Duration of the blend from one walk to another: by the largest difference, or so that no joint jerks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from footfix.enforce.correction import apply
from footfix.enforce.params import EnforceParams
from footfix.locomotion.follow.blend_schedule import Pace, Piece, make_timeline
from footfix.locomotion.follow.blend_weight import Transition
from footfix.locomotion.follow.body_placement import lay_body
from footfix.locomotion.follow.key_times import Keys
from footfix.locomotion.follow.params import FollowParams
from footfix.locomotion.follow.path import Path
from footfix.locomotion.follow.path_layout import course_on, lay_figure
from footfix.locomotion.follow.plant_cleanup import held_on, stands
from footfix.locomotion.follow.prepared_walk import Walk
from footfix.locomotion.follow.stride import Way, paced
from footfix.locomotion.follow.walk_poses import contacts_of, pose
from footfix.locomotion.loop.seam import accelerations_of
from footfix.motion.clip import Clip, Floats
from footfix.motion.kinematics import forward, places

_SMOOTH = 1.08  # smooth enough: peak acceleration as a multiple of that in the walks
_ENOUGH = 1.1  # below this multiple no later start of the blend is tried
_LENGTHS = (1.2, 0.5, 1.4, 0.4, 2.0, 0.75, 1.0)  # [strides] durations tried where the asked one is too short
_LATER = ((0.2, 0.85), (0.3, 0.75), (0.4, 0.6))  # [strides] delays tried then, each with a duration
_WORTH = 0.05  # least reduction of the multiple for a delay
_ALIKE = 0.1  # least difference of durations tried, as a share
_BESIDE = 0.7  # [strides] before and after a blend that are computed, too
_SLACK = 5.0  # plants that slide at most this multiple of an invisible slide are held without a jerk
_FAINT = 0.05  # of the largest acceleration of any joint; joints with less are ignored


@dataclass(frozen=True)
class Length:
    """The duration of a blend.

    Args:
        seconds: [s] the chosen duration.
        asked: [s] the duration by the end effector that differs most (K 6.2), within the limits.
        peak: largest acceleration of a joint in it [times the 99th percentile in the walks],
        asked_peak: and in a blend of the asked duration; None where that was not computed.
        wait: [s] by which it begins later than asked.
    """

    seconds: float
    asked: float
    peak: float | None = None
    asked_peak: float | None = None
    wait: float = 0.0


@dataclass(frozen=True, eq=False)
class Handover:
    """A blend from one walk to another.

    Args:
        walks: both.
        keys, paces: of each its key-times, and its changed stride time and length.
        start: [s] on the clock of the frames written.
        frame: of the first walk then.
        holding: how footplants are enforced.
        path, way: the path, and the progress of walks along it.
        gone: [m] distance walked at the start.
        params: of the walk along the path.
    """

    walks: tuple[Walk, Walk]
    keys: tuple[Keys, Keys]
    paces: tuple[Pace, Pace]
    start: float
    frame: float
    holding: EnforceParams
    path: Path
    way: Way
    gone: float
    params: FollowParams

    @property
    def stride(self) -> float:
        """Compute the mean duration of a stride [s]."""
        return float(np.mean([w.stride_seconds * p.time for w, p in zip(self.walks, self.paces, strict=True)]))

    @property
    def changes(self) -> bool:
        """Tell whether there is anything to blend."""
        return self.walks[0] is not self.walks[1] or self.paces[0] != self.paces[1]

    def later(self, seconds: float) -> Handover:
        """Start the blend later."""
        walk, pace = self.walks[0], self.paces[0]
        frames = seconds / (walk.clip.frame_time * pace.time)
        gone = self.gone + frames * walk.length * pace.stride / walk.frames
        return replace(self, start=self.start + seconds, frame=self.frame + frames, gone=gone)


def choose_length(over: Handover, asked: float, room: float = 0.0) -> Length:
    """Choose the duration of a blend.

    It is the duration of K 6.2 if no joint accelerates more than in the walks; otherwise that of a few others in which
    joints accelerate least. A short blend makes joints jerk, and each duration puts another part of the stride in the
    middle of the blend. Where the walk itself jerks just there, no duration helps: then the blend starts a fraction of
    a stride later.

    Args:
        over: the walks, and where they are handed over.
        asked: [s] its duration by K 6.2.
        room: [s] available after its start, for delay and blend.
    """
    low = over.params.shortest_blend
    high = max(low, over.params.longest_blend * over.stride)
    first = float(np.clip(asked, low, high))
    if not over.changes:
        return Length(first, first)
    usual = np.max([_usual(walk, pace, over.walks[0].clip.frame_time)
                    for walk, pace in zip(over.walks, over.paces, strict=True)], axis=0)  # fmt: skip
    usual = np.maximum(usual, _FAINT * usual.max())
    tried = {first: _peak(over, first, usual)}
    for strides in _LENGTHS:
        if min(tried.values()) <= _SMOOTH:
            break
        length = float(np.clip(strides * over.stride, low, high))
        if all(abs(length - other) > _ALIKE * other for other in tried):
            tried[length] = _peak(over, length, usual, min(tried.values()))
    best = min(tried, key=lambda length: max(tried[length], _SMOOTH))
    found = Length(best, first, tried[best], tried[first])
    return found if tried[best] <= _ENOUGH else _later(over, found, tried[best], usual, (low, high), room)


def _later(
    over: Handover, found: Length, peak: float, usual: Floats, limits: tuple[float, float], room: float
) -> Length:  # fmt: skip
    """Try a blend that starts a little later; keep `found` unless joints accelerate less, see `choose_length`."""
    least = peak - _WORTH
    for strides, own in _LATER:
        dt = over.walks[0].clip.frame_time
        wait, length = round(strides * over.stride / dt) * dt, float(np.clip(own * over.stride, *limits))
        if wait + length > room:
            break
        new = _peak(over.later(wait), length, usual, least)
        if new < least:
            found, least = replace(found, seconds=length, peak=new, wait=wait), new
        if new <= _ENOUGH:
            break
    return found


def _peak(over: Handover, length: float, usual: Floats, best: float = np.inf) -> float:
    """Compute the largest acceleration of a joint in a blend of some duration [s], relative to usual ones (J,) [m/s^2].

    Where the body alone exceeds `best`, legs are not computed.
    """
    dt = over.walks[0].clip.frame_time
    rest = over.start - np.floor(over.start / dt) * dt  # frames are where they will be written
    change = Transition(0, 1, rest, rest + length, 0.0, "", length, False)
    piece = Piece(0, rest, over.frame, 0.0)
    lead = int(np.ceil(_BESIDE * over.stride / dt)) + 2
    timeline = make_timeline(over.walks, over.keys, over.paces, [change], None, lead, dt, piece)
    posed = pose(over.walks, timeline)
    skeleton, hips = posed.clip.skeleton, {leg.hip for leg in posed.rig.legs}
    body = [joint for joint in range(len(skeleton)) if not hips & set(skeleton.ancestors(joint))]

    def steepest(clip: Clip, joints: Sequence[int]) -> float:
        tracks = places(clip) if len(joints) == len(skeleton) else forward(clip, joints).positions
        return float((accelerations_of(tracks, dt)[lead - 1 : 1 - lead].max(axis=0) / usual[joints]).max())

    course = course_on(over.path, over.way, over.walks, timeline, over.params, paced=paced(over.paces), since=over.gone)
    peak = steepest(lay_body(posed, course.ground, course.lean), body)
    if peak > max(best, _SMOOTH):
        return peak
    every, laid = range(len(skeleton)), lay_figure(posed, course)[1]
    peak = steepest(laid, every)
    contacts = contacts_of(posed, slice(0, len(laid)))
    # holding plants takes time, and does not change the result where they hardly slide
    if peak > _SMOOTH or stands(laid, posed.rig, contacts, _SLACK):
        return peak
    held = held_on(laid, posed.rig, contacts, over.holding)
    return max(peak, steepest(apply(laid, held.correction), every))


def _usual(walk: Walk, pace: Pace, dt: float) -> Floats:
    """Compute the 99th percentile of each joint's acceleration in a walk, (J,) [m/s^2], sampled every `dt` seconds."""
    step = dt / (walk.clip.frame_time * pace.time)  # [frames]
    count = int(np.ceil(walk.frames / step))
    tracks = places(walk.at(np.arange(count + 2, dtype=np.float64) * step))
    # as of rounds without end, not of one: of these 1 % may be less than a frame
    return np.asarray(np.percentile(accelerations_of(tracks, dt), 99.0, axis=0, method="inverted_cdf"))
