"""Coverage-guided fuzzing of the BVH reader, writer and repair, for a bounded time.

    python benchmarks/fuzz_bvh.py --seconds 600 --seeds sample_data --keep /tmp/findings

Damages files at random; an input that runs a line after a line as none before it is kept and damaged further. What
breaks a law (see `survives` in tests/damage.py) or takes too long is kept as a file, to become a test.
"""

from __future__ import annotations

import argparse
import hashlib
import sys
import time
import traceback
from collections.abc import Callable
from pathlib import Path
from types import FrameType
from typing import Any

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tests"))

from bvhmaker import PLAIN  # type: ignore[import-not-found]  # noqa: E402
from damage import damaged, survives  # type: ignore[import-not-found]  # noqa: E402

WATCHED = str(ROOT / "footfix" / "formats")
SLOW = 5.0  # [s] for an input of this size is a finding
LARGEST = 20_000  # [bytes] of an input: small ones say more in the time


def steps_of(run: Callable[[bytes], None], data: bytes) -> set[tuple[str, int, int]]:
    """Which lines ran after which others in the modules that are watched."""
    seen: set[tuple[str, int, int]] = set()

    def on_line(frame: FrameType, event: str, _: Any) -> Any:
        if event == "line":
            seen.add((frame.f_code.co_filename, previous.get(id(frame), 0), frame.f_lineno))
            previous[id(frame)] = frame.f_lineno
        return on_line

    def on_call(frame: FrameType, event: str, _: Any) -> Any:
        return on_line if event == "call" and frame.f_code.co_filename.startswith(WATCHED) else None

    previous: dict[int, int] = {}
    sys.settrace(on_call)
    try:
        run(data)
    finally:
        sys.settrace(None)
    return seen


def fuzz(corpus: list[bytes], seconds: float, keep: Path, seed: int) -> int:
    """Runs for so long, prints a line every ten seconds; returns how many findings were kept."""
    rng = np.random.default_rng(seed)
    known: set[tuple[str, int, int]] = set()
    findings: set[str] = set()
    start = said = time.monotonic()
    runs = 0
    while time.monotonic() - start < seconds:
        # what was found last leads on, what came first must not be forgotten
        k = int(rng.integers(len(corpus))) if rng.integers(2) else -1 - int(rng.integers(min(20, len(corpus))))
        data = damaged(corpus[k], rng, int(rng.integers(1, 6))) if runs >= len(corpus) else corpus[runs]
        began = time.monotonic()
        trouble = ""
        try:
            steps = steps_of(survives, data)
        except Exception:  # any at all is what is looked for
            steps, trouble = set(), traceback.format_exc()
        if not trouble and time.monotonic() - began > SLOW:
            trouble = f"took {time.monotonic() - began:.1f} s"
        runs += 1
        if trouble:
            name = hashlib.sha256(trouble.split("\n")[-4 if "\n" in trouble else 0].encode()).hexdigest()[:12]
            if name not in findings:
                findings.add(name)
                keep.mkdir(parents=True, exist_ok=True)
                (keep / f"{name}.bvh").write_bytes(data)
                (keep / f"{name}.txt").write_text(trouble, encoding="utf-8")
        if steps - known:
            known |= steps
            if len(data) <= LARGEST:
                corpus.append(data)
        if time.monotonic() - said > 10.0:
            said = time.monotonic()
            line = f"{runs} runs  {len(corpus)} inputs  {len(known)} steps  {len(findings)} findings"
            print(f"{said - start:6.0f} s  {line}", flush=True)
    return len(findings)


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--seeds", type=Path, nargs="*", default=[], help="files or folders to start from")
    parser.add_argument("--keep", type=Path, default=Path("findings"), help="folder for what was found")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    paths = [path for seed in options.seeds for path in ([seed] if seed.is_file() else sorted(seed.rglob("*")))]
    corpus = [PLAIN.encode()]
    corpus += [path.read_bytes() for path in paths if path.is_file() and path.stat().st_size <= LARGEST]
    sys.exit(1 if fuzz(corpus, options.seconds, options.keep, options.seed) else 0)


if __name__ == "__main__":
    main()
