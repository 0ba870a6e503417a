"""An interrupt ends a stream whenever it comes, in bounded time, and what was written is whole."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from contextlib import suppress
from pathlib import Path
from typing import IO

import pytest
from conftest import SAMPLES
from streams import sample

from footfix.settings import Settings
from footfix.stream.backlog import Backlog
from footfix.stream.bvh_lines import Lines
from footfix.stream.interrupts import interrupts
from footfix.stream.run import Run, Sink, Talk
from footfix.stream.session import StreamParams

pytestmark = pytest.mark.skipif(os.name == "nt", reason="signals are sent as on POSIX")

FILE = (SAMPLES / "walk_skate.bvh").read_bytes()
START = FILE.index(b"\n", FILE.index(b"Frame Time")) + 1
HEAD, ROWS = FILE[:START].replace(b"Frames: 301", b"Frames: 0"), FILE[START:].splitlines(keepends=True)
PATIENCE = 90.0  # [s]
# as a script starts what it ends with `&`
DEAF = "import signal; signal.signal(signal.SIGINT, signal.SIG_IGN); from footfix.cli import main; main()"


class Dying:
    """Sends an interrupt where Python drops exceptions."""

    def __del__(self) -> None:
        signal.raise_signal(signal.SIGINT)


def interrupted(path: Path, items: list[object], after: float | None = None) -> tuple[bool, bytes]:
    """Stream to a file, with an interrupt after some seconds; whether it was seen, and what was written."""
    backlog = Backlog(drops=False)
    for item in items:
        backlog.put(item)
    items.clear()
    seen = False
    with path.open("wb", buffering=0) as out, interrupts() as state:
        run = Run(Settings(), StreamParams(), sample("walk_skate"), Sink(out, drops=False), None,
                  Talk(lambda text: None), None, state)  # fmt: skip
        timer = threading.Timer(after or 0.0, os.kill, (os.getpid(), signal.SIGINT))
        if after is not None:
            timer.start()
        try:
            run.run(backlog, [])
        except KeyboardInterrupt:
            seen = True
        if after is not None:
            timer.join()
    return seen, path.read_bytes()


@pytest.mark.parametrize("after", [0.01, 0.2, 0.5])
def test_whenever_it_comes_what_was_written_is_whole(after: float, tmp_path: Path) -> None:
    seen, written = interrupted(tmp_path / "out.bvh", list(Lines().feed(HEAD + b"".join(ROWS[:100]))), after)
    assert seen
    rows = written[len(HEAD) + 9 :].splitlines(keepends=True)  # its count of frames has room for nine digits more
    assert not written or b"Frames: %d " % len(rows) in written
    assert all(len(row.split()) == len(ROWS[0].split()) and row.endswith(b"\n") for row in rows)


def test_one_that_comes_where_exceptions_are_dropped_is_not_lost(tmp_path: Path) -> None:
    items: list[object] = [
        *Lines().feed(HEAD + b"".join(ROWS[:20])),
        Dying(),
        *Lines(sample("walk_skate")).feed(b"".join(ROWS[20:40])),
    ]
    seen, written = interrupted(tmp_path / "out.bvh", items)
    assert seen
    assert b"Frames: 21 " in written  # it dies when the row after it takes its name


def test_handlers_are_put_back() -> None:
    before = signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGTERM)
    with interrupts() as state:
        assert signal.getsignal(signal.SIGINT) is not before[0]
    assert not state.came
    assert (signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGTERM)) == before


def test_the_end_is_bounded_whatever_is_waited_for() -> None:
    code = """
import os, signal, threading
from footfix.stream.interrupts import interrupts
with interrupts(0.3):
    os.kill(os.getpid(), signal.SIGTERM)
    lock = threading.Lock()
    lock.acquire()
    lock.acquire()
"""
    assert subprocess.run([sys.executable, "-c", code], timeout=PATIENCE, check=False).returncode == 130


def test_the_second_one_ends_at_once_a_stream_that_nobody_reads() -> None:
    process = subprocess.Popen(
        [sys.executable, "-c", DEAF, "stream", "--calibrate", str(SAMPLES / "walk_skate.bvh")],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
    )  # fmt: skip
    assert process.stdin is not None
    assert process.stdout is not None
    threading.Thread(target=_feed, args=(process.stdin, FILE), daemon=True).start()
    process.stdout.read(len(HEAD) + 10)  # rows come out, and then nobody takes them
    process.send_signal(signal.SIGINT)
    time.sleep(0.3)
    process.send_signal(signal.SIGINT)
    assert process.wait(PATIENCE) == 130
    process.stdout.close()


def _feed(stdin: IO[bytes], data: bytes) -> None:
    with suppress(OSError):
        stdin.write(data)
        stdin.close()
