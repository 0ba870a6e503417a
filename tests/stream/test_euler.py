"""Angles of few rotations are those of a clip's."""

from __future__ import annotations

from itertools import permutations

import numpy as np
import pytest

from footfix.motion import rotation
from footfix.stream.euler import to_euler


@pytest.mark.parametrize("order", list(permutations(range(3))))
def test_angles_are_those_of_a_clip(order: tuple[int, ...]) -> None:
    rng = np.random.default_rng(7)
    near = rng.normal(size=(40, 3, 3)) * 3.0
    q = rotation.normalize(rng.normal(size=(40, 3, 4)))
    letters = "".join("XYZ"[axis] for axis in order)
    assert np.allclose(to_euler(q, order, near), rotation.to_euler(q, letters, near=near), atol=1e-9)
    near[3, 0, 1] = np.pi / 2  # locked: the first and the last axis are one
    q[3, 0] = rotation.from_euler(near[3, 0], letters)
    assert np.allclose(to_euler(q, order, near), rotation.to_euler(q, letters, near=near), atol=1e-6)
