"""`footfix stream` as a process: pipes, sockets, and what goes wrong with them."""

from __future__ import annotations

import json
import os
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

import pytest
from conftest import SAMPLES, Run

from footfix.jobs.clean import clean_file
from footfix.settings import ReportParams, Settings

FILE = (SAMPLES / "walk_skate.bvh").read_bytes()
START = FILE.index(b"\n", FILE.index(b"Frame Time")) + 1
HEAD, ROWS = FILE[:START], FILE[START:].splitlines(keepends=True)
COMMAND = [sys.executable, "-m", "footfix", "stream"]
SHORT = HEAD.replace(b"Frames: 301", b"Frames: 120") + b"".join(ROWS[:120])
SETTINGS = Settings(report=ReportParams(kind="json"))
PATIENCE = 90.0  # [s]


def test_rows_come_out_while_others_still_come_in_and_the_count_is_put_right(tmp_path: Path) -> None:
    head = HEAD.replace(b"Frames: 301", b"Frames: 0")
    events = tmp_path / "events.jsonl"
    options = ["--events", str(events), "--calibrate", str(SAMPLES / "walk_skate.bvh")]
    process = subprocess.Popen([*COMMAND, *options], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    assert process.stdin is not None
    assert process.stdout is not None
    process.stdin.write(head + b"".join(ROWS[:60]))
    process.stdin.flush()
    lines = [process.stdout.readline() for _ in range(head.count(b"\n") + 40)]  # the input is still open
    process.stdin.write(b"".join(ROWS[60:90]) + ROWS[90][:30])
    out, _ = process.communicate(timeout=PATIENCE)
    assert process.returncode == 0
    assert b"".join(lines).startswith(head)
    assert (b"".join(lines) + out).count(b"\n") == head.count(b"\n") + 90
    told = [json.loads(line) for line in events.read_text(encoding="utf-8").splitlines()]
    assert {entry["event"] for entry in told} <= {"strike", "lift"}
    assert all(set(entry) == {"event", "effector", "frame", "time", "confidence"} for entry in told)


def test_waiting_for_the_end_writes_what_clean_writes(tmp_path: Path) -> None:
    whole = tmp_path / "whole.bvh"
    with whole.open("wb") as out:
        done = subprocess.run([*COMMAND, "--look-ahead", "inf"], input=SHORT, stdout=out, timeout=PATIENCE, check=False)
    assert done.returncode == 0
    assert whole.read_bytes() == clean_file(SHORT, "walk_skate.bvh", SETTINGS).motion


def test_broken_input_is_said_and_nothing_hangs(tmp_path: Path) -> None:
    bad = b"1 2 3\n" + b"nan " * len(ROWS[0].split()) + b"\n" + HEAD
    out = tmp_path / "out.bvh"
    text = HEAD.replace(b"Frames: 301", b"Frames: 0") + b"".join(ROWS[:20]) + bad + b"".join(ROWS[20:30])
    with out.open("wb") as written:
        done = subprocess.run(
            COMMAND, input=text, stdout=written, stderr=subprocess.PIPE, timeout=PATIENCE, check=False
        )  # fmt: skip
    assert done.returncode == 0
    for word in (b"3 numbers", b"no number", b"header came again"):
        assert word in done.stderr
    assert b"Traceback" not in done.stderr
    assert b"Frames: 31" in out.read_bytes()


def test_a_peer_that_is_killed_is_waited_for_again() -> None:
    process = subprocess.Popen(
        [*COMMAND, "--listen", "tcp://127.0.0.1:0", "--calibrate", str(SAMPLES / "walk_skate.bvh")],
        stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
    )  # fmt: skip
    try:
        assert process.stderr is not None
        port = int(process.stderr.readline().rsplit(b":", 1)[1])
        with socket.create_connection(("127.0.0.1", port), timeout=PATIENCE) as peer:
            peer.sendall(b"".join(b"0 Char00 " + row.strip() + b"||" for row in ROWS[:40]))
            assert peer.recv(200).startswith(b"HIERARCHY")
            peer.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, b"\1\0\0\0\0\0\0\0")  # as a killed process goes
        with socket.create_connection(("127.0.0.1", port), timeout=PATIENCE) as peer:
            peer.settimeout(PATIENCE)
            peer.sendall(b"\xff\x00 garbage \n" + b"".join(ROWS[:40]))
            back = b""
            while back.count(b"\n") < HEAD.count(b"\n") + 20:
                back += peer.recv(1 << 16)
    finally:
        time.sleep(0.1)
        process.send_signal(signal.SIGINT)
        _, said = process.communicate(timeout=PATIENCE)
    assert process.returncode == 130
    assert b"Traceback" not in said
    assert b"waiting for another" in said
    assert b"connected: 127.0.0.1:" in said
    assert b"connected: 127.0.0.1:0\n" not in said, "the port of the peer, not the one that was asked for"


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (["--look-ahead", "soon"], "no time in seconds"),
        (["--events", "-"], "name a file for the rows"),
        (["--listen", "udp://127.0.0.1:1"], "only tcp://"),
        (["--connect", "here"], "HOST:PORT"),
    ],
)
def test_options_that_make_no_sense_are_refused(
    options: list[str], says: str, run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    with Path(os.devnull).open() as nothing:
        monkeypatch.setattr(sys, "stdin", nothing)
        code, _, said = run("stream", *options)
    assert code == 2
    assert says in said
