"""The newest rows of a track that grows, in memory that does not."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from footfix.stream.ring_buffer import Ring


@given(st.lists(st.integers(0, 40), max_size=30), st.integers(1, 25))
@settings(max_examples=30, deadline=None)
def test_the_newest_rows_are_those_that_were_appended(pieces: list[int], capacity: int) -> None:
    ring, whole = Ring((2,), capacity), np.arange(2.0 * sum(pieces)).reshape(-1, 2)
    at = 0
    for piece in pieces:
        ring.append(whole[at : at + piece])
        at += piece
    assert ring.end == len(whole)
    assert ring.end - ring.start >= min(capacity, len(whole))
    assert np.array_equal(ring.view(ring.start), whole[ring.start :])
    assert np.array_equal(ring.last(capacity), whole[-capacity:])


def test_memory_stays_as_it_is() -> None:
    ring = Ring((3,), 10)
    size = ring._rows.nbytes
    for k in range(1000):
        ring.append(np.full((3, 3), k))
    assert ring._rows.nbytes == size


def test_rows_are_replaced_from_a_number_on() -> None:
    ring = Ring((1,), 8)
    ring.append(np.arange(6.0)[:, None])
    ring.replace(4, np.array([[40.0], [50.0], [60.0]]))
    assert ring.view(0).ravel().tolist() == [0, 1, 2, 3, 40, 50, 60]
