"""Queues between threads stay short, whoever is slow."""

from __future__ import annotations

import threading
import time

from footfix.stream.backlog import WAITING, Backlog, Outlet


def test_the_oldest_items_are_dropped_and_counted() -> None:
    backlog = Backlog(drops=True, droppable=lambda item: item != "header")
    backlog.put("header")
    for number in range(3 * WAITING):
        backlog.put(number)
    assert backlog.dropped == 2 * WAITING + 1
    assert backlog.get() == "header"
    assert backlog.get() == 2 * WAITING + 1


def test_who_puts_waits_where_nothing_may_be_dropped() -> None:
    backlog, done = Backlog(drops=False), []
    thread = threading.Thread(target=lambda: done.extend(backlog.put(k) for k in range(2 * WAITING)))
    thread.start()
    assert [backlog.get() for _ in range(2 * WAITING)] == list(range(2 * WAITING))
    thread.join(5.0)
    assert len(done) == 2 * WAITING


def test_a_closed_backlog_lets_go_of_those_who_wait() -> None:
    backlog = Backlog(drops=False)
    for k in range(WAITING):
        backlog.put(k)
    thread = threading.Thread(target=lambda: backlog.put("one more"))
    thread.start()
    backlog.close(now=True)
    thread.join(5.0)
    assert not thread.is_alive()
    assert backlog.get(0.01) is None


def test_a_slow_reader_costs_frames_and_no_memory() -> None:
    free = threading.Event()

    def wait(data: bytes) -> None:
        free.wait(10.0)

    outlet = Outlet(wait)
    for _ in range(4 * WAITING):
        outlet.put(b"row\n")
    assert outlet.dropped >= 3 * WAITING - 1
    free.set()
    outlet.close()


def test_a_reader_that_is_gone_is_noticed() -> None:
    def refuse(data: bytes) -> None:
        raise BrokenPipeError

    outlet = Outlet(refuse)
    outlet.put(b"row\n")
    for _ in range(100):
        if outlet.gone:
            break
        time.sleep(0.01)
    assert outlet.gone
