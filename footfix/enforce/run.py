"""Enforcement: contacts in, footplants and a correction out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from footfix.enforce import ground, outcomes, root
from footfix.enforce.aims import aimed, judged, levelled
from footfix.enforce.cleaned import as_rows, easily, set_aside
from footfix.enforce.correction import Correction
from footfix.enforce.course import courses
from footfix.enforce.ease import EaseParams
from footfix.enforce.foot import Foot, can_turn, feet, posed
from footfix.enforce.footplant import Footplant
from footfix.enforce.ground import GroundParams
from footfix.enforce.judge import JudgeParams
from footfix.enforce.legs import Held, enforced
from footfix.enforce.plants import Plant, PlantParams, Stance, exact, lying, stances, where_it_was
from footfix.enforce.reach import ReachParams
from footfix.enforce.root import RootParams
from footfix.enforce.solve import LegParams
from footfix.enforce.steady import SteadyParams, steadied
from footfix.enforce.style import StyleParams, styled
from footfix.enforce.swivel import swivelled
from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats
from footfix.motion.contacts import Contacts
from footfix.motion.kinematics import Pose
from footfix.motion.leadin import motion_proper
from footfix.motion.vectors import norm
from footfix.notes import Note
from footfix.rig.rig import Rig

_REST = 1e-3  # [rad] root mean square over the joints: frames that differ by less are the same pose
_JUMP = 0.01  # leg lengths from frame to frame: legs that go no farther don't jump


@dataclass(frozen=True, kw_only=True)
class EnforceParams:
    """How footplants are enforced."""

    method: Literal["ik", "root", "both"] = "ik"  # the legs, the root's translation alone, or shared between them
    solver: Literal["closed", "priorities"] = "closed"  # two bones in closed form; or every joint that bends
    again: bool = False  # whether stands that a program has put to rest already are looked at again
    strength: float = 1.0  # 0 to 1: how much of the correction is applied
    steady: SteadyParams = field(default_factory=SteadyParams)
    plants: PlantParams = field(default_factory=PlantParams)
    ground: GroundParams = field(default_factory=GroundParams)
    ease: EaseParams = field(default_factory=EaseParams)
    reach: ReachParams = field(default_factory=ReachParams)
    judge: JudgeParams = field(default_factory=JudgeParams)
    root: RootParams = field(default_factory=RootParams)
    style: StyleParams = field(default_factory=StyleParams)


@dataclass(frozen=True, eq=False)
class Enforcement:
    """What enforcement yields.

    Args:
        plants: every contact, where it was to stand and what became of it.
        correction: what is to change in the clip.
        notes: what a person should know.
        contacts: the contacts without the frames at their edges in which the foot is still landing or gone.
        ground: (F, 3) [m] how far the ground under planted feet has moved on purpose, as on a treadmill.
    """

    plants: tuple[Footplant, ...]
    correction: Correction
    notes: tuple[Note, ...]
    contacts: Contacts
    ground: Floats


def enforce(clip: Clip, rig: Rig, contacts: Contacts, params: EnforceParams) -> Enforcement:
    """Hold the plants of a clip where they are planted.

    Args:
        clip: F frames, metres, y up.
        rig: its legs, soles and floor.
        contacts: when each sole point is planted; the effectors in the order of `rig.soles`.
        params: method and measures.

    Returns:
        The footplants, the correction, and notes. A clip that needs nothing gets a correction of zeros.
    """
    proper = _where_legs_jump(clip, rig, motion_proper(clip))
    if (proper.start, proper.stop) != (0, len(clip)):
        return _within(clip, rig, contacts, params, proper)
    return _on(clip, rig, contacts, params)


def _where_legs_jump(clip: Clip, rig: Rig, proper: slice) -> slice:
    """The motion proper, and with it frames before and after it from which only other joints than the legs' jump."""

    def goes_on(frame: int) -> bool:  # from the frame before
        pose = posed(clip.frames(slice(frame - 1, frame + 1)), rig)
        places = np.stack([pose.position(joint) for leg in rig.legs for joint in (leg.hip, leg.knee, leg.ankle)])
        return float(norm(places[:, 1] - places[:, 0]).max()) <= _JUMP * rig.leg_length

    start, stop = proper.start, proper.stop
    while start > 0 and goes_on(start):
        start -= 1
    while stop < len(clip) and goes_on(stop):
        stop += 1
    return slice(start, stop)


def _on(clip: Clip, rig: Rig, contacts: Contacts, params: EnforceParams) -> Enforcement:
    """Enforcement of a clip that is all motion; legs that shake are steadied first."""
    pose = posed(clip, rig)
    legs = feet(rig, pose)
    if params.method == "root":
        return _held(clip, pose, legs, rig, contacts, params)
    calm, joints, notes = steadied(clip, rig, legs, params.strength, params.steady)
    if not joints:
        return _held(clip, pose, legs, rig, contacts, params)
    pose = posed(calm, rig)
    found = _held(calm, pose, feet(rig, pose), rig, contacts, params)
    correction = found.correction.with_turns(calm, joints)
    return replace(found, correction=correction, notes=(*notes, *found.notes))


@dataclass(frozen=True, eq=False)
class _Set:
    """What is to stand where, before anything holds it.

    Args:
        legs: their tracks, on the floor's own ground.
        contacts: those of feet that swivel cut.
        stands: the stances with their targets, among them those that are let go already.
        ride, rise: (F, 3) and (3,) [m] what takes the ground's own motion, and a common error of height, out.
        cleaned: whether the clip was cleaned before.
        notes: what a person should know.
    """

    legs: tuple[Foot, ...]
    contacts: Contacts
    stands: list[Stance]
    ride: Floats
    rise: Floats
    cleaned: bool
    notes: list[Note]

    @property
    def held(self) -> list[Stance]:
        return [stance for stance in self.stands if not all(plant.reason for plant in stance.plants)]

    @property
    def left(self) -> list[Stance]:
        return [stance for stance in self.stands if all(plant.reason for plant in stance.plants)]


def _held(
    clip: Clip, pose: Pose, legs: tuple[Foot, ...], rig: Rig, contacts: Contacts, params: EnforceParams
) -> Enforcement:
    aims = _set(clip, pose, legs, rig, contacts, params)
    hold = _by_root if params.method == "root" else _by_legs
    done = hold(clip, rig, pose, aims, params)
    stands = done.stands
    residual = outcomes.residual(rig, stands, done.points)
    limit, noticed = "the root alone holds one point at a time", np.inf
    if params.method != "root":
        limit, noticed = "the leg does not reach it", params.plants.noticed * rig.leg_length
        narrower = tuple(exact(stance, residual, rig.leg_length, params.plants) for stance in stands)
        if any(new is not old for new, old in zip(narrower, stands, strict=True)):
            stands, residual = narrower, outcomes.residual(rig, narrower, done.points)
    plants = outcomes.footplants(rig, stands, residual, done.soft, aims.ride + aims.rise, limit, noticed)
    held = outcomes.held(aims.contacts, rig, stands)
    return Enforcement(plants, replace(done.correction, residual=residual), tuple(aims.notes), held, -aims.ride)


def _set(
    clip: Clip, pose: Pose, legs: tuple[Foot, ...], rig: Rig, contacts: Contacts, params: EnforceParams
) -> _Set:
    """The stances of a clip and their targets."""
    found = stances(contacts, legs, clip.frame_time, rig.leg_length, params.plants)
    notes = _places_not_taken(contacts, found)
    ride = _ride(clip, rig, legs, found, notes, params)
    legs = tuple(ground.carried(foot, ride) for foot in legs)
    cleaned = False
    if not params.again and params.style == StyleParams():
        found, cleaned = set_aside(pose, rig, contacts, legs, ride, found, notes, params.method, params.plants)
    if params.method != "root":
        found = lying(found, legs, clip.frame_time, params.plants)
        contacts, found = swivelled(contacts, found, legs, params.plants)
    found = levelled(found, legs, rig.floor, rig.leg_length, params.plants)
    rise = _rise(clip, rig, legs, found, notes, params)
    if np.any(rise):
        legs = tuple(ground.carried(foot, rise) for foot in legs)
        found = levelled(found, legs, rig.floor, rig.leg_length, params.plants)
    names = {e: sole.name for e, sole in enumerate(rig.soles)}
    stands, ways = [], courses([stance for stance in found if not stance.released], legs, params.plants)
    # how fast a belt goes is not known to the millimetre a second
    still = replace(params.plants, keep_mean=np.inf) if np.any(ride) else params.plants
    for stance in found:
        if stance.cleaned or stance.released:
            stands.append(stance if stance.cleaned else where_it_was(stance, legs[stance.leg]))
            continue
        stance = aimed(stance, ways[stance.leg], rig.leg_length, params.plants)
        stance = styled(stance, legs[stance.leg], names, rig.leg_length, params.style)
        stance = judged(stance, ways[stance.leg], rig.floor, clip.frame_time, rig.leg_length, still)
        if params.method != "root" and not can_turn(clip, legs[stance.leg].leg):
            stance = stance.let_go("the file has no rotation channels for a joint of this leg")
        stands.append(stance)
    return _Set(legs, contacts, as_rows(stands) if cleaned else stands, ride, rise, cleaned, notes)


def _by_root(clip: Clip, rig: Rig, pose: Pose, aims: _Set, params: EnforceParams) -> Held:
    """What the root alone holds; each stance where it stands after all."""
    shift = _root_shift(rig, pose, aims.legs, aims.held, clip.frame_time, params)
    nothing = np.zeros((len(clip), 0, 4)), np.zeros((len(clip), len(rig.soles)))
    points = tuple(track + shift + aims.ride + aims.rise for track in rig.tracks(pose))
    stands = tuple(_where_it_stands(stance, points) for stance in aims.stands)
    soft = tuple(np.zeros(len(clip)) for _ in aims.legs)
    return Held(Correction(rig.root, shift, (), *nothing), points, stands, soft)


def _by_legs(clip: Clip, rig: Rig, pose: Pose, aims: _Set, params: EnforceParams) -> Held:
    """What the legs hold, and the stances that are left."""
    wanted = LegParams(
        solver=params.solver, shares=params.method == "both", strength=params.strength, plants=params.plants,
        ease=params.ease, reach=params.reach, root=params.root, judge=params.judge,
    )  # fmt: skip
    left = aims.left
    if aims.cleaned:
        done, hard = easily(clip, rig, pose, aims.legs, aims.held, wanted)
        left += hard
    else:
        done = _with_the_roots_help(clip, rig, pose, aims.legs, aims.held, aims.notes, wanted)
    done = replace(done, stands=(*done.stands, *left))
    if not np.any(aims.rise):
        return done
    rise = params.strength * aims.rise
    return replace(done, correction=replace(done.correction, root_shift=done.correction.root_shift + rise))


def _within(clip: Clip, rig: Rig, contacts: Contacts, params: EnforceParams, proper: slice) -> Enforcement:
    """Enforcement of the motion proper alone; the frames of a T-pose before or after it stay as they are.

    Frames that lead from such a pose to the motion lead over to what is corrected in it, too.
    """
    start, end = proper.start, proper.stop
    effectors = []
    for effector in contacts.effectors:
        inside = [replace(c, start=max(c.start, start) - start, end=min(c.end, end) - start) for c in effector.contacts]
        effectors.append(replace(effector, contacts=tuple(c for c in inside if c.end > c.start)))
    inner = replace(contacts, frames=end - start, effectors=tuple(effectors))
    found = _on(clip.frames(proper), rig, inner, params)
    whole = found.correction
    around = ((start, len(clip) - end), (0, 0))
    rotations = np.zeros((len(clip), 0, 4))
    if whole.joints:
        rotations = np.stack([clip.turn(joint) for joint in whole.joints], axis=1)
    rotations[proper] = whole.rotations
    shift = np.pad(whole.root_shift, around)
    for rest, motion, between in ((0, start, slice(1, start)), (len(clip) - 1, end - 1, slice(end, len(clip) - 1))):
        share = _way_over(clip, rest, motion, between)
        shift[between] = share[:, None] * shift[motion]
        for k, joint in enumerate(whole.joints):
            captured = clip.turn(joint)
            turn = rotation.multiply(rotations[motion, k], rotation.inverse(captured[motion]))
            eased = rotation.from_rotation_vector(share[:, None] * rotation.to_rotation_vector(turn))
            on_its_way = (share > 0.0)[:, None]
            rotations[between, k] = np.where(on_its_way, rotation.multiply(eased, captured[between]), captured[between])
    correction = replace(whole, rotations=rotations, root_shift=shift, residual=np.pad(whole.residual, around))
    plants = tuple(replace(plant, start=plant.start + start, end=plant.end + start) for plant in found.plants)
    held = []
    for effector in found.contacts.effectors:
        moved = tuple(replace(c, start=c.start + start, end=c.end + start) for c in effector.contacts)
        held.append(replace(effector, contacts=moved))
    ground = np.pad(found.ground, around, mode="edge")
    contacts = replace(contacts, effectors=tuple(held))
    return replace(found, plants=plants, correction=correction, contacts=contacts, ground=ground)


def _way_over(clip: Clip, rest: int, motion: int, between: slice) -> Floats:
    """For frames that lead from a rest pose over to the motion, how far on that way each one is, from 0 to 1."""

    def far(other: int) -> Floats:  # [rad] from another frame, root mean square over the joints
        turns = rotation.multiply(clip.rotations[between], rotation.inverse(clip.rotations[[other]]))
        return np.asarray(np.sqrt(np.mean(rotation.angle(turns) ** 2, axis=1)))

    from_rest = far(rest)
    return np.where(from_rest < _REST, 0.0, from_rest / np.maximum(from_rest + far(motion), 1e-9))


def _with_the_roots_help(
    clip: Clip, rig: Rig, pose: Pose, legs: Sequence[Foot], stands: Sequence[Stance], notes: list[Note],
    params: LegParams,
) -> Held:  # fmt: skip
    """What the legs hold; where that is little, and more with it, what they hold while the root moves with the feet."""
    done = enforced(clip, rig, pose, legs, stands, params)
    if params.shares or done.let_go <= params.judge.share * len(stands):
        return done
    shared = enforced(clip, rig, pose, legs, stands, replace(params, shares=True))
    if shared.let_go >= done.let_go:
        return done
    notes.append(Note("root-shares", "the legs alone could not hold many plants, so the root moves with the feet"))
    return shared


def _ride(
    clip: Clip, rig: Rig, legs: Sequence[Foot], stands: Sequence[Stance], notes: list[Note], params: EnforceParams
) -> Floats:
    """(F, 3) [m] what takes the ground's own motion out of the tracks."""
    velocity = ground.belt(stands, legs, clip.frame_time, rig.leg_length, params.ground)
    rides = np.any(velocity != 0.0, axis=1)
    if np.any(rides):
        speed = float(np.median(norm(velocity[rides])))
        where = "" if rides.all() else f" for {np.count_nonzero(rides) * clip.frame_time:.1f} s"
        text = f"the figure stays in place{where}: planted feet are taken along at {speed:.2f} m/s, as on a belt"
        notes.append(Note("in-place", text))
    # the frames before any ride are where they are
    return -np.concatenate([np.zeros((1, 3)), np.cumsum(velocity[:-1] * clip.frame_time, axis=0)])


def _rise(
    clip: Clip, rig: Rig, legs: Sequence[Foot], stands: Sequence[Stance], notes: list[Note], params: EnforceParams
) -> Floats:
    """(3,) [m] what takes a common error of height out of the tracks."""
    if params.method == "root" or not clip.skeleton.translates[rig.root]:
        return np.zeros(3)
    rise = ground.lift(stands, legs, rig.leg_length, params.ground)
    if rise:
        text = f"the whole figure is {'raised' if rise > 0 else 'lowered'} by {1000.0 * abs(rise):.0f} mm to its floor"
        notes.append(Note("height-moved", text))
    return np.array([0.0, rise, 0.0])


def _places_not_taken(contacts: Contacts, stands: Sequence[Stance]) -> list[Note]:
    asked = sum(c.position is not None and c.wish != "forbid" for e in contacts.effectors for c in e.contacts)
    taken = sum(plant.contact.position is not None for stance in stands for plant in stance.plants)
    if asked == taken:
        return []
    text = f"{asked - taken} of {asked} places that the labels ask for are out of reach of this motion, and not taken"
    return [Note("places-not-taken", text)]


def _root_shift(
    rig: Rig, pose: Pose, legs: tuple[Foot, ...], stands: list[Stance], frame_time: float, params: EnforceParams
) -> Floats:
    """(F, 3) [m] Lyard's correction; zero where everything stands well enough."""
    frames = len(legs[0])
    planted = np.zeros((frames, len(rig.soles)), dtype=np.bool_)
    levels = np.full((frames, len(rig.soles)), rig.floor)
    tracks: list[Floats] = [np.zeros(0)] * len(rig.soles)
    for foot in legs:
        for part, e in zip(("heel", "toe"), foot.effectors, strict=True):
            tracks[e] = foot.point(part)
    for stance in stands:
        for plant in stance.plants:
            planted[plant.frames, plant.effector] = True
            levels[plant.frames, plant.effector] = stance.level
    if all(_stands_for_root(plant, tracks[plant.effector], rig, params) for s in stands for plant in s.plants):
        return np.zeros((frames, 3))
    at = legs[0].hip - pose.position(rig.legs[0].hip) + pose.position(rig.root)  # on the same ground as the feet
    shift = root.correction(at, tracks, planted, levels, frame_time, rig.leg_length, params.root)
    return params.strength * shift


def _stands_for_root(plant: Plant, track: Floats, rig: Rig, params: EnforceParams) -> bool:
    """Whether a plant stands as well as the root alone could make it stand."""
    off = np.abs(track[plant.frames] - plant.target)
    slides = float(np.hypot(off[:, 0], off[:, 2]).max()) > params.root.keep_slide * rig.leg_length
    return not slides and float(off[:, 1].max()) <= params.root.keep_height * rig.leg_length


def _where_it_stands(stance: Stance, points: Sequence[Floats]) -> Stance:
    """The stance with each plant's target where the plant stands after all: root-only asks for no place."""
    plants = []
    for plant in stance.plants:
        places = points[plant.effector][plant.frames]
        place = np.median(places, axis=0)
        place[1] = stance.level
        plants.append(replace(plant, target=place))
    return replace(stance, plants=tuple(plants))
