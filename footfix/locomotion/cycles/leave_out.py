"""Leave-one-file-out errors of a space of cycles."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from footfix.locomotion.cycles.eigencycles import Code, GaitSpace
from footfix.locomotion.cycles.fit_space import SpaceParams, fit_space, style_weights
from footfix.locomotion.cycles.samples import Sample
from footfix.motion.clip import Clip, Floats, Skeleton
from footfix.motion.kinematics import places


@dataclass(frozen=True)
class LeftOut:
    """Errors of cycles whose file was left out, the mean distance of joints over all phases.

    Args:
        predicted: [m] error of the cycle made for their speed and style.
        nearest: [m] error of the captured cycle of another file nearest in speed, of the same gait and style.
        mean: [m] error of the mean cycle of the gait.
        frequency: mean error of the frequency, as a share of it.
        cycles: number of cycles predicted.
    """

    predicted: float
    nearest: float
    mean: float
    frequency: float
    cycles: int


def joint_places(rows: Floats, code: Code, skeleton: Skeleton, root: int, leg_length: float) -> Floats:
    """Compute the joints (n, N, J, 3) [m] of cycles (n, N, D) on the spot, without the joints above the root."""
    count, phases, _ = rows.shape
    flat = rows.reshape(count * phases, -1)
    turns = code.turns(flat)
    above = skeleton.ancestors(root)
    offsets = skeleton.offsets * (~np.isin(np.arange(len(skeleton)), above))[:, None]
    at = [np.broadcast_to(offset, (len(flat), 3)) for offset in offsets]
    at[root] = leg_length * flat[:, :3]
    still = np.broadcast_to(np.array([0.0, 0.0, 0.0, 1.0]), (len(flat), 4))
    turn = [still if joint in above[1:] else turns[:, joint] for joint in range(len(skeleton))]
    seen = places(Clip.from_tracks(skeleton, at, turn, 1.0))
    return seen[:, [j for j in range(len(skeleton)) if j not in above[1:]]].reshape(count, phases, -1, 3)


def degree_for(samples: Sequence[Sample], code: Code, styles: Sequence[str], params: SpaceParams) -> int:
    """Choose the degree of the map from speed to cycle with the least error on files left out; 1 for too few files."""
    speeds = [each.speed for each in samples]
    files = {each.source for each in samples}
    most = 2 if max(speeds) > 1.5 * min(speeds) and len(files) >= 6 else 1
    if len(files) < 3:
        return most if len(files) > 1 else 1
    real = code.rows(samples) * code.weights
    errors = {}
    for degree in range(1, most + 1):
        told = predictions(samples, code, styles, params, degree)[0] * code.weights
        errors[degree] = float(np.mean((told - real) ** 2))
    return min(errors, key=lambda degree: errors[degree])


def predictions(
    samples: Sequence[Sample], code: Code, styles: Sequence[str], params: SpaceParams, degree: int
) -> tuple[Floats, Floats, Floats]:
    """Predict cycles (n, N, D) and frequencies (n,) from spaces without their files; and these spaces' mean cycles."""
    told, means = np.zeros((2, len(samples), samples[0].places.shape[0], 3 * (len(code.reach) + 1)))
    frequencies = np.zeros(len(samples))
    for source in sorted({each.source for each in samples}):
        own = [k for k, each in enumerate(samples) if each.source == source]
        rest = [each for each in samples if each.source != source]
        if not rest:
            continue
        space = fit_space(rest, code, styles, params, degree)
        weights = style_weights([samples[k] for k in own], styles)
        speed = np.array([samples[k].speed for k in own])
        told[own] = np.stack([space.cycle(v, w) for v, w in zip(speed, weights, strict=True)])
        frequencies[own] = space.frequencies(speed, weights)
        means[own] = space.mean
    return told, frequencies, means


def leave_out(
    gaits: Sequence[Sequence[Sample]], spaces: Sequence[GaitSpace], code: Code, params: SpaceParams,
    skeleton: Skeleton, root: int, leg_length: float,
) -> LeftOut:  # fmt: skip
    """Compute the errors with every file left out once.

    Args:
        gaits: the samples of each gait.
        spaces: of each gait, fitted to all of its samples.
        code: what makes numbers of cycles.
        params: of the spaces.
        skeleton, root, leg_length: the figure on which errors are measured [m].
    """
    errors, off = [], []
    for samples, space in zip(gaits, spaces, strict=True):
        if len({each.source for each in samples}) < 2:
            continue
        told, frequencies, means = predictions(samples, code, space.styles, params, space.ramp.degree)
        rows = code.rows(samples)
        nearest = rows[[_nearest(k, samples) for k in range(len(samples))]]
        real, *others = (joint_places(each, code, skeleton, root, leg_length) for each in (rows, told, nearest, means))
        errors.append(np.stack([np.linalg.norm(each - real, axis=-1).mean(axis=(1, 2)) for each in others], axis=1))
        own = np.array([each.frequency for each in samples])
        off.append(np.abs(frequencies / own - 1.0))
    if not errors:
        return LeftOut(np.nan, np.nan, np.nan, np.nan, 0)
    every = np.concatenate(errors)
    predicted, nearest, mean = every.mean(axis=0).tolist()
    return LeftOut(predicted, nearest, mean, float(np.mean(np.concatenate(off))), len(every))


def _nearest(k: int, samples: Sequence[Sample]) -> int:
    """Find the cycle of another file nearest in speed, of the same style where there is one."""
    own = samples[k]
    others = [j for j, each in enumerate(samples) if each.source != own.source]
    alike = [j for j in others if samples[j].style == own.style]
    return min(alike or others, key=lambda j: abs(samples[j].speed - own.speed))
