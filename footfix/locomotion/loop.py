"""A seamless cycle out of a captured walk: cut, closed, and cleaned as a cycle."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from footfix.enforce.correction import Correction
from footfix.enforce.footplant import Footplant
from footfix.enforce.run import EnforceParams
from footfix.errors import InputError
from footfix.locomotion.closing import close
from footfix.locomotion.cuts import Cut, find_cuts
from footfix.locomotion.known import closed_travel, completed, whole_cycle
from footfix.locomotion.params import LoopParams
from footfix.locomotion.rounds import hold
from footfix.locomotion.seam import Seam, apart, changes, ratios, slide
from footfix.locomotion.strides import count_strides
from footfix.locomotion.travel import Travel, carrier, root_in_world, straightened, taken_out
from footfix.locomotion.wrapped import wrapped
from footfix.motion.clip import Clip, Floats
from footfix.motion.contacts import Contacts
from footfix.notes import Note
from footfix.rig.rig import Rig

_OTHERS = 3  # next best cuts that are told
_TURNS = 1e-6  # [rad] of a round, from which on there is something to straighten


@dataclass(frozen=True, eq=False)
class Loop:
    """A seamless cycle.

    Args:
        clip: as it is to be written: closed (the last frame is the first, moved on by one round), or without the last
            frame where that was asked for; on the spot where that was.
        round: L + 1 frames: the same closed and with its travel.
        captured: L + 1 frames of the clip that it was cut from.
        rig: legs, soles, scale and floor.
        contacts: of `round`.
        start, end: the frames of the clip that became the first and the last one.
        strides: how many it has.
        travel: of one round, over the floor; its `yaw` is the turn.
        seam: what was joined, and what became of it.
        plants, correction, notes, ground: what cleaning did to the closed cycle (`enforce.Enforcement`).
        others: the next best cuts.
    """

    clip: Clip
    round: Clip
    captured: Clip
    rig: Rig
    contacts: Contacts
    start: int
    end: int
    strides: int
    travel: Travel
    seam: Seam
    plants: tuple[Footplant, ...]
    correction: Correction
    notes: tuple[Note, ...]
    ground: Floats
    others: tuple[Cut, ...] = ()

    @property
    def seconds(self) -> float:
        """[s] of one round."""
        return (len(self.round) - 1) * self.round.frame_time

    @property
    def turn(self) -> float:
        """[rad] by which a round turns the figure, to the left."""
        return self.travel.yaw

    @property
    def distance(self) -> float:
        """[m] that the root goes in one round, along the arc."""
        place = root_in_world(self.round.frames(slice(0, 1)), carrier(self.round, self.rig))[0][0]
        straight = self.travel.about(place).straight()
        return float(np.hypot(straight.x, straight.z))

    @property
    def speed(self) -> float:
        """[m/s] over the floor."""
        return self.distance / self.seconds


def make_loop(clip: Clip, rig: Rig, contacts: Contacts, params: LoopParams, holding: EnforceParams) -> Loop:
    """Cut a cycle out of a clip, close it, and hold its feet where they are planted, over the seam too.

    Args:
        clip: F frames, metres, y up, all of them motion.
        rig: its legs, soles and floor.
        contacts: when each sole point is planted; the effectors in the order of `rig.soles`.
        params: which cycle, and how it is closed and written.
        holding: how footplants are enforced.

    Raises:
        InputError: the clip holds no cycle, or not the one that is asked for.
    """
    known = _known(clip, rig, contacts, params)
    if known is not None:
        return known
    clip, (cut, *others) = _cut(clip, rig, contacts, params)
    closed = close(clip, rig, cut, params)
    length = cut.end - cut.start
    captured = clip.frames(slice(closed.start, closed.start + length + 1))
    gap = apart(clip, rig, cut.start, cut.end, closed.travel)
    moved = changes(captured, closed.clip, rig)
    start, travel = closed.clip, closed.travel
    if params.straighten:
        start, travel = straightened(start, carrier(start, rig), travel)
    within = wrapped(contacts, closed.start, length)
    held = hold(start, rig, within, travel, holding)
    done = held.clip
    found = ratios(done, rig, travel)
    far = slide(done, rig, held.found.plants, travel)
    seam = Seam(
        *_told(gap), *_told(moved), *found, slide_mm=None if far is None else 1000.0 * far
    )  # fmt: skip
    return Loop(
        clip=_written(done, rig, travel, params), round=done, captured=captured, rig=rig, contacts=within,
        start=closed.start, end=closed.start + length, strides=cut.strides, travel=travel, seam=seam,
        plants=held.found.plants, correction=held.found.correction, notes=held.found.notes, ground=held.found.ground,
        others=tuple(others[:_OTHERS]),
    )  # fmt: skip


def _cut(clip: Clip, rig: Rig, contacts: Contacts, params: LoopParams) -> tuple[Clip, tuple[Cut, ...]]:
    """The cuts of a clip; the whole of one that is hardly more than a round, with the frame that it may lack."""
    try:
        return clip, find_cuts(clip, rig, contacts, params)
    except InputError:
        whole = whole_cycle(clip, rig) if params.start is None and params.end is None else None
        if whole is None:
            raise
        strides = count_strides(wrapped(contacts, 0, len(whole) - 1), rig)
        if params.strides not in (None, strides):
            raise
        return whole, (Cut(0, len(whole) - 1, -1, strides, 0, 0.0),)


def _known(clip: Clip, rig: Rig, contacts: Contacts, params: LoopParams) -> Loop | None:
    """The loop that a clip is already, unless another part of it is asked for."""
    if params.start is not None or params.end is not None:
        return None
    whole: Clip | None = clip
    travel = closed_travel(clip, rig)
    if travel is None:
        whole = completed(clip, rig) if params.open else None
        travel = None if whole is None else closed_travel(whole, rig)
    if whole is None or travel is None:
        return None
    length = len(whole) - 1
    within = wrapped(contacts, 0, length)
    strides = count_strides(within, rig)
    return None if params.strides not in (None, strides) else _as_it_is(clip, whole, rig, within, travel, params)


def _as_it_is(clip: Clip, whole: Clip, rig: Rig, within: Contacts, travel: Travel, params: LoopParams) -> Loop:
    """A loop to which nothing is done but what of its travel is to be changed."""
    captured, length = whole, len(whole) - 1
    if params.straighten and abs(travel.yaw) > _TURNS:
        whole, travel = straightened(whole, carrier(whole, rig), travel)
    seam = Seam(0.0, 0.0, 0.0, 0.0, *ratios(whole, rig, travel))
    still = Correction(rig.root, np.zeros((length + 1, 3)), (), np.zeros((length + 1, 0, 4)))
    text = "the clip is a loop already: it is neither cut nor cleaned (footfix clean takes out what slides in it)"
    same = whole is captured and not params.in_place and len(clip) == length + (not params.open)
    return Loop(
        clip=clip if same else _written(whole, rig, travel, params), round=whole, captured=captured, rig=rig,
        contacts=within, start=0, end=length, strides=count_strides(within, rig), travel=travel, seam=seam, plants=(),
        correction=still, notes=(Note("loop-already", text),), ground=np.zeros((length + 1, 3)),
    )  # fmt: skip


def _told(size: tuple[float, float]) -> tuple[float, float]:
    """[mm] and [degrees] of [m] and [rad]."""
    return 1000.0 * size[0], float(np.degrees(size[1]))


def _written(done: Clip, rig: Rig, travel: Travel, params: LoopParams) -> Clip:
    """The cycle as it is to be written."""
    if params.in_place:
        done = taken_out(done, carrier(done, rig), travel)
    return done.frames(slice(0, len(done) - 1)) if params.open else done
