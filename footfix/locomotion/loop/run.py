"""Make a seamless cycle from a captured walk: cut it, close it, and hold its plants."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from footfix.enforce.correction import Correction
from footfix.enforce.footplant import Footplant
from footfix.enforce.params import EnforceParams
from footfix.locomotion.loop.closing import Closed, close
from footfix.locomotion.loop.cut_search import Cut, calmer
from footfix.locomotion.loop.cyclic_contacts import wrapped
from footfix.locomotion.loop.cyclic_enforcement import ground_under, hold
from footfix.locomotion.loop.existing_cycle import closed_travel, completed, put_to_rest
from footfix.locomotion.loop.one_stride import cuts_of
from footfix.locomotion.loop.params import LoopParams
from footfix.locomotion.loop.residual_slide import settled
from footfix.locomotion.loop.root_motion import (
    Travel,
    carrier,
    put_in,
    root_in_world,
    straightened,
    taken_out,
    with_root,
    without_drift,
)
from footfix.locomotion.loop.seam import Seam, apart, changes, ratios, slide
from footfix.locomotion.loop.strides import count_strides
from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats, Ints, frozen
from footfix.motion.contacts import Contacts
from footfix.notes import Note
from footfix.rig.rig import Rig

_OTHERS, _APART = 3, 0.2  # number of next best cuts reported, and the least difference of their ends in rounds
_NEARLY, _TRIED = 0.03, 5  # [leg lengths] cuts at most this much worse than the best are closed, too; at most 5
_SEEN = 0.025  # [leg lengths] penalty for each multiple of its usual acceleration that a joint has at the seam
_JOLT, _USUAL = 1.5, 1.0  # greatest acceleration ratios of a good seam: of the worst joint, and of the median
_HELD = 3  # most cuts whose plants are held in search of a good seam
_SLIDES = 0.002  # [leg lengths] slide across the seam from which the feet of an existing loop are held
_SPOT = 0.2  # [leg lengths] a walk with less travel is on the spot, where feet slide on purpose
_TURNS = 1e-6  # [rad] turn of a round from which it is straightened


@dataclass(frozen=True, eq=False)
class Loop:
    """A seamless cycle.

    Args:
        clip: as written: closed (the last frame is the first, moved by one round), or without the last frame, or on the
            spot, as requested.
        round: L + 1 frames: the same, closed and with its travel.
        captured: L + 1 frames of the source clip.
        closed: the same after closing, before plants were held.
        rig: legs, soles, scale and floor.
        contacts: of `round`.
        start, end: the frames of the captured clip that became the first and the last one.
        frames: (n,) the captured frame that each frame of `clip` was.
        strides: number of strides.
        travel: of one round, over the floor; its `yaw` is the turn.
        seam: measures of the seam.
        plants, correction, notes, ground: result of holding the closed cycle's plants (`enforce.Enforcement`).
        others: the next best cuts.
    """

    clip: Clip
    round: Clip
    captured: Clip
    closed: Clip
    rig: Rig
    contacts: Contacts
    start: int
    end: int
    frames: Ints
    strides: int
    travel: Travel
    seam: Seam
    plants: tuple[Footplant, ...]
    correction: Correction
    notes: tuple[Note, ...]
    ground: Floats
    others: tuple[Cut, ...] = ()

    def counted_from(self, first: int) -> Loop:
        """Renumber frames for a longer clip, in which the source clip begins at a frame."""
        others = tuple(replace(cut, start=cut.start + first, end=cut.end + first) for cut in self.others)
        start, end = self.start + first, self.end + first
        return replace(self, start=start, end=end, frames=frozen(self.frames + first, np.intp), others=others)

    @property
    def seconds(self) -> float:
        """Get the duration of one round [s]."""
        return (len(self.round) - 1) * self.round.frame_time

    @property
    def turn(self) -> float:
        """Get the turn of a round [rad], to the left."""
        return self.travel.yaw

    @property
    def travel_of_root(self) -> tuple[float, float]:
        """Compute the root's shift (x, z) [m] in one round."""
        place = root_in_world(self.round.frames(np.array([0, len(self.round) - 1])), carrier(self.round, self.rig))[0]
        return float(place[1, 0] - place[0, 0]), float(place[1, 2] - place[0, 2])

    @property
    def distance(self) -> float:
        """Compute the root's distance in one round along its arc [m]."""
        place = root_in_world(self.round.frames(slice(0, 1)), carrier(self.round, self.rig))[0][0]
        straight = self.travel.about(place).straight()
        return float(np.hypot(straight.x, straight.z))

    @property
    def speed(self) -> float:
        """Compute the speed over the floor [m/s]."""
        return self.distance / self.seconds


def make_loop(clip: Clip, rig: Rig, contacts: Contacts, params: LoopParams, holding: EnforceParams) -> Loop:
    """Cut a cycle out of a clip, close it, and hold its planted feet, also across the seam.

    Args:
        clip: F frames, metres, y up, all of them motion.
        rig: its legs, soles and floor.
        contacts: when each sole point is planted; the effectors in the order of `rig.soles`.
        params: which cycle, and how it is closed and written.
        holding: how footplants are enforced.

    Raises:
        InputError: the clip contains no cycle, or not the requested one.
    """
    known = _known(clip, rig, contacts, params, holding)
    if known is not None:
        return known
    whole, cuts = cuts_of(clip, rig, contacts, params)
    made: list[Loop] = []
    for cut, closed in _calmest(whole, rig, cuts, params)[:_HELD]:
        made.append(_held(whole, rig, contacts, cut, closed, params, holding, len(clip)))
        if _seen(made[-1].seam) <= 1.0:
            break
    best = min(made, key=lambda loop: _seen(loop.seam))
    return replace(best, others=tuple(cut for cut in cuts if not _same(cut, best))[:_OTHERS])


def _seen(seam: Seam) -> float:
    """Rate how visible a seam is, 1 being good: by the joint with the largest jerk, and by all joints."""
    return max(seam.worst_ratio / _JOLT, seam.median_ratio / _USUAL)


def _held(
    clip: Clip, rig: Rig, contacts: Contacts, cut: Cut, closed: Closed, params: LoopParams, holding: EnforceParams,
    frames: int,
) -> Loop:  # fmt: skip
    """Make the loop of a closed cut by holding its plants; `frames` is the length of the captured clip."""
    length = cut.end - cut.start
    captured = clip.frames(slice(closed.start, closed.start + length + 1))
    within = wrapped(contacts, closed.start, length)
    start, travel = closed.clip, closed.travel
    if _on_belt(closed, rig, within, holding):
        start, travel = without_drift(start, carrier(start, rig), travel), Travel()
    gap = apart(clip, rig, cut.start, cut.end, travel)
    moved = changes(captured, start, rig)
    if params.straighten:
        start, travel = straightened(start, carrier(start, rig), travel)
    held = hold(start, rig, within, travel, holding)
    done = settled(held.clip, rig, held.found.plants, travel, held.found.ground)
    far = slide(done, rig, held.found.plants, travel, held.found.ground)
    return Loop(
        clip=as_written(done, rig, travel, params), round=done, captured=captured, closed=start, rig=rig,
        contacts=within, start=closed.start, end=closed.start + length,
        frames=_frames(closed.start, length, frames, params), strides=cut.strides or count_strides(within, rig),
        travel=travel, seam=_seam(gap, moved, done, rig, travel, far), plants=held.found.plants,
        correction=held.found.correction, notes=held.found.notes, ground=held.found.ground,
    )  # fmt: skip


def _on_belt(closed: Closed, rig: Rig, contacts: Contacts, holding: EnforceParams) -> bool:
    """Tell whether a closed cycle is on a belt: the ground carries planted feet, and the figure stays in place."""
    place = root_in_world(closed.clip.frames(slice(0, 1)), carrier(closed.clip, rig))[0][0]
    if np.linalg.norm(closed.travel.places(place) - place) > _SPOT * rig.leg_length:
        return False
    return bool(np.any(ground_under(closed.clip, rig, contacts, closed.travel, holding.ground)))


def _same(cut: Cut, loop: Loop) -> bool:
    """Tell whether a cut is nearly the same as that of a loop."""
    return abs(cut.start - loop.start) + abs(cut.end - loop.end) <= _APART * (loop.end - loop.start)


def _calmest(
    clip: Clip, rig: Rig, cuts: Sequence[Cut], params: LoopParams
) -> tuple[tuple[Cut, Closed], ...]:  # fmt: skip
    """Close the best cuts, and order them by the visibility of their seams."""
    best, near = cuts[0], _NEARLY * rig.leg_length
    tried = [c for c in cuts[1:] if c.strides == best.strides and c.cost <= best.cost + near]
    found = []
    for cut in (best, *tried[: _TRIED - 1]):
        calm = calmer(clip, rig, cut, params)
        closed = close(clip, rig, calm, params)
        seen = max(closed.worst_ratio - 1.0, 0.0)
        found.append((calm.cost + _SEEN * rig.leg_length * seen, calm, closed))
    return tuple((cut, closed) for _, cut, closed in sorted(found, key=lambda each: each[0]))


def _known(clip: Clip, rig: Rig, contacts: Contacts, params: LoopParams, holding: EnforceParams) -> Loop | None:
    """Make a loop of a clip that is one already, unless another part is requested; hold its feet if they slide."""
    if params.start is not None or params.end is not None:
        return None
    whole: Clip | None = clip
    travel = closed_travel(clip, rig)
    if travel is None:
        whole = completed(clip, rig, held=put_to_rest(clip, rig, contacts)) if params.open else None
        travel = None if whole is None else closed_travel(whole, rig)
    if whole is None or travel is None:
        return None
    length = len(whole) - 1
    within = wrapped(contacts, 0, length)
    strides = count_strides(within, rig)
    if params.strides not in (None, strides):
        return None
    ground = ground_under(whole, rig, within, travel, holding.ground)
    found = _as_it_is(clip, whole, rig, within, travel, ground, params)
    far, spot = found.seam.slide_mm, found.distance < _SPOT * rig.leg_length
    if far is None or far <= _SLIDES * 1000.0 * rig.leg_length or spot or put_to_rest(whole, rig, within):
        return found
    cut, closed = Cut(0, length, -1, strides, 0, 0.0), Closed(whole, 0, travel, found.seam.worst_ratio)
    return _held(whole, rig, contacts, cut, closed, params, holding, len(clip))


def _as_it_is(
    clip: Clip, whole: Clip, rig: Rig, within: Contacts, travel: Travel, ground: Floats, params: LoopParams
) -> Loop:
    """Make a loop without changes, except to its travel."""
    captured, length = whole, len(whole) - 1
    plants = _kept(within, rig)
    far = slide(whole, rig, plants, travel, ground)
    if params.straighten and abs(travel.yaw) > _TURNS:
        whole, travel = straightened(whole, carrier(whole, rig), travel)
    still = Correction(rig.root, np.zeros((length + 1, 3)), (), np.zeros((length + 1, 0, 4)))
    text = "the clip is a loop already: it is neither cut nor cleaned (footfix clean takes out what slides in it)"
    same = whole is captured and not params.in_place and len(clip) == length + (not params.open)
    return Loop(
        clip=clip if same else as_written(whole, rig, travel, params), round=whole, captured=captured, closed=whole,
        rig=rig, contacts=within, start=0, end=length, frames=_frames(0, length, len(clip), params),
        strides=count_strides(within, rig), travel=travel, seam=_seam((0.0, 0.0), (0.0, 0.0), whole, rig, travel, far),
        plants=plants, correction=still, notes=(Note("loop-already", text),), ground=ground,
    )  # fmt: skip


def _kept(contacts: Contacts, rig: Rig) -> tuple[Footplant, ...]:
    """List the plants of an unchanged loop."""
    found: list[Footplant] = []
    for e, (sole, effector) in enumerate(zip(rig.soles, contacts.effectors, strict=True)):
        for c in effector.contacts:
            if c.wish != "forbid":
                plain = Footplant(len(found), e, sole.name, sole.leg, sole.part, c.start, c.end, c.confidence)
                found.append(replace(plain, held=((c.start, c.end),)))
    return tuple(found)


def _frames(start: int, length: int, frames: int, params: LoopParams) -> Ints:
    """List the source frames of a loop; the first frame replaces a missing last one."""
    return frozen((start + np.arange(length + (not params.open))) % frames, np.intp)


def _seam(
    gap: tuple[float, float], moved: tuple[float, float], clip: Clip, rig: Rig, travel: Travel, far: float | None
) -> Seam:  # fmt: skip
    """Make the measures of a seam from sizes in [m] and [rad]."""
    (gap_m, gap_rad), (moved_m, moved_rad) = gap, moved
    return Seam(
        1000.0 * gap_m, float(np.degrees(gap_rad)), 1000.0 * moved_m, float(np.degrees(moved_rad)),
        *ratios(clip, rig, travel), slide_mm=None if far is None else 1000.0 * far,
    )  # fmt: skip


def as_written(cycle: Clip, rig: Rig, travel: Travel, params: LoopParams) -> Clip:
    """Convert a closed cycle for writing: on the spot, or without its last frame, as requested."""
    if params.in_place:
        cycle = taken_out(cycle, carrier(cycle, rig), travel)
    return cycle.frames(slice(0, len(cycle) - 1)) if params.open else cycle


def as_round(written: Clip, rig: Rig, travel: Travel, params: LoopParams) -> Clip:
    """Restore the closed cycle with its travel from a written loop: undoes `as_written`."""
    if params.open:
        written = written.frames(np.append(np.arange(len(written)), 0))
        if not params.in_place:
            root = carrier(written, rig)
            place, turn = (np.array(each, order="F") for each in root_in_world(written, root))
            place[-1], turn[-1] = travel.places(place[0]), rotation.multiply(travel.turn, turn[0])
            written = with_root(written, root, place, turn)
    return put_in(written, carrier(written, rig), travel) if params.in_place else written
