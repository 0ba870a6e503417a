"""A foot that another program holds to the digit and lets go with a snap is in contact while it rests."""

from __future__ import annotations

import numpy as np

from footfix.detect.foot_locks import let_go
from footfix.detect.tracks import FootTracks, Tracks
from footfix.motion.clip import Floats


def of(point: Floats, size: float = 1.0) -> Tracks:
    still = np.zeros_like(point)
    return Tracks(still, (FootTracks("left", still, still, still, point),), 0.9 * size, 1.0 / 30.0)


def walked(steps: list[float]) -> Floats:
    return np.outer(np.cumsum(np.concatenate([[0.0], steps])), [0.6, 0.0, 0.8])


def test_a_contact_ends_where_the_rest_does_if_the_foot_snaps_away() -> None:
    rest, drift = [0.0] * 12, [0.004] * 3
    mask = np.zeros((40, 2), dtype=np.bool_)
    for steps, expected in (
        ([0.05] * 10 + rest + [0.03, *drift] + [0.05] * 13, (10, 23)),  # goes with a snap
        ([0.05] * 7 + [*drift] + rest + drift + [0.05] * 14, (8, 26)),  # drifts away
        ([0.05] * 8 + [0.004, 0.03] + rest + [0.05] * 17, (10, 23)),  # comes with one
        ([0.05] * 8 + [0.004, 0.03] + [0.0] * 3 + [0.002] * 12 + [0.05] * 14, (8, 26)),  # hardly rests
    ):
        own = mask.copy()
        own[8:26, 1] = True
        point = walked(steps[:39])
        found = np.flatnonzero(let_go(own, of(point))[:, 1])
        first = expected[0] if np.linalg.norm(np.diff(point[8:26], axis=0), axis=1)[0] > 0.0 else 8
        assert (int(found[0]), int(found[-1]) + 1) == (first, expected[1])
        assert np.array_equal(let_go(own, of(7.0 * point, 7.0)), let_go(own, of(point)))  # whatever the unit
