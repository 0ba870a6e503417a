"""Work on several processors: the same results in order, faults that come through, and one thread where it is asked."""

from __future__ import annotations

import multiprocessing
import threading
from functools import partial

import numpy as np
import pytest

from footfix.motion import threads
from footfix.motion.threads import LONG, at_once, halves, processors


@pytest.fixture
def two(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two processors, wherever the tests run."""
    monkeypatch.setattr(threads.os, "sched_getaffinity", lambda of: {0, 1}, raising=False)


def meet(barrier: threading.Barrier, k: int) -> int:
    barrier.wait(timeout=10.0)
    return k


@pytest.mark.usefixtures("two")
@pytest.mark.parametrize("count", [2, 4, 6])
def test_tasks_run_beside_each_other_and_results_are_in_their_order(count: int) -> None:
    barrier = threading.Barrier(2)  # only two at once get past it
    assert at_once([partial(meet, barrier, k) for k in range(count)], LONG) == list(range(count))


@pytest.mark.usefixtures("two")
def test_short_arrays_and_parts_of_parts_stay_on_one_thread() -> None:
    def here() -> int:
        return threading.get_ident()

    assert set(at_once([here, here], LONG - 1)) == {here()}
    assert all(len(set(each)) == 1 for each in at_once([partial(at_once, [here, here], LONG)] * 2, LONG))
    assert processors() == 2, "and afterwards there are two again"


@pytest.mark.usefixtures("two")
def test_a_program_that_cleans_several_clips_at_once_keeps_to_its_threads() -> None:
    found: list[int] = []
    thread = threading.Thread(target=lambda: found.append(processors()))
    thread.start()
    thread.join()
    assert found == [1]


def test_a_worker_process_keeps_to_one_processor() -> None:
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        assert pool.apply(processors) == 1


@pytest.mark.usefixtures("two")
@pytest.mark.parametrize("which", [0, 1])
def test_a_fault_comes_through_from_any_thread(which: int) -> None:
    def fail() -> None:
        raise ValueError("as it was to")

    tasks = [lambda: None, lambda: None]
    tasks[which] = fail
    with pytest.raises(ValueError, match="as it was to"):
        at_once(tasks, LONG)


@pytest.mark.usefixtures("two")
def test_numpy_treats_errors_alike_in_all_threads() -> None:
    with np.errstate(divide="raise", over="ignore"):
        first, second = at_once([np.geterr, np.geterr], LONG)
        assert first == second == np.geterr()


@pytest.mark.parametrize("count", [0, 1, 2, 7])
def test_halves_are_all_of_it(count: int) -> None:
    first, second = halves(count)
    assert [*range(count)[first], *range(count)[second]] == list(range(count))
