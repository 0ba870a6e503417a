"""Walks along a path, from Python."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from footfix.api.parameters import check_settings
from footfix.errors import ArgumentError
from footfix.formats.floor_paths import shape
from footfix.input_checks import check_clip
from footfix.jobs.follow import Start, check_starts, start_of, walk_of
from footfix.locomotion.follow.prepared_walk import Walk
from footfix.locomotion.follow.run import Follow, follow_path
from footfix.motion.clip import Clip
from footfix.settings import Settings

__all__ = ["follow"]

def follow(
    path: str | ArrayLike, clips: Sequence[Clip | tuple[Clip, Start]] | Clip, settings: Settings | None = None
) -> Follow:  # fmt: skip
    """Lead captured walks along a path, one handed over to the next.

    Examples:
        >>> from footfix.api.files import load
        >>> walk = load("sample_data/walk_skate.bvh").clip
        >>> found = follow("circle:3", [walk])
        >>> round(found.path.length, 1), bool(found.walked.lean.max() > 0.01)
        (18.8, True)
        >>> straight = follow("line:5", [walk])
        >>> float(abs(straight.walked.lean).max())
        0.0

    Args:
        path: points (N, 2), x and z in metres, or "line:10", "circle:2", "sine:1x6": a shape that begins where the
            first walk does, in its direction.
        clips: the walks, each alone or with when it begins: "3s" or 3.0 after three seconds, "8m" eight metres on.
        settings: how, as `settings.follow`; and the parameters of all steps.

    Returns:
        The walks along the path, and how it was walked.

    Raises:
        ArgumentError: the points do not make a path, or clips or settings can't be what is meant.
        UsageError: a walk begins where it can't.
        InputError: a clip holds no walk that can be repeated, or the clips have different skeletons.
    """
    settings = check_settings(settings)
    listed = [clips] if isinstance(clips, Clip) else list(clips)
    if not listed:
        raise ArgumentError("a path needs a clip at least that walks along it")
    parts = [each if isinstance(each, tuple) else (each, None) for each in listed]
    ats = [start_of(at) for _, at in parts]
    check_starts(ats, [f"clip {k + 1}" for k in range(len(parts))])
    walks = dict[int, Walk]()
    for k, (clip, _) in enumerate(parts):
        check_clip(clip)
        if id(clip) not in walks:
            walks[id(clip)] = walk_of(clip, f"clip {k + 1}", settings)
    points, relative = _points(path)
    return follow_path(
        points, [walks[id(clip)] for clip, _ in parts], ats, settings.follow, settings.enforce, relative=relative
    )  # fmt: skip


def _points(path: str | ArrayLike) -> tuple[np.ndarray[tuple[int, ...], np.dtype[np.float64]], bool]:
    if isinstance(path, str):
        drawn = shape(path)
        if drawn is None:
            raise ArgumentError(f"{path!r} is no path; line:10, circle:2, sine:1x6 and SVG paths are, or points (N, 2)")
        return drawn.points, drawn.relative
    try:
        return np.asarray(path, dtype=np.float64), False
    except (TypeError, ValueError):
        raise ArgumentError("a path is made of points (N, 2), x and z in metres") from None
