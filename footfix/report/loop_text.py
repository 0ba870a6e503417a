"""A loop in words: which frames it was cut from, how it goes, and its seam."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from footfix.errors import InputError
from footfix.locomotion.loop.root_motion import Travel, carrier, root_in_world, taken_out
from footfix.motion.clip import Clip
from footfix.report.verdict import Report, entries, number, section
from footfix.rig.rig import Rig


def loop_lines(report: Report) -> list[str]:
    """Describe a loop in a few lines; none where the report is not about one."""
    loop = section(report, "loop")
    if not loop:
        return []
    return [_cut(loop), _closing(loop), _seam(loop), *_others(loop)]


def round_of(report: Report) -> dict[str, Any] | None:
    """Get turn [rad] and travel [m] of a loop as written, by which the page's player moves each repetition on."""
    loop = section(report, "loop")
    if not loop:
        return None
    still, travel = bool(loop.get("in_place")), loop.get("travel_m")
    x, z = (number(each) or 0.0 for each in travel) if isinstance(travel, list | tuple) and len(travel) == 2 else (0, 0)
    yaw = math.radians(_value(loop, "turn_deg"))
    return {"yaw": 0.0 if still else yaw, "travel": [0.0, 0.0] if still else [x, z], "closed": bool(loop.get("closed"))}


def captured_frames(clip: Clip, loop: Report) -> Clip:
    """Take the captured frames that a loop was made from, one for each of its frames.

    Raises:
        InputError: the clip has no such frames.
    """
    start, count = _whole(loop, "start"), _whole(loop, "frames")
    if not (len(clip) and 0 <= start < len(clip) and 0 < count <= len(clip) + 1):
        raise InputError(f"a loop of {count} frames from frame {start} on is not of a clip of {len(clip)} frames")
    return clip.frames((start + np.arange(count)) % len(clip))


def in_place_if_written_so(clip: Clip, rig: Rig, loop: Report) -> Clip:
    """Take the travel out of the captured frames of a loop that was written in place."""
    turn = Travel(math.radians(_value(loop, "turn_deg")))
    travel = loop.get("travel_m")
    if not (loop.get("in_place") and isinstance(travel, list | tuple) and len(travel) == 2):
        return clip
    x, z = (number(each) or 0.0 for each in travel)
    root = carrier(clip, rig)
    first = root_in_world(clip.frames(slice(0, 1)), root)[0][0]
    ax, _, az = first + np.array([x, 0.0, z]) - turn.places(first)
    until = 1.0 if loop.get("closed") else 1.0 - 1.0 / len(clip)
    return taken_out(clip, root, Travel(turn.yaw, float(ax), float(az)), until=until)


def _cut(loop: Report) -> str:
    count = _whole(loop, "strides")
    strides = "" if not count else f" of {count} {'stride' if count == 1 else 'strides'}"
    turn = _value(loop, "turn_deg")
    goes = f"{_value(loop, 'distance_m'):.2f} m on at {_value(loop, 'speed_m_s'):.2f} m/s"
    goes += f", turned by {turn:.1f} degrees" if abs(turn) >= 0.05 else ", straight on"
    written = [
        *(["in place"] if loop.get("in_place") else []),
        "its last frame repeats the first" if loop.get("closed") else "without the frame that repeats the first",
    ]
    return (
        f"a loop{strides}, frames {_whole(loop, 'start')} to {_whole(loop, 'end')}, {_value(loop, 'seconds'):.2f} s: "
        f"{goes} in each round; {', '.join(written)}"
    )


def _closing(loop: Report) -> str:
    if not _value(loop, "gap_mm") and not _value(loop, "changed_mm"):
        return "its ends met already"
    apart = f"{_value(loop, 'gap_mm'):.0f} mm and {_value(loop, 'gap_deg'):.0f} degrees"
    moved = f"{_value(loop, 'changed_mm'):.0f} mm and turned by {_value(loop, 'changed_deg'):.0f} degrees"
    return f"its ends were at most {apart} apart; to close that, joints were moved by {moved}"


def _seam(loop: Report) -> str:
    slide = number(loop.get("seam_slide_mm"))
    held = "" if slide is None else f"; feet planted over it slide by {slide:.1f} mm"
    return (
        f"accelerations at the seam are {_value(loop, 'seam_median_ratio'):.1f} times the largest elsewhere, "
        f"{_value(loop, 'seam_worst_ratio'):.1f} times for the worst joint{held}"
    )


def _others(loop: Report) -> list[str]:
    cuts = [f"{_whole(cut, 'start')} to {_whole(cut, 'end')} ({_value(cut, 'apart_mm'):.0f} mm apart in the mean)"
            for cut in entries(loop, "others")]  # fmt: skip
    return [f"next best cuts: frames {', '.join(cuts)}"] if cuts else []


def _value(loop: Report, key: str) -> float:
    return number(loop.get(key)) or 0.0


def _whole(loop: Report, key: str) -> int:
    return int(_value(loop, key))
