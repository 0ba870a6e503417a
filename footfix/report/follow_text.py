"""Walks along a path in words: the path, the walks along it, lean, strides, and when one walk changes to the next."""

from __future__ import annotations

from typing import Any

from footfix.report.verdict import Report, entries, number, section

# ids of notes on what was asked for
_SAID = ("kinks-rounded", "path-ends", "blend-cut", "blend-waits", "too-fast", "feet-let-go")


def follow_lines(report: Report) -> list[str]:
    """Write a few lines about walks along a path; none where the report is not about them."""
    follow = section(report, "follow")
    if not follow:
        return []
    said = [str(each.get("text")) for each in entries(report, "notes") if each.get("id") in _SAID]
    return [_path(follow), *said, _strides(follow), *_lean(follow), *_changes(follow)]


def path_of(report: Report) -> list[list[float]] | None:
    """Give the path that was walked, [x, z] [m], for the page's view from above; None where none was."""
    points = section(section(report, "follow"), "path").get("points_m")
    if not isinstance(points, list):
        return None
    pairs = [[number(each) for each in point] for point in points if isinstance(point, list) and len(point) == 2]
    return [[x, z] for x, z in pairs if x is not None and z is not None] or None


def _path(follow: Report) -> str:
    path, walked = section(follow, "path"), section(follow, "walked")
    shape = "a closed path" if path.get("closed") else "a path"
    return (
        f"{shape} of {_value(path, 'length_m'):.2f} m ({path.get('asked')}), {_value(walked, 'length_m'):.2f} m of it "
        f"walked in {_value(walked, 'seconds'):.2f} s, {_value(walked, 'speed_m_s'):.2f} m/s; the root keeps to it "
        f"within {_value(walked, 'root_off_path_mm'):.0f} mm in the mean over a stride"
    )


def _strides(follow: Report) -> str:
    strides = section(follow, "strides")
    shortest, lowered = _value(strides, "shortest_scale"), _value(strides, "lowered_mm")
    said = "strides as long as captured" if shortest > 0.999 else f"strides down to {100.0 * shortest:.0f} % in curves"
    return said + (f", the body up to {lowered:.0f} mm lower for the legs to reach" if lowered >= 0.5 else "")


def _lean(follow: Report) -> list[str]:
    lean = section(follow, "lean")
    both = (("most_left_deg", "left"), ("most_right_deg", "right"))
    sides = [f"{_value(lean, key):.1f} degrees to the {side}" for key, side in both if _value(lean, key) >= 0.05]
    if not sides:
        return []
    return [f"leans up to {' and '.join(sides)}; its zero-moment point stays within "
            f"{_value(lean, 'balance_off_mm'):.0f} mm of the straight walk's"]  # fmt: skip


def _changes(follow: Report) -> list[str]:
    clips = entries(follow, "clips")
    out = []
    for each in entries(follow, "transitions"):
        after = _file(clips, each.get("to"))
        seconds = _value(each, "end_s") - _value(each, "start_s")
        out.append(
            f"{after} takes over at {_value(each, 'start_s'):.2f} s, {_value(each, 'start_m'):.2f} m on, within "
            f"{seconds:.2f} s{_why(each)}"
        )
    return out


def _why(change: Report) -> str:
    """Say why a blend does not take as long as the joint that differs most asks for (K 6.2); "" where it does."""
    if not change.get("clamped"):
        return ""
    asked, peak, other = (number(change.get(key)) for key in ("asked_s", "peak_times", "asked_peak_times"))
    by = "none" if asked is None else f"{asked:.2f} s"
    by += " by the joint that differs most"
    if peak is None or other is None or other <= peak:
        return f" ({by})"
    return f" ({by}, but joints would accelerate {other:.2f} times as much as in the clips; now {peak:.2f} times)"


def _file(clips: list[Report], which: Any) -> str:
    known = isinstance(which, int) and 0 <= which < len(clips)
    return str(clips[which].get("file")) if known else "another clip"


def _value(entry: Report, key: str) -> float:
    return number(entry.get(key)) or 0.0
