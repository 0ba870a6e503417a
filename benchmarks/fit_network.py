"""Fits the network of `footfix.detect.network` by gradient descent, and writes its numbers as a table.

The truth says of a moment which states a foot may be in: plates know only that some part of it stands, a made
walker knows which. So the loss of a moment is minus the logarithm of the probability of all allowed states.
A few large committees of networks are fitted first; the one that is kept learns from their joint answers, also
where the truth is silent, which keeps it from learning any one person's feet by heart.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from footfix.detect.evidence import COLUMNS
from footfix.detect.network import Network
from footfix.detect.timing import Timing
from footfix.detect.weights import PARTS, TEN_THOUSANDTHS, THOUSANDTHS

Batch = NDArray[np.float32]

PAD = 40  # grid steps kept around each piece of evidence, so that taps never reach into the next


@dataclass(frozen=True, kw_only=True)
class FitParams:
    """How networks are fitted.

    Args:
        taps: grid steps at which evidence is looked at.
        hidden, mixing: units of the two layers.
        epochs: passes over all moments.
        batch: moments a step.
        rate: of Adam, falling as half a cosine.
        committee: networks that teach the one that is kept.
    """

    taps: tuple[int, ...] = (-30, -20, -14, -10, -7, -4, -2, 0, 2, 4, 7, 10, 14, 20, 30)
    hidden: int = 12
    mixing: int = 10
    epochs: int = 3
    batch: int = 4096
    rate: float = 3e-3
    committee: int = 5


@dataclass
class Moments:
    """Evidence of many clips in one array, and what is known of some of its moments.

    `target` (m, 4) holds either allowed states (0 or 1) or probabilities, for the moments `rows` of `curves`.
    """

    pieces: list[Batch] = field(default_factory=list)
    targets: list[Batch] = field(default_factory=list)
    weights: list[Batch] = field(default_factory=list)
    places: list[NDArray[np.intp]] = field(default_factory=list)
    length: int = 0

    def add(self, curves: Batch, target: Batch, weight: float) -> None:
        """One foot of one clip; moments of which everything is allowed say nothing and are left out."""
        telling = np.flatnonzero(~np.all(target == 1.0, axis=1))
        self.pieces.append(np.pad(curves, ((PAD, PAD), (0, 0)), mode="edge").astype(np.float32))
        self.places.append(telling + PAD + self.length)
        self.targets.append(target[telling].astype(np.float32))
        self.weights.append(np.full(len(telling), weight, dtype=np.float32))
        self.length += len(curves) + 2 * PAD


@dataclass
class Numbers:
    """A network while it learns: its arrays by name, in single precision."""

    taps: NDArray[np.intp]
    mean: Batch
    spread: Batch
    arrays: dict[str, Batch]

    def answer(self, seen: Batch) -> tuple[Batch, Batch, Batch]:
        """Both layers and the probabilities, of evidence (m, taps x columns)."""
        a = self.arrays
        first = np.tanh(seen @ a["hidden"] + a["hidden_bias"])
        second = np.tanh(first @ a["mixing"] + a["mixing_bias"])
        z = second @ a["answer"] + a["answer_bias"]
        e = np.exp(z - z.max(axis=1, keepdims=True))
        return first, second, e / e.sum(axis=1, keepdims=True)

    def over(self, curves: Batch) -> Batch:
        """The probabilities (n, 4) over a piece of evidence."""
        seen = np.pad((curves - self.mean) / self.spread, ((PAD, PAD), (0, 0)), mode="edge")
        at = np.arange(len(curves))[:, None] + PAD + self.taps
        return self.answer(seen[at].reshape(len(curves), -1))[2]

    def network(self) -> Network:
        a = {name: array.astype(np.float64) for name, array in self.arrays.items()}
        hidden = a.pop("hidden").reshape(len(self.taps), len(self.mean), -1)
        return Network(
            tuple(int(tap) for tap in self.taps), self.mean.astype(np.float64), self.spread.astype(np.float64),
            hidden=hidden, **a,
        )  # fmt: skip


def _fresh(random: np.random.Generator, moments: Moments, params: FitParams) -> Numbers:
    curves = np.concatenate(moments.pieces)[np.concatenate(moments.places)]
    shapes = {
        "hidden": (curves.shape[1] * len(params.taps), params.hidden),
        "mixing": (params.hidden, params.mixing),
        "answer": (params.mixing, 4),
    }
    arrays = {}
    for name, shape in shapes.items():
        arrays[name] = random.normal(0.0, shape[0] ** -0.5, shape).astype(np.float32)
        arrays[name + "_bias"] = np.zeros(shape[1], dtype=np.float32)
    return Numbers(np.array(params.taps), curves.mean(axis=0), curves.std(axis=0) + 1e-3, arrays)


def fit(moments: Moments, params: FitParams, seed: int) -> Numbers:
    """One network, by Adam (D. Kingma, J. Ba, 2015) on the moments."""
    random = np.random.default_rng(seed)
    numbers = _fresh(random, moments, params)
    curves = (np.concatenate(moments.pieces) - numbers.mean) / numbers.spread
    places, target = np.concatenate(moments.places), np.concatenate(moments.targets)
    weight = np.concatenate(moments.weights)
    weight /= weight.mean()
    first = {name: np.zeros_like(array) for name, array in numbers.arrays.items()}
    second = {name: np.zeros_like(array) for name, array in numbers.arrays.items()}
    batches = max(len(places) // params.batch, 1)
    steps = params.epochs * batches
    for step in range(1, steps + 1):
        if (step - 1) % batches == 0:
            order = random.permutation(len(places))
        at = (step - 1) % batches * params.batch
        chosen = order[at : at + params.batch]
        seen = curves[places[chosen][:, None] + numbers.taps].reshape(len(chosen), -1)
        gradients = _gradients(numbers, seen, target[chosen], weight[chosen])
        rate = params.rate * 0.5 * (1.0 + np.cos(np.pi * step / steps)) * min(1.0, step / 50)
        for name, gradient in gradients.items():
            first[name] = 0.9 * first[name] + 0.1 * gradient
            second[name] = 0.99 * second[name] + 0.01 * gradient**2
            towards = first[name] / (1 - 0.9**step) / (np.sqrt(second[name] / (1 - 0.99**step)) + 1e-8)
            numbers.arrays[name] = (numbers.arrays[name] - rate * towards).astype(np.float32)
    return numbers


def _gradients(numbers: Numbers, seen: Batch, target: Batch, weight: Batch) -> dict[str, Batch]:
    """Of minus the logarithm of the allowed states' probability; of the cross-entropy for probabilities."""
    a = numbers.arrays
    first, second, p = numbers.answer(seen)
    allowed = p * target
    soft = np.abs(target.sum(axis=1, keepdims=True) - 1.0) < 1e-3  # probabilities, or one state allowed
    wanted = np.where(soft, target, allowed / (allowed.sum(axis=1, keepdims=True) + 1e-9))
    back = (p - wanted) * weight[:, None] / len(seen)
    back_second = (back @ a["answer"].T) * (1.0 - second**2)
    back_first = (back_second @ a["mixing"].T) * (1.0 - first**2)
    return {
        "answer": second.T @ back, "answer_bias": back.sum(axis=0),
        "mixing": first.T @ back_second, "mixing_bias": back_second.sum(axis=0),
        "hidden": seen.T @ back_first, "hidden_bias": back_first.sum(axis=0),
    }  # fmt: skip


def fit_by_committee(moments: Moments, params: FitParams, seed: int) -> Network:
    """The network that is kept: it learns from what a committee says, and from the truth."""
    committee = [fit(moments, params, 1000 * seed + k) for k in range(params.committee)]
    taught = Moments()
    for piece, target, place, weight in zip(
        moments.pieces, moments.targets, _relative(moments), moments.weights, strict=True
    ):
        curves = piece[PAD:-PAD]
        said = np.mean([np.log(each.over(curves) + 1e-9) for each in committee], axis=0)
        said = np.exp(said) / np.exp(said).sum(axis=1, keepdims=True)
        known = said[place] * target
        said[place] = 0.5 * said[place] + 0.5 * known / (known.sum(axis=1, keepdims=True) + 1e-9)
        taught.add(curves, said.astype(np.float32), float(weight[0]) if len(weight) else 1.0)
    return fit(taught, params, seed).network()


def _relative(moments: Moments) -> list[NDArray[np.intp]]:
    """Places of the known moments within their own pieces."""
    starts = np.cumsum([0, *(len(piece) for piece in moments.pieces[:-1])])
    return [place - start - PAD for place, start in zip(moments.places, starts, strict=True)]


def rounded(network: Network) -> Network:
    """The network as it will be written: in thousandths."""
    names = ("mean", "spread", "hidden", "hidden_bias", "mixing", "mixing_bias", "answer", "answer_bias")
    return replace(network, **{name: np.round(getattr(network, name), 3) for name in names})


def table(network: Network, timing: Timing, said: str) -> str:
    """The text of `footfix/detect/weights.txt`, which `footfix.detect.weights` reads.

    Args:
        network, timing: what to write.
        said: lines on what they were fitted to.
    """

    def section(name: str, array: ArrayLike, scale: float = THOUSANDTHS) -> list[str]:
        rows = np.atleast_2d(np.round(scale * np.asarray(array)).astype(int)).tolist()
        return [f"[{name}]", *(" ".join(f"{v:5d}" for v in row) for row in rows)]

    lines = ["# Written by benchmarks/fit_auto.py.", *(f"# {line}" for line in said.splitlines())]
    lines += section("taps", network.taps, 1.0)
    for e, name in enumerate(COLUMNS):
        lines += section(f"{name}: mean, spread", [network.mean[e], network.spread[e]])
        lines += section(f"{name}: hidden", network.hidden[:, e])
    for part in PARTS:
        lines += section(part, getattr(network, part))
    for name, line in (("landing", timing.landing), ("leaving", timing.leaving)):
        lines += section(f"{name}: taps", line.taps, 1.0)
        lines += section(f"{name}: weights", line.weights, TEN_THOUSANDTHS)
        lines += section(f"{name}: bias, farthest", [line.bias, line.farthest], TEN_THOUSANDTHS)
    return "\n".join([*lines, ""])
