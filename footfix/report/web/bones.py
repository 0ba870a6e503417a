"""Which bones of a skeleton are drawn: all but lines to roots, targets and props that are no part of the body."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from footfix.motion.clip import Floats

_STRETCHES = 0.1  # of the figure's height: a line whose length changes by more is no bone
_PLACES = 200  # frames that are examined, at most


def bones_of(parents: Sequence[int], joints: int, places: Floats) -> tuple[tuple[int, int], ...]:
    """Choose the bones that are drawn.

    A root that stays at the origin while the figure walks away would be drawn as a pole to its hips, and one on the
    floor below them as a third leg. So the joints above the first one with two branches are left out, and so is every
    line whose length changes much over the clip (targets and props below such a root).

    Args:
        parents: (J,) -1 for a root; joints first, then End Sites.
        joints: how many of them are joints.
        places: (D, J, 3) [m] where they are.

    Returns:
        (parent, child) of each bone, in the order of the children.
    """
    hidden = _above_the_figure(parents, joints)
    pairs = [(parent, child) for child, parent in enumerate(parents) if parent >= 0 and child not in hidden]
    if not pairs or not len(places):
        return tuple(pairs)
    some = places[:: -(-len(places) // _PLACES)]
    ends = np.array(pairs)
    lengths = np.linalg.norm(some[:, ends[:, 1]] - some[:, ends[:, 0]], axis=2)  # (d, bones) [m]
    inside = some[:, np.unique(ends[:, 1])]
    height = float(np.median(np.ptp(inside[..., 1], axis=1)))
    steady = np.ptp(lengths, axis=0) <= _STRETCHES * max(height, 1e-6)
    kept = tuple(pair for pair, is_bone in zip(pairs, steady.tolist(), strict=True) if is_bone)
    return kept or tuple(pairs)


def _above_the_figure(parents: Sequence[int], joints: int) -> set[int]:
    """Find the joints whose line to their parent is left out: from each root to the first joint with two branches."""
    children: dict[int, list[int]] = {}
    for child, parent in enumerate(parents[:joints]):
        children.setdefault(parent, []).append(child)
    found: set[int] = set()
    for root in children.get(-1, []):
        chain, at = [], root
        while len(children.get(at, [])) == 1:
            (at,) = children[at]
            chain.append(at)
        if at in children:  # the chain ends in a branch; one that ends in a leaf is a figure itself
            found.update(chain)
    return found
