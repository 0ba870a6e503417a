"""A straight loop prepared for a path: on the spot, walking along z, sampled at any time of its round."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from footfix.errors import InputError
from footfix.locomotion.loop.root_motion import Travel, carrier, root_in_world, taken_out, with_root
from footfix.locomotion.loop.run import Loop
from footfix.locomotion.loop.strides import stances
from footfix.motion import rotation
from footfix.motion.clip import Bools, Clip, Floats, Ints
from footfix.motion.contacts import Contacts
from footfix.motion.kinematics import forward
from footfix.motion.spline import Cubic, spline
from footfix.motion.vectors import norm
from footfix.rig.rig import Rig

_MARGIN = 12  # frames before and after a round that interpolation uses
_SAME_BONES = 2e-3  # [leg lengths] greatest difference of offsets in equal skeletons
_ON_THE_SPOT = 0.1  # [leg lengths] greatest travel of a round in place
_STILL = 1e-3  # [m/s^2] least usual acceleration, to avoid division by zero
_NEAR = 1e-9  # of a frame


@dataclass(frozen=True, eq=False)
class Walk:
    """A closed, straight cycle in the frame of its travel.

    Args:
        name: for messages.
        clip: L + 1 frames on the spot: the pelvis' mean lies over the origin, its travel was along z.
        rig: its legs; the floor as `clip` has it.
        contacts: of the L + 1 frames.
        strides: of one round.
        length: [m] travel of one round.
        start: where its reference line starts: (x, z) [m] in the captured clip, with its heading [rad].
        loop: from which it was made.
    """

    name: str
    clip: Clip
    rig: Rig
    contacts: Contacts
    strides: int
    length: float
    start: tuple[float, float, float]
    loop: Loop

    @property
    def frames(self) -> int:
        """Count the frames L of one round."""
        return len(self.clip) - 1

    @property
    def seconds(self) -> float:
        """Get the duration of one round [s]."""
        return self.frames * self.clip.frame_time

    @property
    def speed(self) -> float:
        """Get the captured speed [m/s]."""
        return self.length / self.seconds

    @property
    def stride_seconds(self) -> float:
        """Get the duration of a stride [s]."""
        return self.seconds / self.strides

    @cached_property
    def root(self) -> int:
        """Get the joint that carries the figure."""
        return carrier(self.clip, self.rig)

    @cached_property
    def body(self) -> int | None:
        """Get the joint that places the body below the root, as in game engines; None without one."""
        able = self.clip.skeleton.translates & self.clip.skeleton.rotates
        below = [joint for joint in (self.rig.root, self.rig.pelvis) if joint != self.root and able[joint]]
        return below[0] if below else None

    @cached_property
    def height(self) -> float:
        """Compute the mean height of the pelvis over the floor [m]."""
        return float(pelvis_of(self.clip, self.rig)[:-1, 1].mean()) - self.rig.floor

    @cached_property
    def reach(self) -> Floats:
        """Compute the greatest distance from hip to ankle of each leg, (legs,) [m]."""
        seen = forward(self.clip, [joint for leg in self.rig.legs for joint in (leg.hip, leg.ankle)])
        return np.array([norm(seen.position(leg.ankle) - seen.position(leg.hip)).max() for leg in self.rig.legs])

    @cached_property
    def jolts(self) -> Floats:
        """Compute the 99th percentile of accelerations of knee, ankle and toe of each leg, (legs, 3) [m/s^2]."""
        round_ = self.clip.frames(np.arange(-1, self.frames + 1) % self.frames)
        seen = self.rig.pose(round_)
        ends = zip(self.rig.soles, self.rig.held(seen), strict=True)
        toes = {sole.leg: track for sole, track in ends if sole.part == "toe"}
        tracks = [[seen.position(leg.knee), seen.position(leg.ankle), toes[k]] for k, leg in enumerate(self.rig.legs)]
        second = norm(np.diff(np.array(tracks), n=2, axis=2)) / self.clip.frame_time**2
        return np.asarray(np.maximum(np.percentile(second, 99.0, axis=2), _STILL))

    def at(self, frames: Floats, joints: tuple[int, ...] | None = None) -> Clip:
        """Sample the cycle on the spot at times (F,) [frames] of any round; exact at whole frames.

        Between frames it interpolates by cubic splines; rotations through their quaternions.

        Args:
            frames: (F,) moments.
            joints: which of them matter; others may be as in the first frame. None for all.
        """
        near = np.rint(frames)
        if np.all(np.abs(frames - near) <= _NEAR):
            return self.clip.frames(near.astype(np.intp) % self.frames)
        within = frames - np.floor(frames / self.frames) * self.frames
        every, still = range(len(self.clip.skeleton)), len(within)
        places = [np.broadcast_to(self.clip.position(joint)[:1], (still, 3)) for joint in every]
        turns = [np.broadcast_to(self.clip.rotation(joint)[:1], (still, 4)) for joint in every]
        if joints not in self._curves:
            self._curves[joints] = self._curve_of(every if joints is None else joints)
        moved, turned, curve = self._curves[joints]
        found = curve(within).T  # by components: a column is one stretch of memory
        for k, joint in enumerate(moved):
            places[joint] = found[3 * k : 3 * k + 3].T
        found = found[3 * len(moved) :]
        for k, joint in enumerate(turned):
            turns[joint] = rotation.normalize(found[4 * k : 4 * k + 4].T)
        return Clip.from_tracks(self.clip.skeleton, places, turns, self.clip.frame_time)

    @cached_property
    def _curves(self) -> dict[tuple[int, ...] | None, tuple[tuple[int, ...], tuple[int, ...], Cubic]]:
        """Keep what `_curve_of` has found so far."""
        return {}

    def _curve_of(self, joints: Sequence[int]) -> tuple[tuple[int, ...], tuple[int, ...], Cubic]:
        """Find the joints that move in their parents' frames and those that turn, and fit one curve to all of them."""
        count: Ints = np.arange(-_MARGIN, self.frames + _MARGIN + 1)
        tracks = list[Floats]()
        moved = tuple(joint for joint in joints if np.ptp(self.clip.position(joint), axis=0).any())
        turned = tuple(joint for joint in joints if np.ptp(self.clip.rotation(joint), axis=0).any())
        for joint in moved:
            tracks.append(self.clip.position(joint)[count % self.frames])
        for joint in turned:
            tracks.append(rotation.continuous(self.clip.rotation(joint)[count % self.frames]))
        around = np.concatenate(tracks, axis=1) if tracks else np.zeros((len(count), 0))
        return moved, turned, spline(count.astype(np.float64), around)

    def planted(self, frames: Floats) -> Bools:
        """Tell which sole points are planted at moments (F,), (F, E)."""
        return np.asarray(self.contacts.mask()[np.rint(frames).astype(np.intp) % self.frames])

    def sure(self, frames: Floats) -> Floats:
        """Get the confidence of contacts at moments (F,), (F, E)."""
        out = np.ones((self.frames + 1, len(self.contacts.effectors)))
        for e, effector in enumerate(self.contacts.effectors):
            for contact in effector.contacts:
                out[contact.start : contact.end, e] = contact.confidence
        return np.asarray(out[np.rint(frames).astype(np.intp) % self.frames])

    def strikes(self, leg: int) -> tuple[Ints, Ints]:
        """List the frames of one round, in order, at which a leg strikes, and at which it lifts after each strike."""
        length = self.frames
        down = stances(_three(self.contacts), self.rig, leg)
        found = [(a, b) for a, b in down if length <= a < 2 * length]
        return np.array([a for a, _ in found], np.intp) - length, np.array([b for _, b in found], np.intp) - length


def _three(contacts: Contacts) -> Contacts:
    """Get the contacts of three rounds; one that continues across a seam is a single contact."""
    mask = np.concatenate([contacts.mask()[:-1]] * 3)
    return replace(contacts, frames=len(mask)).with_mask(mask)


def make_walk(loop: Loop, name: str) -> Walk:
    """Lay a straight loop so that it walks along z.

    Args:
        loop: straight on, `loop.straighten`.
        name: for messages.

    Raises:
        InputError: it does not travel and is not on a belt, or it walks in a circle.
    """
    clip, rig = loop.round, loop.rig
    laps = round(_turned(clip, rig) / (2.0 * np.pi))
    if laps:
        raise InputError(
            f"it goes round, not straight on: its cycle, frames {loop.start} to {loop.end}, turns by "
            f"{abs(laps) * 360} degrees", file=name,
            hint="`footfix loop` with --start and --end cuts out a part that goes straight on",
        )  # fmt: skip
    root = carrier(clip, rig)
    travel, spot = loop.travel, taken_out(clip, root, loop.travel)
    if np.hypot(travel.x, travel.z) < _ON_THE_SPOT * rig.leg_length:
        travel = _off_the_belt(loop)
    far = float(np.hypot(travel.x, travel.z))
    if far < _ON_THE_SPOT * rig.leg_length:
        raise InputError(
            f"it goes nowhere: one round gets {far:.2f} m on, and planted feet do not go back evenly as on a belt",
            file=name, hint="a walk that travels, or one in place on a belt, can be led along a path",
        )  # fmt: skip
    heading = float(np.arctan2(travel.x, travel.z))
    middle = pelvis_of(spot, rig)[:-1].mean(axis=0)
    # the reference line goes through the pelvis' mean on the spot; its first frame is where the line starts
    back = Travel(-heading)
    x, _, z = -back.places(middle)
    there = Travel(-heading, float(x), float(z))
    position, turn = root_in_world(spot, root)
    laid = with_root(spot, root, there.places(position), rotation.multiply(there.turn, turn))
    return Walk(
        name, _exactly_closed(laid), rig, loop.contacts, max(loop.strides, 1), far,
        (float(middle[0]), float(middle[2]), heading), loop,
    )  # fmt: skip


def _turned(clip: Clip, rig: Rig) -> float:
    """Compute the turn of the pelvis from the first frame to the last, including whole turns [rad]."""
    turn = forward(clip, [rig.pelvis]).rotation(rig.pelvis)
    yaw = np.unwrap(rotation.yaw(rotation.multiply(turn, rotation.inverse(turn[0]))))
    return float(yaw[-1] - yaw[0])


def _off_the_belt(loop: Loop) -> Travel:
    """Compute the travel of a walk in place: opposite to the motion of its planted feet."""
    x, _, z = loop.ground[0] - loop.ground[-1]
    return Travel(0.0, float(x), float(z))


def pelvis_of(clip: Clip, rig: Rig) -> Floats:
    """Track (F, 3) [m] the pelvis in the world."""
    return forward(clip, [rig.pelvis]).position(rig.pelvis)


def _exactly_closed(clip: Clip) -> Clip:
    return clip.frames(np.append(np.arange(len(clip) - 1), 0))


def check_alike(walks: Sequence[Walk]) -> None:
    """Check that walks have the same skeleton, by names and offsets.

    Raises:
        InputError: they do not; the message gives the first difference.
    """
    first = walks[0]
    for other in walks[1:]:
        if other.loop is not first.loop:
            found = _difference(first, other)
            if found:
                raise InputError(
                    f"its skeleton is not that of {first.name}: {found}", file=other.name,
                    hint="walks that are handed over need one skeleton, the same joints and offsets",
                )  # fmt: skip


def _difference(one: Walk, other: Walk) -> str:
    a, b = one.clip.skeleton, other.clip.skeleton
    for k, (name, theirs) in enumerate(zip(a.names, b.names, strict=False)):
        if name != theirs:
            return f"joint {k + 1} is {theirs!r}, not {name!r}"
        if a.parents[k] != b.parents[k]:
            above = [each.names[int(each.parents[k])] if each.parents[k] >= 0 else "nothing" for each in (b, a)]
            return f"{name!r} hangs from {above[0]!r}, not from {above[1]!r}"
        off = float(np.linalg.norm(a.offsets[k] - b.offsets[k]))
        if a.parents[k] >= 0 and not a.translates[k] and off > _SAME_BONES * one.rig.leg_length:
            return f"the offset of {name!r} differs by {1000.0 * off:.0f} mm"
    if len(a) != len(b):
        return f"it has {len(b)} joints, not {len(a)}"
    return ""


def on_one_floor(walks: Sequence[Walk]) -> tuple[Walk, ...]:
    """Raise or lower walks to the floor of the first one, with its rig, so that they can be blended."""
    first = walks[0]
    out: list[Walk] = []
    for walk in walks:
        known = next((each for each in out if each.loop is walk.loop), None)
        up = first.rig.floor - walk.rig.floor
        clip = walk.clip
        if up:
            position, turn = root_in_world(clip, walk.root)
            clip = with_root(clip, walk.root, position + [0.0, up, 0.0], turn)
        out.append(known or replace(walk, clip=clip, rig=first.rig))
    return tuple(out)
