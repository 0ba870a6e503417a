"""Work for worker processes in tests; they import it by name, so it lies in a module of its own."""

from __future__ import annotations

import os
import signal
import time
from pathlib import Path

from footfix.batch.one_file import clean_one
from footfix.batch.output_paths import Job
from footfix.batch.task import FileResult, Task
from footfix.settings import Settings


def task(name: str, target: Path | None = None) -> Task:
    """A task that is nothing but a name."""
    return Task(Job(name, target, None, name), Settings())


def act(task: Task) -> FileResult:
    """Does what the name of the clip says."""
    name = task.job.source
    if name.startswith("die"):
        os.kill(os.getpid(), signal.SIGKILL if hasattr(signal, "SIGKILL") else signal.SIGTERM)
    if name.startswith("leave"):
        os._exit(7)
    if name.startswith("sleep"):
        time.sleep(60.0)
    if name.startswith("nap"):
        time.sleep(0.3)
    if name.startswith("stand"):
        time.sleep(2.0)
    return FileResult(name, "done")


def clean_or_die_once(task: Task) -> FileResult:
    """Cleans; but the first worker that comes to the marked clip is killed in the middle of it."""
    marker = Path(task.folder, "died")
    if task.job.name.startswith("b") and not marker.exists():
        marker.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return clean_one(task)
