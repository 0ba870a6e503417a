"""The small neural network that turns evidence into probabilities of each foot's state at each time.

It has two layers of a dozen units and sees a third of a second ahead and behind. Its weights are in `weights.txt`,
written by `benchmarks/fit_auto.py`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from footfix.motion.clip import Floats

# The states of a foot, in the order of the network's outputs.
SWING, HEEL, FLAT, TOE = range(4)


@dataclass(frozen=True, eq=False)
class Network:
    """The weights of the network.

    Args:
        taps: (T,) grid steps after the present (before it, where negative) at which evidence is sampled.
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
        """Compute the log probabilities (n, 4) of the states from evidence (n, E), constant beyond its ends."""
        n, reach = len(evidence), max(abs(tap) for tap in self.taps)
        seen = np.pad((evidence - self.mean) / self.spread, ((reach, reach), (0, 0)), mode="edge")
        total = np.broadcast_to(self.hidden_bias, (n, len(self.hidden_bias))).copy()
        for tap, weights in zip(self.taps, self.hidden, strict=True):
            total += seen[reach + tap : reach + tap + n] @ weights
        mixed = np.tanh(np.tanh(total) @ self.mixing + self.mixing_bias)
        z = mixed @ self.answer + self.answer_bias
        z -= z.max(axis=1, keepdims=True)
        return np.asarray(z - np.log(np.exp(z).sum(axis=1, keepdims=True)))
