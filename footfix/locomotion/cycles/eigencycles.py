"""The space of cycles: each gait's mean, principal components, and coefficients by speed and style.

Source: P. Glardon, R. Boulic, D. Thalmann, Robust on-line adaptive footplant detection and enforcement for
locomotion, The Visual Computer 22 (2006), section 3: the components are of whole cycles, not of frames, in levels, of
which walk and run are the first.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np

from footfix.locomotion.cycles.leg_vectors import exponentials, matrix_products, products, squares
from footfix.locomotion.cycles.samples import Gait, Sample
from footfix.motion import rotation
from footfix.motion.clip import Floats, frozen

SLOWEST = 1e-3  # v / sqrt(g l): the frequency of slower motion is that of this speed
CONTACT_RANGE, CONTACT_SPEEDS = 1.6, 9  # contacts are tabulated over this multiple of the range of speeds, at so many


@dataclass(frozen=True, eq=False)
class Code:
    """Converts samples to rows of numbers, and back.

    Args:
        middle: (J, 4) mean rotation of each joint; others are rotation vectors from it.
        reach: (J,) [leg lengths] from each joint to the farthest point below it, by which its rotation is weighted.
    """

    middle: Floats
    reach: Floats

    def rows(self, samples: Sequence[Sample]) -> Floats:
        """Convert samples to rows (n, N, 3 + 3 J): the root's place, then every joint's rotation vector."""
        turns = np.stack([each.turns for each in samples])
        vectors = rotation.to_rotation_vector(rotation.multiply(rotation.inverse(self.middle), turns))
        places = np.stack([each.places for each in samples])
        return np.concatenate([places, vectors.reshape(*vectors.shape[:2], -1)], axis=2)

    def turns(self, rows: Floats) -> Floats:
        """Convert rows (T, 3 + 3 J) to rotations (T, J, 4)."""
        vectors = rows[:, 3:].reshape(len(rows), len(self.middle), 3).swapaxes(0, 1)
        return (exponentials(vectors) @ self._products).swapaxes(0, 1)

    def frames(self, rows: Floats) -> Floats:
        """Convert rows (T, 3 + 3 J) to rotation matrices (T, J, 3, 3)."""
        vectors = rows[:, 3:].reshape(len(rows), len(self.middle), 3).swapaxes(0, 1)
        found = squares(exponentials(vectors)) @ self._matrix_products
        return found.swapaxes(0, 1).reshape(len(rows), len(self.middle), 3, 3)

    @cached_property
    def _products(self) -> Floats:
        return products(self.middle)

    @cached_property
    def _matrix_products(self) -> Floats:
        return matrix_products(self.middle)

    @property
    def weights(self) -> Floats:
        """Compute the size in leg lengths of one unit of each number of a row, (3 + 3 J,)."""
        return np.concatenate([np.ones(3), np.repeat(self.reach, 3)])


@dataclass(frozen=True)
class Ramp:
    """Features of speed on which the cycle depends: a polynomial in the captured range, linear outside.

    Args:
        low, high: the range, v / sqrt(g l).
        degree: 0 to 2.
    """

    low: float
    high: float
    degree: int

    def within(self, speed: Floats) -> Floats:
        """Map speeds (...) to -1 at the low and 1 at the high end of the range."""
        middle, half = 0.5 * (self.low + self.high), max(0.5 * (self.high - self.low), 1e-9)
        return (np.asarray(speed, dtype=np.float64) - middle) / half

    def __call__(self, speed: Floats) -> Floats:
        """Compute the features (..., 1 + degree) of speeds (...)."""
        u = self.within(speed)
        inside = np.clip(u, -1.0, 1.0)
        terms = [np.ones_like(u), u, inside * inside + 2.0 * inside * (u - inside)]
        return np.stack(terms[: self.degree + 1], axis=-1)


@dataclass(frozen=True, eq=False)
class GaitSpace:
    """The cycles of one gait.

    Args:
        gait: "walk" or "run".
        mean: (N, D) the mean cycle, as rows of a `Code`.
        components: (K, N, D) principal components.
        ramp: features of speed.
        map: (P, K) coefficients for each feature of the speed, then for each style.
        styles: their names.
        frequency: (2 + S,) of log frequency over log speed: at speed 1, slope, and what each style adds.
        contacts: (M, E, 2) at which phase each effector is set down, and for how long it stays [share of the cycle], at
            M speeds over `CONTACT_RANGE` times the range; 0 where it never is.
        variance: (K,) share of the variance that each component holds.
        cycles: number of cycles it was fitted to.
    """

    gait: Gait
    mean: Floats
    components: Floats
    ramp: Ramp
    map: Floats
    styles: tuple[str, ...]
    frequency: Floats
    contacts: Floats
    variance: Floats
    cycles: int

    def __post_init__(self) -> None:
        for name in ("mean", "components", "map", "frequency", "contacts", "variance"):
            object.__setattr__(self, name, frozen(getattr(self, name)))

    @cached_property
    def directions(self) -> Floats:
        """Join the mean, and what each feature adds to it, (1 + P, N, D)."""
        return np.concatenate([self.mean[None], np.tensordot(self.map, self.components, axes=1)])

    def features(self, speed: Floats, style: Floats) -> Floats:
        """Compute the factors (T, 1 + P) of `directions` at speeds (T,) and weights of styles (T, S)."""
        return np.concatenate([np.ones((len(speed), 1)), self.ramp(speed), style], axis=1)

    def cycle(self, speed: float, style: Floats | None = None) -> Floats:
        """Make the cycle (N, D) of a speed v / sqrt(g l), with weights (S,) of the styles."""
        style = np.zeros(len(self.styles)) if style is None else style
        weights = np.concatenate([self.ramp(np.array([speed]))[0], style]) @ self.map  # coefficients of the components
        return np.asarray(self.mean + np.tensordot(weights, self.components, axes=1))

    def frequencies(self, speed: Floats, style: Floats) -> Floats:
        """Compute the cycles in the time sqrt(l / g), (T,), at speeds (T,) and weights of styles (T, S)."""
        log = self.frequency[0] + self.frequency[1] * np.log(np.maximum(speed, SLOWEST)) + style @ self.frequency[2:]
        return np.asarray(np.exp(log))

    def contact_rows(self, speed: Floats) -> Floats:
        """Compute the row of `contacts` that belongs to speeds (...); fractions lie between two rows."""
        return np.asarray((self.ramp.within(speed) / CONTACT_RANGE + 1.0) * 0.5 * (len(self.contacts) - 1))

    def contact_speeds(self) -> Floats:
        """Compute the speeds (M,) at which contacts are known."""
        u = np.linspace(-CONTACT_RANGE, CONTACT_RANGE, CONTACT_SPEEDS)
        return np.maximum(0.5 * (self.ramp.low + self.ramp.high) + 0.5 * u * (self.ramp.high - self.ramp.low), 1e-3)


def kernel(phases: Floats, n: int) -> Floats:
    """Compute the weights (T, n) that interpolate a periodic function of n even samples at phases (T,).

    The function is the trigonometric polynomial through the samples, so that a cycle closes with all its derivatives.
    """
    # sin(n x) / (n tan(x)) with x = pi (phase - k / n), by the sines and cosines of both parts
    sines, cosines, signs = _samples(n)
    angle = np.pi * phases
    sine, cosine = np.sin(angle)[:, None], np.cos(angle)[:, None]
    below = sine * cosines - cosine * sines
    above = cosine * cosines + sine * sines
    small = np.abs(below) < 1e-9
    below[small] = 1.0
    above *= np.sin(n * angle)[:, None] * signs
    above /= below
    above[small] = 1.0
    return np.asarray(above)


@cache
def _samples(n: int) -> tuple[Floats, Floats, Floats]:
    """Compute the sines and cosines of pi k / n for n samples k, and (-1)^k / n."""
    own = np.pi * np.arange(n) / n
    return frozen(np.sin(own)), frozen(np.cos(own)), frozen(np.where(np.arange(n) % 2, -1.0, 1.0) / n)
