"""Fit the space of a gait to captured cycles: principal components, and coefficients by speed and style.

Source: P. Glardon, R. Boulic, D. Thalmann, Robust on-line adaptive footplant detection and enforcement for
locomotion, The Visual Computer 22 (2006), section 3.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from footfix.locomotion.cycles.eigencycles import CONTACT_RANGE, CONTACT_SPEEDS, Code, GaitSpace, Ramp
from footfix.locomotion.cycles.samples import PHASES, Sample, mean_turns, shifted
from footfix.motion.clip import Floats

_ALIGNED = 0.08  # [of a cycle] greatest shift that aligns a cycle with the others
_ROUNDS = 3  # of alignment
_STYLE = 0.3  # [files] weight of the prior that a style changes nothing, which matters for styles of few files,
_CADENCE = 0.1  # and for their frequency: it differs four times as much between people as between files of one
_ENOUGH = 0.98  # share of the variance that the components hold
_USUAL = 0.42  # slope of log frequency over log speed, alike in walkers of all sizes


@dataclass(frozen=True, kw_only=True)
class SpaceParams:
    """How a space is fitted to cycles.

    Args:
        components: greatest number of components of a gait [components].
        degree: of the map from speed to cycle; None to choose it by the error on files left out [1].
    """

    components: int = 20
    degree: int | None = None


def aligned(samples: Sequence[Sample], code: Code) -> list[Sample]:
    """Align cycles by small phase shifts, within the uncertainty of strikes; phase 0 stays the mean strike.

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
    """Make the code of all samples of a skeleton."""
    return Code(mean_turns(np.concatenate([each.turns for each in samples])), reach)


def fit_space(
    samples: Sequence[Sample], code: Code, styles: Sequence[str], params: SpaceParams, degree: int
) -> GaitSpace:
    """Fit the space of the cycles of one gait.

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
    """Mark with 1 the style of each sample, (n, S)."""
    return np.array([[float(each.style == name) for name in styles] for each in samples]).reshape(len(samples), -1)


def _file_shares(samples: Sequence[Sample]) -> Floats:
    """Weigh each cycle (n,) by the root of its share of a file, so that long files do not outweigh the others."""
    names = [each.source for each in samples]
    return np.array([1.0 / np.sqrt(names.count(name)) for name in names])


def _principal(rows: Floats, most: int) -> tuple[Floats, Floats]:
    """Find orthonormal rows (K, n), and the share of variance that each of them holds."""
    values, vectors = np.linalg.eigh(rows @ rows.T)
    order = np.argsort(values)[::-1]
    values, vectors = np.maximum(values[order], 0.0), vectors[:, order]
    share = values / max(values.sum(), 1e-300)
    keep = min(most, int(np.searchsorted(np.cumsum(share), _ENOUGH)) + 1, int(np.sum(share > 1e-9)) or 1)
    basis = vectors[:, :keep].T @ rows
    length = np.maximum(np.linalg.norm(basis, axis=1, keepdims=True), 1e-300)
    return np.asarray(basis / length), share[:keep]


def _ridge(features: Floats, values: Floats, share: Floats, styles: int) -> Floats:
    """Fit (P, K) by ridge regression: weighted least squares in which the styles are drawn to zero."""
    draw = np.zeros(features.shape[1])
    draw[len(draw) - styles :] = _STYLE if styles else 0.0
    draw[1 : len(draw) - styles] = 1e-3
    weighted = features * share[:, None]
    square = features.T @ weighted + np.diag(draw) + 1e-9 * np.eye(len(draw))
    return np.asarray(np.linalg.solve(square, weighted.T @ values), dtype=np.float64)


def _frequency(samples: Sequence[Sample], style: Floats, share: Floats) -> Floats:
    """Fit a straight line to log frequency over log speed, with an offset for each style, (2 + S,)."""
    speed = np.log([each.speed for each in samples])
    features = np.concatenate([np.ones((len(speed), 1)), speed[:, None], style], axis=1)
    # where all speeds are alike, the slope stays near the usual one
    draw = np.concatenate([[0.0, 0.05], np.full(style.shape[1], _CADENCE)])
    middle = np.average(speed, weights=share)
    features[:, 1] -= middle
    weighted = features * share[:, None]
    values = np.log([each.frequency for each in samples])
    square = features.T @ weighted + np.diag(draw) + 1e-12 * np.eye(len(draw))
    solved = np.asarray(np.linalg.solve(square, weighted.T @ (values - _USUAL * features[:, 1])), dtype=np.float64)
    solved[1] += _USUAL
    solved[0] -= solved[1] * middle
    return solved


def _contacts(samples: Sequence[Sample], ramp: Ramp, share: Floats) -> Floats:
    """Fit start and duration of each effector's contact as straight lines over the speed, (M, E, 2)."""
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
