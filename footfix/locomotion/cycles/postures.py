"""Postures of a figure: as its cycles have them, and with feet that are where they are led.

Source: P. Glardon, R. Boulic, D. Thalmann, Robust on-line adaptive footplant detection and enforcement for
locomotion, The Visual Computer 22 (2006), sections 3 and 5.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from footfix.locomotion.cycles.feet import Feet, goals, lowered
from footfix.locomotion.cycles.leg_pose import LegPoses
from footfix.locomotion.cycles.model import CycleModel
from footfix.locomotion.cycles.plan import Course
from footfix.motion import rotation
from footfix.motion.clip import Bools, Clip, Floats


@dataclass(frozen=True, eq=False)
class Postures:
    """Postures of a figure at T times.

    Args:
        times: (T,) [s].
        place: (T, 3) [m] the root.
        turns: (T, J, 4) xyzw each joint's rotation in its parent's frame.
        contacts: (T, E) whether each effector is planted.
        names: of the effectors.
    """

    times: Floats
    place: Floats
    turns: Floats
    contacts: Bools
    names: tuple[str, ...]

    def __len__(self) -> int:
        return len(self.times)

    def clip(self, model: CycleModel, frame_time: float) -> Clip:
        """Make a clip of them."""
        skeleton, root = model.skeleton, model.rig.root
        places = np.tile(skeleton.offsets, (len(self), 1, 1))
        places[:, root] = self.place
        return Clip(skeleton, places, self.turns, frame_time)


@dataclass(frozen=True, eq=False)
class Free:
    """Postures as the cycles have them, no foot held.

    Args:
        place: (T, 3) [m] the root.
        turns: (T, J, 4) xyzw all rotations.
        legs: the legs, at these times and maybe some before.
    """

    place: Floats
    turns: Floats
    legs: LegPoses


@dataclass(frozen=True, eq=False)
class Led:
    """Postures as the cycles have them, and how feet are led off them.

    Args:
        times: (T,) [s].
        free: T postures.
        off: (T, L, Q, 3).
    """

    times: Floats
    free: Free
    off: Floats


def free_postures(model: CycleModel, course: Course, times: Floats, first: int = 0) -> Free:
    """Tell the postures that the cycles have at times (T,) [s] (G eq. 5, 6): those from `first` on, and all legs."""
    at, asked = course.at(times), course.plan.at(times)
    heading, root = rotation.about_vertical(at[:, 2]), model.rig.root
    if first:  # of most times nothing is asked for but the legs
        rows, every = model.leg_rows(at[:, 0], asked, first)
        own, turns = model.leg_turns(rows), model.turns(every)
        own_root, own_legs = own[:, 0], own[:, 1:]
    else:
        rows = model.rows(at[:, 0], asked)
        turns = model.turns(rows)
        own_root, own_legs = turns[:, root], turns[:, model.legs.joints]
    front = rotation.multiply(heading, own_root)
    place = rotation.rotate(heading, model.rig.leg_length * rows[:, :3])
    place[:, 0] += at[:, 3]
    place[:, 2] += at[:, 4]
    legs = model.legs.poses(place, front, own_legs)
    turns[:, root] = front[first:]
    return Free(place[first:], turns, legs)


def leg_poses(model: CycleModel, course: Course, times: Floats) -> LegPoses:
    """Pose the legs as the cycles have them at times (T,) [s]."""
    return free_postures(model, course, times, len(times)).legs


def held(model: CycleModel, feet: Feet, led: Led) -> Postures:
    """Make the postures in which feet are where they are led."""
    pose, off, rig = led.free.legs, led.off, model.rig
    place, turns = np.array(led.free.place), np.array(led.free.turns)
    hip, ankle, foot, toes = goals(pose, off)
    more = lowered(pose, ankle - hip, off[:, :, 5, 0], rig.leg_length)
    down = pose.hip[:, 0, 1] - hip[:, 0, 1] + more
    place[:, 1] -= down
    ankle[..., 1] += down[:, None]  # the legs are posed on the figure where it was
    turns[:, model.legs.turned] = model.legs.bent(pose, model.knees, ankle, foot, toes)
    contacts = np.empty((len(led.times), len(rig.soles)), dtype=np.bool_)
    for e, sole in enumerate(rig.soles):
        contacts[:, e] = feet.planted(sole.leg, sole.part, led.times)
    return Postures(led.times, place, turns, contacts, tuple(sole.name for sole in rig.soles))
