"""Cycles as points of a space: the mean of each gait, its principal components, and where speed and style lie in it.

Source: P. Glardon, R. Boulic, D. Thalmann, Robust on-line adaptive footplant detection and enforcement for
locomotion, The Visual Computer 22 (2006), section 3: the components are of whole cycles, not of frames, in levels, of
which walk and run are the first.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from footfix.locomotion.cycles.samples import PHASES, Gait, Sample, mean_turns, shift_phases, shifted
from footfix.motion import rotation
from footfix.motion.clip import Floats, frozen

_ALIGNED = 0.08  # of a cycle, by which one may be shifted to have its motion when the others have it
_ROUNDS = 3
_STYLE = 1.0  # files' worth of no style at all, to which the style of few files is drawn
_BENT = 1.5  # fastest over slowest, from which on the map may be of second order
CONTACT_RANGE, CONTACT_SPEEDS = 1.6, 9  # how far beyond the range of speeds contacts are told, and at how many
_ENOUGH = 0.98  # of the variance, that the components hold


@dataclass(frozen=True, kw_only=True)
class SpaceParams:
    """How cycles become a space.

    Args:
        components: the most that a gait keeps [components].
        degree: of the map from speed to cycle; None for what a file left out says [1].
    """

    components: int = 20
    degree: int | None = None


@dataclass(frozen=True, eq=False)
class Code:
    """What turns a sample into a row of numbers of like meaning, and back.

    Args:
        middle: (J, 4) rotations about which all others are rotation vectors.
        reach: (J,) [leg lengths] how far each joint's rotation moves what hangs from it: what a number counts.
    """

    middle: Floats
    reach: Floats

    def rows(self, samples: Sequence[Sample]) -> Floats:
        """(n, N, 3 + 3 J) the numbers of samples: the root's place, then every joint's rotation vector."""
        turns = np.stack([each.turns for each in samples])
        vectors = rotation.to_rotation_vector(rotation.multiply(rotation.inverse(self.middle), turns))
        places = np.stack([each.places for each in samples])
        return np.concatenate([places, vectors.reshape(*vectors.shape[:2], -1)], axis=2)

    def turns(self, rows: Floats) -> Floats:
        """(..., J, 4) rotations of rows (..., 3 + 3 J)."""
        vectors = rows[..., 3:].reshape(*rows.shape[:-1], -1, 3)
        return rotation.multiply(self.middle, rotation.from_rotation_vector(vectors))

    @property
    def weights(self) -> Floats:
        """(3 + 3 J,) what a number counts in leg lengths."""
        return np.concatenate([np.ones(3), np.repeat(self.reach, 3)])


@dataclass(frozen=True)
class Ramp:
    """What of a speed the cycle depends on: a polynomial in the range seen, straight lines outside.

    Args:
        low, high: the range, v / sqrt(g l).
        degree: 0 to 2.
    """

    low: float
    high: float
    degree: int

    def within(self, speed: Floats) -> Floats:
        """(...) -1 to 1 over the range."""
        middle, half = 0.5 * (self.low + self.high), max(0.5 * (self.high - self.low), 1e-9)
        return (np.asarray(speed, dtype=np.float64) - middle) / half

    def __call__(self, speed: Floats) -> Floats:
        """(..., 1 + degree) features of speeds (...)."""
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
        ramp: what of the speed counts.
        map: (P, K) coefficients for each feature of the speed, then for each style.
        styles: their names.
        frequency: (2 + S,) of log frequency over log speed: at speed 1, slope, and what each style adds.
        contacts: (M, E, 2) at which phase each effector is set down, and for how long it stays [share of the cycle], at
            M speeds over `CONTACT_RANGE` times the range; 0 where it never is.
        variance: (K,) share of the variance that each component holds.
        cycles: how many it was made of.
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
        """(1 + P, N, D) the mean, and what each feature adds to it."""
        return np.concatenate([self.mean[None], np.tensordot(self.map, self.components, axes=1)])

    def features(self, speed: Floats, style: Floats) -> Floats:
        """(T, 1 + P) what multiplies `directions`, at speeds (T,) and weights of styles (T, S)."""
        return np.concatenate([np.ones((len(speed), 1)), self.ramp(speed), style], axis=1)

    def cycle(self, speed: float, style: Floats | None = None) -> Floats:
        """(N, D) the cycle at a speed v / sqrt(g l), with weights (S,) of the styles."""
        style = np.zeros(len(self.styles)) if style is None else style
        weights = np.concatenate([self.ramp(np.array([speed]))[0], style]) @ self.map  # coefficients of the components
        return np.asarray(self.mean + np.tensordot(weights, self.components, axes=1))

    def frequencies(self, speed: Floats, style: Floats) -> Floats:
        """(T,) cycles in the time sqrt(l / g), at speeds (T,) and weights of styles (T, S)."""
        log = self.frequency[0] + self.frequency[1] * np.log(np.maximum(speed, 1e-3)) + style @ self.frequency[2:]
        return np.asarray(np.exp(log))

    def contact_phases(self, speed: Floats) -> Floats:
        """(T, E, 2) phase at which each effector is set down, and for how long it stays; 0 where it never is."""
        m = len(self.contacts)
        at = np.clip((self.ramp.within(speed) / CONTACT_RANGE + 1.0) * 0.5 * (m - 1), 0.0, m - 1.0)
        k = np.minimum(at.astype(np.intp), m - 2)
        w = (at - k)[:, None, None]
        return np.asarray((1.0 - w) * self.contacts[k] + w * self.contacts[k + 1])

    def contact_speeds(self) -> Floats:
        """(M,) speeds at which contacts are known."""
        u = np.linspace(-CONTACT_RANGE, CONTACT_RANGE, CONTACT_SPEEDS)
        return np.maximum(0.5 * (self.ramp.low + self.ramp.high) + 0.5 * u * (self.ramp.high - self.ramp.low), 1e-3)


def aligned(samples: Sequence[Sample], code: Code) -> list[Sample]:
    """Shift cycles in phase, by less than their frames tell strikes apart, to be alike; phase 0 stays the mean strike.

    A strike is known to a frame, which at 30 fps is 3 % of a cycle.
    """
    samples = list(samples)
    grid = np.arange(-40, 41) / 40.0 * _ALIGNED
    weights = code.weights
    total = np.zeros(len(samples))
    for _ in range(_ROUNDS):
        rows = code.rows(samples) * weights
        spectra = np.fft.rfft(rows - rows.mean(axis=1, keepdims=True), axis=1)
        mean = spectra.mean(axis=0)
        harmonics = np.arange(spectra.shape[1])
        cross = np.einsum("nhd,hd->nh", spectra, mean.conj())
        fits = np.real(cross @ np.exp(2j * np.pi * np.outer(harmonics, grid)))
        best = grid[np.argmax(fits, axis=1)]
        best -= best.mean()
        best = np.clip(total + best, -_ALIGNED, _ALIGNED) - total
        total += best
        samples = [shifted(each, float(by)) for each, by in zip(samples, best, strict=True)]
    return samples


def make_code(samples: Sequence[Sample], reach: Floats) -> Code:
    """The code of all samples of a skeleton."""
    return Code(mean_turns(np.concatenate([each.turns for each in samples])), reach)


def fit_space(
    samples: Sequence[Sample], code: Code, styles: Sequence[str], params: SpaceParams, degree: int
) -> GaitSpace:
    """The space of the cycles of one gait.

    Args:
        samples: cycles of one gait, aligned.
        code: what makes numbers of them.
        styles: names of the styles; the plain one has none.
        params: how many components are kept.
        degree: of the map from speed to cycle.
    """
    rows = code.rows(samples)
    n, flat = len(samples), rows.reshape(len(samples), -1)
    speed = np.array([each.speed for each in samples])
    share = _file_shares(samples)
    mean = np.average(flat, axis=0, weights=share)
    scale = np.tile(code.weights, PHASES)
    off = (flat - mean) * scale
    basis, variance = _principal(off * np.sqrt(share * n / share.sum())[:, None], params.components)
    ramp = Ramp(float(speed.min()), float(speed.max()), degree)
    style = style_weights(samples, styles)
    features = np.concatenate([ramp(speed), style], axis=1)
    mapped = _ridge(features, off @ basis.T, share, len(styles))
    components = (basis / np.maximum(scale, 1e-9)).reshape(len(basis), PHASES, -1)
    return GaitSpace(
        samples[0].gait, mean.reshape(PHASES, -1), components, ramp, mapped, tuple(styles),
        _frequency(samples, style, share), _contacts(samples, ramp, share), variance, n,
    )  # fmt: skip


def style_weights(samples: Sequence[Sample], styles: Sequence[str]) -> Floats:
    """(n, S) 1 where a sample is of a style."""
    return np.array([[float(each.style == name) for name in styles] for each in samples]).reshape(len(samples), -1)


def _file_shares(samples: Sequence[Sample]) -> Floats:
    """(n,) what each cycle counts: the root of its share of a file, so that long files do not drown the others."""
    names = [each.source for each in samples]
    return np.array([1.0 / np.sqrt(names.count(name)) for name in names])


def _principal(rows: Floats, most: int) -> tuple[Floats, Floats]:
    """(K, n) orthonormal rows, and the share of variance that each of them holds."""
    values, vectors = np.linalg.eigh(rows @ rows.T)
    order = np.argsort(values)[::-1]
    values, vectors = np.maximum(values[order], 0.0), vectors[:, order]
    share = values / max(values.sum(), 1e-300)
    keep = min(most, int(np.searchsorted(np.cumsum(share), _ENOUGH)) + 1, int(np.sum(share > 1e-9)) or 1)
    basis = vectors[:, :keep].T @ rows
    length = np.maximum(np.linalg.norm(basis, axis=1, keepdims=True), 1e-300)
    return np.asarray(basis / length), share[:keep]


def _ridge(features: Floats, values: Floats, share: Floats, styles: int) -> Floats:
    """(P, K) weighted least squares; styles are drawn to none."""
    draw = np.zeros(features.shape[1])
    draw[len(draw) - styles :] = _STYLE if styles else 0.0
    draw[1 : len(draw) - styles] = 1e-3
    weighted = features * share[:, None]
    square = features.T @ weighted + np.diag(draw) + 1e-9 * np.eye(len(draw))
    return np.asarray(np.linalg.solve(square, weighted.T @ values), dtype=np.float64)


def _frequency(samples: Sequence[Sample], style: Floats, share: Floats) -> Floats:
    """(2 + S,) the straight line of log frequency over log speed, and what styles add."""
    speed = np.log([each.speed for each in samples])
    features = np.concatenate([np.ones((len(speed), 1)), speed[:, None], style], axis=1)
    draw = np.concatenate([[0.0, 0.05], np.full(style.shape[1], _STYLE)])  # the slope of like speeds is the usual one
    middle = np.average(speed, weights=share)
    features[:, 1] -= middle
    weighted = features * share[:, None]
    values = np.log([each.frequency for each in samples])
    usual = 0.42  # what walkers of all sizes have
    square = features.T @ weighted + np.diag(draw) + 1e-12 * np.eye(len(draw))
    solved = np.asarray(np.linalg.solve(square, weighted.T @ (values - usual * features[:, 1])), dtype=np.float64)
    solved[1] += usual
    solved[0] -= solved[1] * middle
    return solved


def _contacts(samples: Sequence[Sample], ramp: Ramp, share: Floats) -> Floats:
    """(M, E, 2) start and duration of each effector's contact in the samples, as straight lines over the speed."""
    u = ramp.within(np.array([each.speed for each in samples]))
    spans = np.stack([each.contacts for each in samples])  # (n, E, 2)
    at = np.clip(np.linspace(-CONTACT_RANGE, CONTACT_RANGE, CONTACT_SPEEDS), -1.2, 1.2)
    wanted = np.stack([np.ones(len(at)), at], axis=1)
    out = np.zeros((len(at), spans.shape[1], 2))
    for e in range(spans.shape[1]):
        there = np.isfinite(spans[:, e, 0])
        if not there.any():
            continue
        line = np.stack([np.ones(len(u)), u], axis=1)
        out[:, e, 0] = wanted @ _line(line[there], spans[there, e, 0], share[there])
        lasts = wanted @ _line(line, np.where(there, spans[:, e, 1] - spans[:, e, 0], 0.0), share)
        out[:, e, 1] = np.clip(lasts, 0.0, 0.9)
    return out


def _line(features: Floats, values: Floats, share: Floats) -> Floats:
    weighted = features * share[:, None]
    square = features.T @ weighted + np.diag([1e-9, 0.02 * float(share.sum())])
    return np.asarray(np.linalg.solve(square, weighted.T @ values), dtype=np.float64)


def kernel(phases: Floats, n: int) -> Floats:
    """(T, n) weights of n even samples, of which a periodic function's values at phases (T,) are made.

    The function is the trigonometric polynomial through the samples, so that a cycle closes with all its derivatives.
    """
    # sin(n x) / (n tan(x)) with x = pi (phase - k / n), by the sines and cosines of both parts
    angle, own = np.pi * np.asarray(phases, dtype=np.float64), np.pi * np.arange(n) / n
    sine, cosine = np.sin(angle)[:, None], np.cos(angle)[:, None]
    below = sine * np.cos(own) - cosine * np.sin(own)
    above = cosine * np.cos(own) + sine * np.sin(own)
    small = np.abs(below) < 1e-9
    waves = np.sin(n * angle)[:, None] * np.where(np.arange(n) % 2, -1.0, 1.0)
    return np.where(small, 1.0, waves * above / np.where(small, 1.0, n * below))


__all__ = ["Code", "GaitSpace", "Ramp", "SpaceParams", "aligned", "fit_space", "kernel", "make_code", "shift_phases"]
