"""Work spread over frames: all of it is done in time, and no frame does much more than another."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from footfix.stream.scheduling import SpreadWork


def counted(parts: int, done: list[int]) -> Iterator[None]:
    for k in range(parts):
        done.append(k)
        yield


@pytest.mark.parametrize("frames", [1, 3, 4, 8])
def test_parts_are_done_in_turn_and_in_time(frames: int) -> None:
    spread, done = SpreadWork(8, frames), list[int]()
    for _ in range(3):
        done.clear()
        spread.begin(counted(8, done))
        most = 0
        for _ in range(frames):
            before = len(done)
            spread.advance()
            most = max(most, len(done) - before)
        assert done == list(range(8))
        assert most == -(-8 // frames)


def test_less_work_is_done_the_sooner_and_the_rest_when_all_ends() -> None:
    spread, done = SpreadWork(8, 8), list[int]()
    spread.begin(counted(3, done))
    for _ in range(20):
        spread.advance()
    assert done == [0, 1, 2]
    done.clear()
    spread.begin(counted(5, done))
    spread.advance()
    assert len(done) == 1
    spread.finish()
    assert done == list(range(5))
