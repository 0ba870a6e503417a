"""What looks odd about a file that could be read: frame time, frame count, names, values."""

from __future__ import annotations

from collections import Counter

import numpy as np

from footfix.formats.bvh.motion import Headings
from footfix.formats.bvh.numbers import number
from footfix.formats.bvh.rows import Rows, offset_of
from footfix.formats.bvh.text import Notes, readable
from footfix.formats.bvh.tree import Hierarchy
from footfix.motion.clip import Floats, Skeleton
from footfix.notes import Severity

USUAL_FRAME_TIME = 1.0 / 30.0  # [s] where a file says nothing of use
HUGE = 1e9  # no position and no angle is so large in any unit
_MANY_TURNS = 36_000.0  # [deg] a hundred turns: no joint does that

# Frame rates in use: where a frame time makes no sense in seconds, they tell a rate from milliseconds.
_RATES = (12, 12.5, 15, 20, 23.976, 24, 25, 29.97, 30, 48, 50, 59.94, 60, 72, 75, 90, 100, 120, 144, 150,
          180, 200, 240, 250, 300, 360, 480, 500, 600, 960, 1000)  # fmt: skip


def frame_time(headings: Headings, notes: Notes) -> float:
    """Find the time between frames [s]: what the file says, or what it must mean."""
    word, at = headings.time, headings.time_at
    if word is None:
        notes.add("frame-time-missing", "there is no Frame Time; 30 frames per second assumed", "warning",
                  at=headings.at)  # fmt: skip
        return USUAL_FRAME_TIME
    value = _quotient(word)
    if value is None or not np.isfinite(value) or value == 0.0 or abs(value) > 1e6:
        notes.add("frame-time-unreadable", f"Frame Time '{readable(word)}' makes no sense; 30 frames per second "
                  "assumed", "warning", at=at)  # fmt: skip
        return USUAL_FRAME_TIME
    if value < 0.0:
        notes.add("frame-time-negative", f"Frame Time {value:g} is negative; read without its sign", "warning", at=at)
        value = -value
    if value >= 1.0:
        return _not_seconds(value, at, notes)
    if value < 1e-4:
        notes.add("frame-time-unreadable", f"Frame Time {value:g} s is {1 / value:.0f} frames per second, which no "
                  "camera does; 30 assumed", "warning", at=at)  # fmt: skip
        return USUAL_FRAME_TIME
    if value < 1.0 / 600.0 or value > 0.2:
        what = f"Frame Time {value:g} s is {1 / value:.4g} frames per second"
        notes.add("frame-time-unusual", what, "warning", at=at)
    return value


def _quotient(word: bytes) -> float | None:
    """Read a number, or one over another (`1/30`)."""
    upper, _, lower = word.partition(b"/")
    value, divisor = number(upper), number(lower) if lower else 1.0
    return None if value is None or not divisor else value / divisor


def _not_seconds(value: float, at: int, notes: Notes) -> float:
    if value == 1.0:
        notes.add("frame-time-not-seconds", "Frame Time 1 counts frames, not seconds; 30 frames per second assumed",
                  "warning", at=at)  # fmt: skip
        return USUAL_FRAME_TIME
    as_rate = min(abs(value / rate - 1.0) for rate in _RATES)
    as_ms = min(abs(1000.0 / value / rate - 1.0) for rate in _RATES)
    if as_rate < 0.002 or (as_ms >= 0.005 and value >= 10.0):
        notes.add("frame-time-not-seconds", f"Frame Time {value:g} is no time in seconds; read as frames per second",
                  "warning", at=at)  # fmt: skip
        return 1.0 / value
    notes.add("frame-time-not-seconds", f"Frame Time {value:g} is no time in seconds; read as milliseconds", "warning",
              at=at)  # fmt: skip
    return value / 1000.0


def look_over(tree: Hierarchy, skeleton: Skeleton, headings: Headings, rows: Rows, base: Floats, notes: Notes) -> None:
    """Add what is odd and still readable."""
    _frame_count(headings, len(rows.values), notes)
    _text(rows, notes)
    _joints(tree, skeleton, notes)
    _odd_channels(tree, skeleton, base, notes)
    _bones(tree, skeleton, notes)
    if rows.values.size:
        _values(tree, rows, notes)
        _motion(tree, skeleton, rows, notes)
        _angles(tree, rows, notes)


def _frame_count(headings: Headings, frames: int, notes: Notes) -> None:
    if not frames:
        notes.add("no-frames", "there are no frames", "warning", at=headings.at)
    elif frames == 1:
        notes.add("one-frame", "there is one frame: a pose, not a motion", "warning", at=headings.at)
    word = headings.frames
    if word is None:
        notes.add("frames-missing", f"there is no frame count; {frames} rows found", "warning", at=headings.at)
        return
    count = number(word)
    if count is None or not count.is_integer() or count < 0:
        notes.add("frames-unreadable", f"'Frames: {readable(word)}' is no count; {frames} rows found", "warning",
                  at=headings.frames_at)  # fmt: skip
    elif count != frames:
        notes.add("frames-mismatch", f"Frames says {count:.0f}, {frames} rows found; the rows are used", "warning",
                  at=headings.frames_at)  # fmt: skip
    elif not word.isdigit():
        notes.add("frames-spelling", f"the frame count is written '{readable(word)}'", at=headings.frames_at)


def _text(rows: Rows, notes: Notes) -> None:
    text = notes.text
    e = min((k for k in (text.find(b"e", rows.start, rows.stop), text.find(b"E", rows.start, rows.stop)) if k >= 0),
            default=-1)  # fmt: skip
    if e >= 0 and text[max(e - 1, 0) : e] in (b"0", b"1", b"2", b"3", b"4", b"5", b"6", b"7", b"8", b"9", b"."):
        notes.add("exponents", "numbers are written with exponents, which some readers refuse", at=e)
    returns = text.count(b"\r")
    if returns:
        newlines, pairs = text.count(b"\n"), text.count(b"\r\n")
        if text.find(b"\r\r\n") >= 0:
            notes.add("line-ends-doubled", "lines end in CR CR LF: the file was converted twice",
                      at=text.find(b"\r\r\n"))  # fmt: skip
        elif not newlines:
            notes.add("line-ends-cr", "lines end in CR alone, which strict readers refuse", at=text.find(b"\r"))
        elif not pairs == newlines == returns:
            notes.add("line-ends-mixed", "lines end in several ways", at=text.find(b"\r"))


def _joints(tree: Hierarchy, skeleton: Skeleton, notes: Notes) -> None:
    names, places = tree.names, tree.places
    roots = [j for j, parent in enumerate(tree.parents) if parent < 0]
    if len(roots) > 1:
        notes.add("several-roots", f"there are {len(roots)} roots: " + ", ".join(readable(names[j]) for j in roots[:4]),
                  at=places[roots[1]], joints=tuple(names[j] for j in roots))  # fmt: skip
    twice = [name for name, count in Counter(names).items() if count > 1]
    if twice:
        notes.add("name-duplicate", f"several joints are called '{readable(twice[0])}'", joints=tuple(twice),
                  at=places[len(names) - 1 - names[::-1].index(twice[0])])  # fmt: skip
    with_end, leaves = set(skeleton.end_parents.tolist()), [j for j, c in enumerate(skeleton.children) if not c]
    bare = [j for j in leaves if j not in with_end]
    if bare:
        notes.add("end-site-missing", f"{len(bare)} joints at the end of a limb have no End Site", at=places[bare[0]],
                  joints=tuple(names[j] for j in bare))  # fmt: skip
    beside = [j for j in sorted(with_end) if skeleton.children[j]]
    if beside:
        notes.add("end-site-beside-children", "an End Site stands beside child joints", at=places[beside[0]],
                  joints=tuple(names[j] for j in beside))  # fmt: skip


def _bones(tree: Hierarchy, skeleton: Skeleton, notes: Notes) -> None:
    names, places = tree.names, tree.places
    none = [j for j, parent in enumerate(tree.parents) if parent >= 0 and not skeleton.offsets[j].any()]
    if none and len(none) == sum(parent >= 0 for parent in tree.parents) and not skeleton.end_offsets.any():
        notes.add("offsets-zero", "every OFFSET is 0 0 0: the figure has no size", "warning", at=places[0])
    elif none:
        notes.add("bone-zero", f"{len(none)} bones have no length: the joint sits in its parent", at=places[none[0]],
                  joints=tuple(names[j] for j in none))  # fmt: skip


def _odd_channels(tree: Hierarchy, skeleton: Skeleton, base: Floats, notes: Notes) -> None:
    names, places = tree.names, tree.places
    moved = {channel.joint for channel in tree.channels if channel.kind == "P"}
    turned = Counter(channel.joint for channel in tree.channels if channel.kind == "R")
    fixed = [j for j, parent in enumerate(tree.parents) if parent < 0 and j not in moved]
    if fixed:
        notes.add("root-fixed", "the root has no position channels", at=places[fixed[0]],
                  joints=tuple(names[j] for j in fixed))  # fmt: skip
    partly = [j for j in turned if not skeleton.rotates[j]]
    if partly:
        notes.add("rotation-partial", "joints with other than three rotation channels", at=places[partly[0]],
                  joints=tuple(names[j] for j in partly))  # fmt: skip
    added = np.flatnonzero(base.any(axis=1)).tolist()
    if added:
        notes.add("positions-zero", f"{len(added)} joints have position channels that stay at zero; read as counted "
                  "from the OFFSET", "warning", at=places[added[0]], joints=tuple(names[j] for j in added))  # fmt: skip
    free = [j for j in sorted(moved) if tree.parents[j] >= 0 and not base[j].any()]
    if free:
        notes.add("positions-below-root", f"{len(free)} joints below the root have position channels; they take the "
                  "place of the OFFSET", at=places[free[0]], joints=tuple(names[j] for j in free))  # fmt: skip


def _motion(tree: Hierarchy, skeleton: Skeleton, rows: Rows, notes: Notes) -> None:
    """Note motion that can't be real: nothing moves, or the figure jumps from one frame to the next."""
    values = rows.values
    if len(values) > 1 and np.array_equal(values[0], values[-1]) and np.all(values == values[0]):
        notes.add("frozen", "nothing moves: all frames are the same", at=offset_of(rows, 0, 0),
                  start=0, end=len(values))  # fmt: skip
    reach = np.zeros(len(skeleton))
    for joint, parent in enumerate(tree.parents):
        if parent >= 0:
            reach[joint] = reach[parent] + np.linalg.norm(skeleton.offsets[joint])
    columns = [k for k, c in enumerate(tree.channels) if c.kind == "P" and tree.parents[c.joint] < 0]
    if len(values) < 2 or not columns or not reach.max() > 0.0 or not np.isfinite(values[:, columns]).all():
        return
    steps = np.abs(np.diff(values[:, columns], axis=0)).max(axis=1)
    leaps = np.flatnonzero(steps > reach.max())
    if len(leaps):
        first = int(leaps[0]) + 1
        severity: Severity = "note" if int(leaps[-1]) < 4 else "warning"  # a rest pose often stands before the motion
        notes.add("jump", f"the figure leaps farther than its own size, first to frame {first} ({len(leaps)} times)",
                  severity, at=offset_of(rows, first, columns[0]), start=first, end=int(leaps[-1]) + 2)  # fmt: skip


def _angles(tree: Hierarchy, rows: Rows, notes: Notes) -> None:
    turns = [k for k, channel in enumerate(tree.channels) if channel.kind == "R"]
    for column in turns if rows.values.max() > _MANY_TURNS or rows.values.min() < -_MANY_TURNS else ():
        far = np.flatnonzero(np.abs(rows.values[:, column]) > _MANY_TURNS)
        if len(far):
            name, frame = tree.names[tree.channels[column].joint], int(far[0])
            turned = f"'{readable(name)}' has turned {rows.values[frame, column] / 360:.0f} times"
            notes.add("angle-unusual", f"in frame {frame} {turned}", "warning", at=offset_of(rows, frame, column),
                      start=frame, end=int(far[-1]) + 1, joints=(name,))  # fmt: skip
            return


def _values(tree: Hierarchy, rows: Rows, notes: Notes) -> None:
    if rows.values.min() > -HUGE and rows.values.max() < HUGE:
        return
    for id, bad, what in (
        ("value-nan", np.isnan(rows.values), "not a number"),
        ("value-infinite", np.isinf(rows.values), "infinite"),
        ("value-huge", np.isfinite(rows.values) & (np.abs(rows.values) >= HUGE), "beyond any measure"),
    ):
        if not bad.any() or (id == "value-nan" and notes.has("not-a-number")):
            continue
        frames, columns = np.flatnonzero(bad.any(axis=1)), np.flatnonzero(bad.any(axis=0))
        column = int(np.flatnonzero(bad[frames[0]])[0])
        owner = tree.channels[column].joint
        owners = sorted({tree.channels[c].joint for c in columns.tolist()} - {-1})
        name = tree.names[owner] if owner >= 0 else "an End Site"
        more = f", and so are {int(bad.sum()) - 1} more" if bad.sum() > 1 else ""
        notes.add(id, f"in frame {frames[0]} a value of '{readable(name)}' is {what}{more}", "error",
                  at=offset_of(rows, int(frames[0]), column), start=int(frames[0]), end=int(frames[-1]) + 1,
                  joints=tuple(tree.names[j] for j in owners))  # fmt: skip
