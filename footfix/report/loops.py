"""A loop in words: which frames it was cut from, how it goes, and its seam."""

from __future__ import annotations

from footfix.report.verdict import Report, entries, number, section


def loop_lines(report: Report) -> list[str]:
    """A few lines about a loop; none where the report is not about one."""
    loop = section(report, "loop")
    if not loop:
        return []
    return [_cut(loop), _closing(loop), _seam(loop), *_others(loop)]


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
    return (
        f"its ends were {_value(loop, 'gap_mm'):.0f} mm and {_value(loop, 'gap_deg'):.0f} degrees apart; to close that, "
        f"joints were moved by {_value(loop, 'changed_mm'):.0f} mm and turned by {_value(loop, 'changed_deg'):.0f} "
        "degrees at most"
    )


def _seam(loop: Report) -> str:
    slide = number(loop.get("seam_slide_mm"))
    held = "" if slide is None else f"; feet planted over it slide by {slide:.1f} mm"
    return (
        f"accelerations at the seam are {_value(loop, 'seam_median_ratio'):.1f} times the largest elsewhere, "
        f"{_value(loop, 'seam_worst_ratio'):.1f} times for the worst joint{held}"
    )


def _others(loop: Report) -> list[str]:
    cuts = [f"{_whole(cut, 'start')} to {_whole(cut, 'end')} ({_value(cut, 'apart_mm'):.0f} mm apart)"
            for cut in entries(loop, "others")]  # fmt: skip
    return [f"next best cuts: frames {', '.join(cuts)}"] if cuts else []


def _value(loop: Report, key: str) -> float:
    return number(loop.get(key)) or 0.0


def _whole(loop: Report, key: str) -> int:
    return int(_value(loop, key))
