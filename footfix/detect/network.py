"""The small temporal network that weighs the evidence: what each foot does at each moment, as probabilities.

Two layers of a dozen units that look a third of a second ahead and behind. Its numbers stand in `weights.txt`,
made by `benchmarks/fit_auto.py`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from footfix.motion.clip import Floats

# The states of a foot, in the order of the network's answers.
SWING, HEEL, FLAT, TOE = range(4)


@dataclass(frozen=True, eq=False)
class Network:
    """The numbers of the network.

    Args:
        taps: (T,) grid steps ahead of now (before it, where negative) at which evidence is looked at.
        mean, spread: (E,) by which evidence is centred and scaled.
        hidden: (T, E, H) and its bias (H,).
        mixing: (H, M) and its bias (M,).
        answer: (M, 4) and its bias (4,).
    """

    taps: tuple[int, ...]
    mean: Floats
    spread: Floats
    hidden: Floats
    hidden_bias: Floats
    mixing: Floats
    mixing_bias: Floats
    answer: Floats
    answer_bias: Floats

    def logits(self, evidence: Floats) -> Floats:
        """Compute the log probabilities (n, 4) of the states from evidence (n, E); the ends are held."""
        n, reach = len(evidence), max(abs(tap) for tap in self.taps)
        seen = np.pad((evidence - self.mean) / self.spread, ((reach, reach), (0, 0)), mode="edge")
        total = np.broadcast_to(self.hidden_bias, (n, len(self.hidden_bias))).copy()
        for tap, weights in zip(self.taps, self.hidden, strict=True):
            total += seen[reach + tap : reach + tap + n] @ weights
        mixed = np.tanh(np.tanh(total) @ self.mixing + self.mixing_bias)
        z = mixed @ self.answer + self.answer_bias
        z -= z.max(axis=1, keepdims=True)
        return np.asarray(z - np.log(np.exp(z).sum(axis=1, keepdims=True)))
