"""Postures of a figure: those of its cycles, and those with feet moved to their goals.

Source: P. Glardon, R. Boulic, D. Thalmann, Robust on-line adaptive footplant detection and enforcement for
locomotion, The Visual Computer 22 (2006), sections 3 and 5.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from footfix.locomotion.cycles.foot_offsets import Feet, goals, lowered
from footfix.locomotion.cycles.leg_pose import LegPoses
from footfix.locomotion.cycles.leg_vectors import about_up, applied, matrices, turned_about_up
from footfix.locomotion.cycles.model import CycleModel
from footfix.locomotion.cycles.plan import Course
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
class CyclePostures:
    """Postures of the cycles, with no foot held.

    Args:
        place: (T, 3) [m] the root.
        turns: (T, J, 4) xyzw all rotations.
        legs: the legs.
    """

    place: Floats
    turns: Floats
    legs: LegPoses

    def some(self, which: slice) -> CyclePostures:
        """Take the postures at some of the times."""
        return CyclePostures(self.place[which], self.turns[which], self.legs.some(which))


@dataclass(frozen=True, eq=False)
class OffsetPostures:
    """Postures of the cycles, and the offsets of feet from them.

    Args:
        times: (T,) [s].
        cycle: T postures.
        off: (T, L, Q, 3).
    """

    times: Floats
    cycle: CyclePostures
    off: Floats


def cycle_postures(model: CycleModel, course: Course, times: Floats) -> CyclePostures:
    """Compute the postures of the cycles at times (T,) [s] (G eq. 5, 6)."""
    at, asked = course.at(times)
    rows = model.rows(at[:, 0], asked)
    turns, root = model.turns(rows), model.rig.root
    turns[:, root] = turned_about_up(at[:, 2], turns[:, root])
    frames, place = matrices(turns[:, model.leg_joints]), _place(model, at, rows, about_up(at[:, 2]))
    return CyclePostures(place, turns, model.legs.poses(place, frames[:, 0], frames[:, 1:]))


def leg_poses(model: CycleModel, course: Course, times: Floats) -> LegPoses:
    """Compute the leg poses of the cycles at times (T,) [s]."""
    at, asked = course.at(times)
    rows, front = model.leg_rows(at[:, 0], asked), about_up(at[:, 2])
    frames = model.leg_frames(rows)
    return model.legs.poses(_place(model, at, rows, front), front @ frames[:, 0], frames[:, 1:])


def _place(model: CycleModel, at: Floats, rows: Floats, front: Floats) -> Floats:
    """Place the root (T, 3) [m] on a course (T, 5) with headings (T, 3, 3), by rows of the code."""
    place = applied(front, model.rig.leg_length * rows[:, :3])
    place[:, ::2] += at[:, 3:]
    return place


def held(model: CycleModel, feet: Feet, base: OffsetPostures) -> Postures:
    """Make the postures in which feet are at their goals."""
    pose, off = base.cycle.legs, base.off
    place, turns = np.array(base.cycle.place), np.array(base.cycle.turns)
    hip, ankle, foot, toes = goals(pose, off)
    more = lowered(pose, ankle - hip, off[:, :, 5, 0], model.rig.leg_length)
    down = pose.hip[:, 0, 1] - hip[:, 0, 1] + more
    place[:, 1] -= down
    ankle[..., 1] += down[:, None]  # the legs are posed on the figure where it was
    turns[:, model.legs.turned] = model.legs.bent(pose, model.knees, ankle, foot, toes)
    legs, parts, names = model.effectors
    return Postures(base.times, place, turns, feet.planted(base.times)[:, legs, parts], names)
