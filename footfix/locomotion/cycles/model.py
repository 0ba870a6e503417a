"""The model of how a figure walks and runs: skeleton, legs, and the space of its gait cycles."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from footfix.locomotion.cycles.eigencycles import SLOWEST, Code, GaitSpace, kernel
from footfix.locomotion.cycles.leg_pose import Legs
from footfix.locomotion.cycles.plan import Plan
from footfix.locomotion.cycles.samples import GRAVITY
from footfix.motion.clip import Floats, Ints, Skeleton, frozen
from footfix.rig.rig import Rig

FASTEST = 1.2  # [fastest captured run] greatest speed of the table `between`


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
    """The model from which an engine makes locomotion. It contains no captured clip.

    Args:
        skeleton: of the figure.
        rig: its legs, soles and size; its floor is at 0.
        code: converts numbers to rotations.
        spaces: of its gaits, "walk" before "run".
        levels: (E,) [leg lengths] height at which a planted heel's sole point and toe joint stay.
        knees: (L, 3) axis about which each knee flexes, in the frame of the thigh.
        between: (M, E, 2) how much later contacts half-way between walk and run begin, and how much longer they last,
            than the mean of both [share of the cycle], at M speeds up to `FASTEST` times the fastest run.
        origins: the files.
    """

    skeleton: Skeleton
    rig: Rig
    code: Code
    spaces: tuple[GaitSpace, ...]
    levels: Floats
    knees: Floats
    between: Floats
    origins: tuple[Origin, ...] = ()

    def __post_init__(self) -> None:
        for name in ("levels", "knees", "between"):
            object.__setattr__(self, name, frozen(getattr(self, name)))

    @property
    def styles(self) -> tuple[str, ...]:
        """List the names of its styles besides the plain one."""
        return self.spaces[0].styles

    @property
    def gaits(self) -> tuple[str, ...]:
        """List its gaits."""
        return tuple(space.gait for space in self.spaces)

    @cached_property
    def froude(self) -> float:
        """Compute sqrt(g l) [m/s]."""
        return float(np.sqrt(GRAVITY * self.rig.leg_length))

    @cached_property
    def legs(self) -> Legs:
        """Get the joints that move its legs."""
        return Legs(self.skeleton, self.rig)

    @cached_property
    def sole_levels(self) -> Floats:
        """Compute the heights of each leg's heel and toe while planted, (L, 2) [m]."""
        level = np.zeros((len(self.rig.legs), 2))
        for each, sole in zip(self.levels, self.rig.soles, strict=True):
            level[sole.leg, int(sole.part == "toe")] = each * self.rig.leg_length
        return level

    @cached_property
    def effectors(self) -> tuple[list[int], list[int], tuple[str, ...]]:
        """List the effectors: leg, 0 for a heel or 1 for a toe, and name."""
        soles = self.rig.soles
        return [s.leg for s in soles], [int(s.part == "toe") for s in soles], tuple(s.name for s in soles)

    @cached_property
    def leg_columns(self) -> tuple[Ints, ...]:
        """List for each leg the columns of a row that belong to its joints."""
        found = []
        for leg in self.rig.legs:
            joints = [j for j in range(len(self.skeleton)) if leg.hip in self.skeleton.ancestors(j)]
            found.append(np.concatenate([3 + 3 * j + np.arange(3) for j in joints]))
        return tuple(found)

    def shares(self, run: Floats) -> Floats:
        """Compute the weights of the gaits, (T, G); 1 in a model of one gait."""
        if len(self.spaces) == 1:
            return np.ones((len(run), 1))
        share = np.empty((len(run), 2))
        share[:, 1] = np.minimum(np.maximum(run, 0.0), 1.0)
        share[:, 0] = 1.0 - share[:, 1]
        return share

    def frequency(self, asked: Plan) -> Floats:
        """Compute the frequency of the cycle, (T,) [Hz]; between gaits the logarithms are blended."""
        at_one, slope, styles = self._frequency_lines
        logs = at_one + np.log(np.maximum(asked.speed, SLOWEST * self.froude))[:, None] * slope
        if len(styles):
            logs += asked.style @ styles
        if len(self.spaces) == 1:
            return np.asarray(np.exp(logs[:, 0]))
        return np.asarray(np.exp(np.add.reduce(self.shares(asked.run) * logs, axis=1)))

    @cached_property
    def _frequency_lines(self) -> tuple[Floats, Floats, Floats]:
        """Compute for each gait log frequency [Hz] at 1 m/s (G,), slope over log speed (G,), and styles (S, G)."""
        lines = np.array([space.frequency for space in self.spaces])
        rate = 0.5 * np.log(GRAVITY / self.rig.leg_length)
        return lines[:, 0] - np.log(self.froude) * lines[:, 1] + rate, lines[:, 1], lines[:, 2:].T

    def contact_phases(self, asked: Plan) -> Floats:
        """Compute the contact of each effector, (T, E, 2): start phase and duration."""
        spans = self._contacts_of_gaits(asked)
        if len(self.spaces) == 1:
            return spans[:, 0]
        run = self.shares(asked.run)[:, 1]
        spans = spans[:, 0] + run[:, None, None] * (spans[:, 1] - spans[:, 0])
        mixed = 4.0 * run * (1.0 - run)
        if mixed.any():
            m = len(self.between)
            at = np.minimum(asked.speed * ((m - 1) / (self.froude * self.between_speeds()[-1])), m - 1.0)
            k = np.minimum(at.astype(np.intp), m - 2)
            low, high = self.between[k], self.between[k + 1]
            spans += mixed[:, None, None] * (low + (at - k)[:, None, None] * (high - low))
        return spans

    def between_speeds(self) -> Floats:
        """Compute the speeds v / sqrt(g l) at which `between` is known, (M,)."""
        return np.linspace(0.0, FASTEST * self.spaces[-1].ramp.high, len(self.between))

    def _contacts_of_gaits(self, asked: Plan) -> Floats:
        """Find when effectors are set down in each gait, and for how long, (T, G, E, 2); 0 where they never are."""
        table, slope, at_rest = self._contact_table
        most = table.shape[1] - 1.0
        at = np.minimum(np.maximum(at_rest + asked.speed[:, None] * slope, 0.0), most)
        k, gaits = np.minimum(at.astype(np.intp), int(most) - 1), np.arange(len(table))
        low, high = table[gaits, k], table[gaits, k + 1]
        return np.asarray(low + (at - k)[..., None, None] * (high - low))

    @cached_property
    def _contact_table(self) -> tuple[Floats, Floats, Floats]:
        """Join contacts of all gaits (G, M, E, 2), and the line from speed to row: slopes (G,), rows at rest (G,)."""
        table = np.array([space.contacts for space in self.spaces])
        at = np.array([space.contact_rows(np.array([0.0, 1.0])) for space in self.spaces])
        return table, (at[:, 1] - at[:, 0]) / self.froude, at[:, 0]

    def rows(self, phases: Floats, asked: Plan) -> Floats:
        """Compute the poses at phases (T,) as rows (T, D) of the code.

        Walk and run are blended at equal phase; each leg's phase is first converted to that at which its foot is at the
        same point of its stance or swing in that gait.
        """
        return self._rows(phases, asked, 0)

    def leg_rows(self, phases: Floats, asked: Plan) -> Floats:
        """Compute the part of `rows` that moves the legs, (T, 6 + 3 N): the root, and `legs.joints`."""
        return self._rows(phases, asked, 1)

    def _rows(self, phases: Floats, asked: Plan, part: int) -> Floats:
        """Compute `rows` (part 0) or `leg_rows` (part 1)."""
        speed = asked.speed / self.froude
        if len(self.spaces) == 1:
            return self._of_gait(0, phases, speed, asked.style, None, part)
        share = self.shares(asked.run)
        if not share[:, 1].any():
            return self._of_gait(0, phases, speed, asked.style, None, part)
        if not share[:, 0].any():
            return self._of_gait(1, phases, speed, asked.style, None, part)
        spans = self._contacts_of_gaits(asked)
        own = self._stances(spans)  # (T, G, L, 2)
        mixed = self._stances((share[:, None] @ spans.reshape(*share.shape, -1)).reshape(-1, 1, *spans.shape[2:]))
        led = warped(phases[:, None, None], mixed, own)
        walk, run = (self._of_gait(g, phases, speed, asked.style, led[:, g], part) for g in (0, 1))
        return np.asarray(walk + share[:, 1:] * (run - walk))

    def _of_gait(
        self, gait: int, phases: Floats, speed: Floats, style: Floats, led: Floats | None, part: int
    ) -> Floats:
        """Compute the rows of one gait; its legs at phases (T, L) of their own, if these are given."""
        space = self.spaces[gait]
        features, samples = space.features(speed, style), space.mean.shape[0]
        directions = self._directions[part][gait]
        rows = _at(directions[-1], kernel(phases, samples), features)
        if led is not None:
            weights = kernel(led.T.ravel(), samples).reshape(*led.T.shape, samples)
            for number, columns in enumerate(self._columns[part][1]):
                rows[:, columns] = _at(directions[number], weights[number], features)
        return rows

    @cached_property
    def _columns(self) -> tuple[tuple[Ints, tuple[Ints, ...]], ...]:
        """List for all joints, and for the legs alone, the columns of a row, and among them those of each leg."""
        every = np.arange(3 + 3 * len(self.skeleton))
        joints = np.array(self.leg_joints)
        some = np.concatenate([np.arange(3), (3 + 3 * joints[:, None] + np.arange(3)).ravel()])
        return tuple(
            (own, tuple(np.flatnonzero(np.isin(own, leg)) for leg in self.leg_columns)) for own in (every, some)
        )

    @cached_property
    def _directions(self) -> tuple[list[list[Floats]], ...]:
        """Get for all joints, and for the legs alone, of each gait the directions of each leg, and of all."""
        found = []
        for columns, legs in self._columns:
            every = [np.ascontiguousarray(space.directions[:, :, columns]) for space in self.spaces]
            found.append([[*(np.ascontiguousarray(d[:, :, own]) for own in legs), d] for d in every])
        return tuple(found)

    def _stances(self, spans: Floats) -> Floats:
        """Find when feet are set down and for how long they stand, (..., L, 2), from contacts (..., E, 2)."""
        pairs = spans.reshape(*spans.shape[:-2], -1, 2, 2)
        start, lasts = pairs[..., 0], pairs[..., 1]
        there = lasts > 1e-3
        first = np.where(there, start, 2.0).min(axis=-1)
        last = np.where(there, start + lasts, -2.0).max(axis=-1)
        return np.stack([first, np.clip(last - first, 0.05, 0.95)], axis=-1)

    def turns(self, rows: Floats) -> Floats:
        """Convert rows (T, D) to rotations (T, J, 4)."""
        return self.code.turns(rows)

    def leg_frames(self, rows: Floats) -> Floats:
        """Convert rows (T, 6 + 3 N) of `leg_rows` to rotation matrices (T, 1 + N, 3, 3) of `leg_joints`."""
        return self._leg_code.frames(rows)

    @cached_property
    def leg_joints(self) -> list[int]:
        """List the root, and `legs.joints`."""
        return [self.rig.root, *self.legs.joints]

    @cached_property
    def _leg_code(self) -> Code:
        return Code(self.code.middle[self.leg_joints], self.code.reach[self.leg_joints])


def _at(directions: Floats, weights: Floats, features: Floats) -> Floats:
    """Sum up directions (P, N, D), interpolated by weights (T, N) of the phases, times features (T, P): rows (T, D)."""
    row = features[:, :1] * (weights @ directions[0])
    for p in range(1, len(directions)):
        row += features[:, p : p + 1] * (weights @ directions[p])
    return np.asarray(row)


def warped(phases: Floats, here: Floats, there: Floats) -> Floats:
    """Convert phases (...) of one gait to those of another with the foot at the same point of its stance or swing.

    Args:
        phases: (...).
        here, there: (..., 2) when the foot is set down, and for how long it stands.
    """
    u = np.mod(phases - here[..., 0], 1.0)
    d, e = here[..., 1], there[..., 1]
    first, second = e / d, (1.0 - e) / (1.0 - d)
    slope = 2.0 * first * second / (first + second)  # of a monotone cubic at both of its knots
    stance = u < d
    size = np.where(stance, d, 1.0 - d)
    s = np.where(stance, u, u - d) / size
    low, high = np.where(stance, 0.0, e), np.where(stance, e, 1.0)
    led = low + (high - low) * s * s * (3.0 - 2.0 * s) + slope * size * s * (1.0 - s) * (1.0 - 2.0 * s)
    return np.asarray(there[..., 0] + led)
