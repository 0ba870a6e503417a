"""What several tests share: the command line run in this process, and where the shared clips are."""

from __future__ import annotations

import compileall
import gc
import hashlib
import os
import pickle
import shutil
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

# One thread a process, as the command line has it: the tests run on all cores anyway, and threads of numpy that wait
# for each other took a third of the time of the tests of cycles. Numpy reads this once, when it is first imported.
for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")

import once  # noqa: E402
import pytest  # noqa: E402
from hypothesis import settings  # noqa: E402

from footfix import cli, pipeline  # noqa: E402
from footfix.batch import processes  # noqa: E402
from footfix.jobs import clean, contacts, fit_cycles, follow, inspect, loop, source  # noqa: E402
from footfix.locomotion.loop import run as loop_run  # noqa: E402
from footfix.report import pages  # noqa: E402

ROOT = Path(__file__).resolve().parent.parent
SHARED = Path(os.environ.get("FOOTFIX_SHARED", ROOT.parent / "shared"))
SAMPLES = ROOT / "sample_data"
Run = Callable[..., tuple[int, str, str]]  # a command line: exit code, standard output, standard error

# Rewritten test modules are kept for the next run, also where Python is told to keep no bytecode: making them again
# takes longer than all the rest of the collection. (This file stands before the others are rewritten.)
sys.dont_write_bytecode = False

# Examples are not timed: on a busy machine any of them may take long. They are half as many as by default: most of
# these tests run in every change to the code, and new examples come with each run.
settings.register_profile("untimed", deadline=None, max_examples=50)
settings.load_profile("untimed")


def pytest_sessionstart(session: pytest.Session) -> None:
    """Set a folder for what the processes of this run make once, and compile what each of them imports."""
    if not hasattr(session.config, "workerinput"):
        os.environ[once.FOLDER] = tempfile.mkdtemp(prefix="footfix-tests-")
        # where Python is told to keep no bytecode, each of some fifty processes would compile all of it
        compileall.compile_dir(ROOT / "footfix", quiet=2)


def pytest_collection_finish() -> None:
    """Keep what was imported and collected out of garbage collections, and have fewer: there is much, and it stays."""
    gc.freeze()
    gc.set_threshold(20_000, 20, 20)


def pytest_sessionfinish(session: pytest.Session) -> None:
    """Take it away again."""
    if not hasattr(session.config, "workerinput"):
        shutil.rmtree(os.environ.pop(once.FOLDER), ignore_errors=True)


def shared(folder: str) -> list[Path]:
    """The BVH files of a folder beside the project, sorted; empty where it is absent."""
    return sorted(path for path in (SHARED / folder).rglob("*") if path.suffix.lower() == ".bvh")


def one_of_each_origin(most: float = 1e6) -> list[Path]:
    """The smallest shared clip of each program or collection, of those up to a size [bytes]."""
    smallest: dict[Path, Path] = {}
    for path in shared("clips"):
        known = smallest.setdefault(path.parent, path)
        if path.stat().st_size < known.stat().st_size:
            smallest[path.parent] = path
    return [path for path in smallest.values() if path.stat().st_size <= most]


def need(paths: list[Path], folder: str) -> list[Path]:
    """The same paths; skips the test, saying so, where there are none."""
    if not paths:
        pytest.skip(f"no clips: {SHARED / folder} is absent")
    return paths


# Rooms, and tests of the lines of documents, whose tests are of what happens around the numeric steps.
DRIVEN = ("api", "batch", "cli", "report", "test_docs.py", "test_docstrings.py", "test_readme.py")
MANY_PROCESSES = ("test_dask.py", "test_processes.py")  # whose law is that each process makes the same
STEPS = (  # which take longest
    (pipeline, "detect_over"), (pipeline, "enforce"), (pipeline, "find_rigs"), (loop_run, "make_loop"),
    (source, "infer_units"),
    *((module, "find_rigs") for module in (clean, contacts, fit_cycles, follow, inspect, loop, pages)),
)  # fmt: skip


@pytest.fixture
def forking(monkeypatch: pytest.MonkeyPatch) -> None:
    """Fork worker processes where that can be done: a spawned one takes a second to load what a forked one has."""
    if sys.platform == "linux":
        monkeypatch.setattr(processes, "_way", lambda: "fork")


@pytest.fixture(autouse=True, scope="module")
def each_clip_once(request: pytest.FixtureRequest) -> Iterator[None]:
    """Place, detect and correct the same clip with the same settings once a run, where numbers are not the test's."""
    with pytest.MonkeyPatch.context() as patch:
        if {request.path.parent.name, request.path.name} & set(DRIVEN) and request.path.name not in MANY_PROCESSES:
            for module, name in STEPS:
                patch.setattr(module, name, _remembering(getattr(module, name)))
        yield


def _remembering(function: Callable[..., object]) -> Callable[..., object]:
    """Make a function that gives what it gave for the very same values before; they and it are never changed."""

    def remembered(*args: object, **more: object) -> object:
        key = hashlib.sha256(pickle.dumps((function.__name__, args, more))).hexdigest()
        return once.remembered(key, lambda: function(*args, **more))

    return remembered


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]) -> Run:
    """Run a command line in this process: its exit code, and what it wrote to standard output and error."""

    def call(*args: object) -> tuple[int, str, str]:
        monkeypatch.setattr(sys, "argv", ["footfix", *map(str, args)])
        code = cli.run()
        said = capfd.readouterr()
        return code, str(said.out), str(said.err)

    return call
