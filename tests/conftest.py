"""What several tests share: where the shared clips are, and how a test says that they are not there."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
SHARED = Path(os.environ.get("FOOTFIX_SHARED", ROOT.parent / "shared"))
SAMPLES = ROOT / "sample_data"


def shared(folder: str) -> list[Path]:
    """The BVH files of a folder beside the project, sorted; empty where it is absent."""
    return sorted(path for path in (SHARED / folder).rglob("*") if path.suffix.lower() == ".bvh")


def need(paths: list[Path], folder: str) -> list[Path]:
    """The same paths; skips the test, saying so, where there are none."""
    if not paths:
        pytest.skip(f"no clips: {SHARED / folder} is absent")
    return paths
