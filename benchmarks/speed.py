"""How long the job takes, stage by stage, beside a floor of plain numpy and beside other BVH libraries.

    python benchmarks/speed.py [--frames 20000] [--joints 31] [--against pybvh] [--against bvhio]

Makes its own clip (a walk that skates), times each stage in this process, then whole processes, and prints a table.
Figures are medians; compare them within one run only.
"""

from __future__ import annotations

import argparse
import importlib.util
import io
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

# As the command line does, before numpy starts: one thread a process.
os.environ.update(OMP_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1", MKL_NUM_THREADS="1")

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "sample_data"))

import artefacts
import exports
from walker import make
from walker_plan import Gait

from footfix.detect.run import detect
from footfix.enforce.correction import apply
from footfix.enforce.run import enforce
from footfix.formats.bvh import decode, rewrite
from footfix.jobs.clean import clean_file
from footfix.measure.clip import measure
from footfix.motion.clip import Clip, Skeleton
from footfix.motion.kinematics import forward
from footfix.motion.smoothing import savgol
from footfix.report.web.motion import film
from footfix.report.web.page import PageData, render
from footfix.rig.find import find_rig
from footfix.rig.units import infer_units
from footfix.settings import Settings

# Reading and writing alone, as a user of that library would do it.
PEERS = {
    "pybvh": "import pybvh, sys; b = pybvh.read_bvh_file(sys.argv[1]); pybvh.write_bvh_file(b, sys.argv[2])",
    "bvhio": "import bvhio, sys; bvhio.writeBvh(sys.argv[2], bvhio.readAsBvh(sys.argv[1]))",
}


def synthetic(frames: int, joints: int, fps: float = 120.0) -> bytes:
    """A walk that skates, with as many joints as asked for (fingers of the left hand make up the number)."""
    walk = make(Gait(name="walk", duration=min(frames / fps, 60.0), fps=fps)).clip
    skating = artefacts.wander(walk, 0.05)
    # A long clip is the walk there, back in time, and there again: it stays smooth and near the origin.
    there_and_back = np.concatenate([np.arange(len(skating)), np.arange(len(skating) - 2, 0, -1)])
    index = np.resize(there_and_back, frames)
    return exports.bvh(_with_fingers(skating.frames(index), joints))


def _with_fingers(clip: Clip, joints: int) -> Clip:
    skeleton = clip.skeleton
    more = joints - len(skeleton)
    if more <= 0:
        return clip
    hand = skeleton.names.index("LeftHand")
    parents = np.concatenate([skeleton.parents, np.full(more, hand)])
    offsets = np.concatenate([skeleton.offsets, np.tile([0.02, 0.0, 0.0], (more, 1))])
    larger = Skeleton(
        (*skeleton.names, *(f"Finger{k}" for k in range(more))),
        parents,
        offsets,
        skeleton.end_parents,
        skeleton.end_offsets,
    )
    rng = np.random.default_rng(1)
    positions = np.concatenate([clip.positions, np.broadcast_to(offsets[-more:], (len(clip), more, 3))], axis=1)
    wiggle = np.concatenate([rng.normal(0.0, 0.01, (len(clip), more, 3)), np.ones((len(clip), more, 1))], axis=2)
    wiggle /= np.linalg.norm(wiggle, axis=2, keepdims=True)
    return replace(clip, skeleton=larger, positions=positions, rotations=np.concatenate([clip.rotations, wiggle], 1))


def median_of(call: Callable[[], Any], runs: int) -> tuple[float, Any]:
    """Median time [s] of a call, and what it returned."""
    times = []
    for _ in range(runs):
        start = time.perf_counter()
        result = call()
        times.append(time.perf_counter() - start)
    return statistics.median(times), result


def stages(data: bytes, runs: int) -> list[tuple[str, float]]:
    """Time of each stage in this process [s]."""
    settings = Settings()
    table = []

    def stage(name: str, call: Callable[[], Any]) -> Any:
        seconds, result = median_of(call, runs)
        table.append((name, seconds))
        return result

    raw = stage("parse", lambda: decode(data))
    stage("to arrays", lambda: decode(data).clip)
    table[-1] = ("to arrays", max(table[-1][1] - table[0][1], 0.0))
    found = stage("unit, axes", lambda: infer_units(raw.clip, settings.rig))
    document = raw.placed(unit_m=found.unit_m, up=found.up)
    clip = document.clip
    rig = stage("find rig", lambda: find_rig(clip, settings.rig))
    contacts = stage("detect", lambda: detect(clip, rig, settings.detect))
    enforcement = stage("enforce", lambda: enforce(clip, rig, contacts, settings.enforce))
    corrected = stage("apply", lambda: apply(clip, enforcement.correction))
    stage("measure (twice)", lambda: (measure(clip, rig, contacts), measure(corrected, rig, contacts)))
    _, again = stage("write, know what it says", lambda: rewrite(document, corrected))
    stage("page", lambda: render(PageData({}, {}, film(clip, again, rig))))
    stage("whole job", lambda: clean_file(data, "clip.bvh", settings))
    return table


def floor(data: bytes, runs: int) -> list[tuple[str, float]]:
    """What the same work costs in plain numpy, at the least [s]."""
    block = data[data.index(b"Frame Time") :].split(b"\n", 1)[1]
    parse, values = median_of(lambda: np.loadtxt(io.BytesIO(block)), runs)
    document = decode(data)
    smooth, _ = median_of(lambda: savgol(values, document.frame_time), runs)
    kinematics, _ = median_of(lambda: forward(document.clip), runs)
    return [("numpy: loadtxt", parse), ("numpy: smooth all", smooth), ("numpy: kinematics", kinematics)]


# Starts a command from a small process: a child is charged with the memory of the process it was forked from.
_LAUNCHER = """
import resource, subprocess, sys, time
start = time.perf_counter()
subprocess.run(sys.argv[1:], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
print(time.perf_counter() - start, resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024.0)
"""


def process(command: list[str], runs: int) -> tuple[float, float]:
    """Median wall time [s] and peak memory [MB] of a whole process, after one run that is not counted."""
    found = []
    for _ in range(runs + 1):
        launched = [sys.executable, "-S", "-c", _LAUNCHER, *command]
        found.append(subprocess.run(launched, check=True, capture_output=True, text=True).stdout.split())
    return statistics.median(float(each[0]) for each in found[1:]), max(float(each[1]) for each in found)


def main() -> None:
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    arguments.add_argument("--frames", type=int, default=20_000)
    arguments.add_argument("--joints", type=int, default=31)
    arguments.add_argument("--runs", type=int, default=5)
    arguments.add_argument("--against", action="append", default=[], choices=sorted(PEERS))
    chosen = arguments.parse_args()
    data = synthetic(chosen.frames, chosen.joints)
    print(f"{chosen.frames} frames x {chosen.joints} joints, {len(data) / 1e6:.1f} MB, median of {chosen.runs}\n")
    print("in one process                 ms    frames/s")
    for name, seconds in [*stages(data, chosen.runs), *floor(data, chosen.runs)]:
        print(f"{name:26s} {1000 * seconds:8.1f} {chosen.frames / max(seconds, 1e-9):11,.0f}")
    print("\nwhole processes                ms    peak MB")
    with tempfile.TemporaryDirectory() as folder:
        clip = Path(folder) / "clip.bvh"
        clip.write_bytes(data)
        python = sys.executable
        jobs = {
            "python": [python, "-c", "pass"],
            "python, import numpy": [python, "-c", "import numpy"],
            "footfix --help": [python, "-m", "footfix", "--help"],
        }
        for peer in chosen.against:
            if importlib.util.find_spec(peer) is None:
                print(f"{peer}: not installed")
            else:
                jobs[f"{peer}, read and write"] = [python, "-c", PEERS[peer], str(clip), str(Path(folder) / "peer.bvh")]
        jobs["footfix clean"] = [python, "-m", "footfix", "clean", str(clip), "-o", f"{folder}/out", "--force", "-q"]
        for name, command in jobs.items():
            seconds, peak = process(command, chosen.runs)
            print(f"{name:26s} {1000 * seconds:8.1f} {peak:11.0f}")


if __name__ == "__main__":
    main()
