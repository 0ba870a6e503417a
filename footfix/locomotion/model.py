"""A model of how a figure walks and runs: its skeleton and legs, and the space of its cycles."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from footfix.locomotion.eigencycles import Code, GaitSpace, kernel
from footfix.locomotion.plan import Plan
from footfix.locomotion.samples import GRAVITY
from footfix.motion import rotation
from footfix.motion.clip import Floats, Ints, Skeleton, frozen
from footfix.rig.rig import Rig


@dataclass(frozen=True)
class Origin:
    """A file that a model was made of.

    Args:
        file: its name.
        sha256: of its bytes.
        cycles: how many it gave.
        style: which style they have.
    """

    file: str
    sha256: str
    cycles: int
    style: str = ""


@dataclass(frozen=True, eq=False)
class CycleModel:
    """What an engine makes locomotion of. It holds no captured clip.

    Args:
        skeleton: of the figure.
        rig: its legs, soles and size; its floor is at 0.
        code: what turns numbers into rotations.
        spaces: of its gaits, "walk" before "run".
        levels: (E,) [leg lengths] height at which a planted heel's sole point and toe joint stay.
        knees: (L, 3) axis about which each knee flexes, in the frame of the thigh.
        origins: the files.
    """

    skeleton: Skeleton
    rig: Rig
    code: Code
    spaces: tuple[GaitSpace, ...]
    levels: Floats
    knees: Floats
    origins: tuple[Origin, ...] = ()

    def __post_init__(self) -> None:
        for name in ("levels", "knees"):
            object.__setattr__(self, name, frozen(getattr(self, name)))

    @property
    def styles(self) -> tuple[str, ...]:
        """Names of the styles that it knows besides the plain one."""
        return self.spaces[0].styles

    @property
    def gaits(self) -> tuple[str, ...]:
        """Which gaits it knows."""
        return tuple(space.gait for space in self.spaces)

    @cached_property
    def froude(self) -> float:
        """[m/s] sqrt(g l)."""
        return float(np.sqrt(GRAVITY * self.rig.leg_length))

    @cached_property
    def leg_columns(self) -> tuple[Ints, ...]:
        """For each leg the columns of a row that its joints fill."""
        found = []
        for leg in self.rig.legs:
            joints = [j for j in range(len(self.skeleton)) if leg.hip in self.skeleton.ancestors(j)]
            found.append(np.concatenate([3 + 3 * j + np.arange(3) for j in joints]))
        return tuple(found)

    def shares(self, run: Floats) -> Floats:
        """(T, G) how much of each gait there is; a model of one gait has nothing else."""
        if len(self.spaces) == 1:
            return np.ones((len(run), 1))
        run = np.clip(run, 0.0, 1.0)
        return np.stack([1.0 - run, run], axis=1)

    def frequency(self, asked: Plan) -> Floats:
        """(T,) [Hz] of the cycle; between gaits the logarithms are blended."""
        speed = asked.speed / self.froude
        logs = np.stack([np.log(space.frequencies(speed, asked.style)) for space in self.spaces], axis=1)
        return np.asarray(np.exp(np.sum(self.shares(asked.run) * logs, axis=1)) * np.sqrt(GRAVITY / self.rig.leg_length))

    def contact_phases(self, asked: Plan) -> Floats:
        """(T, E, 2) phase at which each effector is set down, and for how long it stays."""
        return np.asarray(np.einsum("tg,tgek->tek", self.shares(asked.run), self._contacts_of_gaits(asked)))

    def _contacts_of_gaits(self, asked: Plan) -> Floats:
        speed = asked.speed / self.froude
        return np.stack([space.contact_phases(speed) for space in self.spaces], axis=1)

    def rows(self, phases: Floats, asked: Plan) -> Floats:
        """(T, D) poses at phases (T,), as rows of the code.

        Walk and run are blended at equal phase; each leg's phase is first led to where its foot would be as far in its
        stance, or swing, in that gait.
        """
        share = self.shares(asked.run)
        speed = asked.speed / self.froude
        used = [g for g in range(len(self.spaces)) if np.any(share[:, g] > 0.0)]
        blended = np.any((share > 0.0).sum(axis=1) > 1)
        spans = self._contacts_of_gaits(asked) if blended else None
        total = np.zeros((len(phases), 3 + 3 * len(self.skeleton)))
        for g in used:
            space = self.spaces[g]
            features = space.features(speed, asked.style)
            row = _at(space.directions, kernel(phases, space.mean.shape[0]), features)
            if spans is not None:
                for number, columns in enumerate(self.leg_columns):
                    own, mixed = (self.stance(each, number) for each in (spans[:, g], np.einsum("tg,tgek->tek", share, spans)))
                    led = warped(phases, mixed, own)
                    row[:, columns] = _at(space.directions[:, :, columns], kernel(led, space.mean.shape[0]), features)
            total += share[:, g : g + 1] * row
        return total

    def stance(self, spans: Floats, leg: int) -> Floats:
        """(T, 2) when a foot is set down and for how long it stands, of contacts (T, E, 2) of its soles."""
        own = [k for k, sole in enumerate(self.rig.soles) if sole.leg == leg]
        there = spans[:, own, 1] > 1e-3
        start = np.where(there, spans[:, own, 0], np.inf).min(axis=1)
        end = np.where(there, spans[:, own].sum(axis=2), -np.inf).max(axis=1)
        return np.stack([start, np.clip(end - start, 0.05, 0.95)], axis=1)

    def turns(self, rows: Floats) -> Floats:
        """(T, J, 4) rotations of rows (T, D)."""
        return self.code.turns(rows)


def _at(directions: Floats, weights: Floats, features: Floats) -> Floats:
    """(T, D) the sum of directions (P, N, D) at phases of weights (T, N), times features (T, P)."""
    row = features[:, :1] * (weights @ directions[0])
    for p in range(1, len(directions)):
        row += features[:, p : p + 1] * (weights @ directions[p])
    return row


def warped(phases: Floats, here: Floats, there: Floats) -> Floats:
    """(T,) phases of one gait at which a foot is as far in its stance, or swing, as at phases (T,) of another.

    Args:
        phases: (T,).
        here, there: (T, 2) when the foot is set down, and for how long it stands.
    """
    u = np.mod(phases - here[:, 0], 1.0)
    d, e = here[:, 1], there[:, 1]
    rise = [e / d, (1.0 - e) / (1.0 - d)]
    slope = 2.0 * rise[0] * rise[1] / (rise[0] + rise[1])  # of a monotone cubic at both of its knots
    stance = u < d
    size = np.where(stance, d, 1.0 - d)
    s = np.where(stance, u, u - d) / size
    low, high = np.where(stance, 0.0, e), np.where(stance, e, 1.0)
    led = low + (high - low) * s * s * (3.0 - 2.0 * s) + slope * size * s * (1.0 - s) * (1.0 - 2.0 * s)
    return np.asarray(there[:, 0] + led)


def place_of_root(rows: Floats, place: Floats, heading: Floats, leg_length: float) -> Floats:
    """(T, 3) [m] the root in the world: the course's place, and what the cycle adds to it in its frame (G eq. 5, 6)."""
    swing = rotation.rotate(rotation.about_vertical(heading), leg_length * rows[:, :3])
    return np.asarray(swing + np.stack([place[:, 0], np.zeros(len(place)), place[:, 1]], axis=1))


def weights_of(names: Sequence[str], style: str) -> Floats:
    """(S,) 1 for a style, nothing for the plain one."""
    return np.array([float(name == style) for name in names])
