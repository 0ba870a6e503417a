"""Repair a BVH file so that strict readers can read it, with a note for each change.

Parts in order stay as they are in the file; a hierarchy, headings or rows that are not are rewritten.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from footfix.formats.bvh.compose import hierarchy_lines, motion_lines
from footfix.formats.bvh.document import Document
from footfix.formats.bvh.fixed_point import fixed
from footfix.formats.bvh.numbers import number
from footfix.formats.bvh.oddities import HUGE
from footfix.formats.bvh.splice import row_blocks
from footfix.motion.clip import Bools, Floats, Ints, Skeleton
from footfix.motion.contacts import runs
from footfix.notes import Note

_AXES = "XYZ"
_LONGEST = 64  # [bytes] of a number that is left as it is written
_DECIMALS = 9  # of a number that was written with an exponent, or had to be filled in

# How each oddity that the reader notes is repaired: by rewriting the hierarchy, the rows or the headings.
_HIERARCHY = {
    "byte-order-mark": "byte order mark taken out", "encoding-utf16": "written as UTF-8",
    "name-encoding": "names written as UTF-8", "name-empty": "names given to joints without one",
    "leading-text": "text before HIERARCHY taken out", "hierarchy-keyword-missing": "HIERARCHY added",
    "root-keyword": "JOINT at the top made ROOT", "brace-missing": "braces added", "brace-unclosed": "braces closed",
    "brace-extra": "braces too many taken out", "offset-missing": "OFFSET 0 0 0 added",
    "offset-long": "OFFSETs cut to 3 numbers", "offset-brackets": "brackets and commas around OFFSETs taken out",
    "decimal-comma": "decimal commas made points",
    "channel-count": "CHANNELS counts set to the names", "channel-scale": "scale channels and their numbers taken out",
    "channels-end-site": "channels of End Sites and their numbers taken out",
    "brace-on-line": "braces put on lines of their own", "spelling": "keywords and channels spelled as usual",
    "end-site-missing": "End Sites added",
}  # fmt: skip
_ROWS = {
    "rows-wrapped": "each frame put on a line of its own", "row-long": "numbers too many taken out",
    "row-short": "short rows completed from their neighbours", "last-row-cut": "the cut row taken out",
    "text-in-rows": "text among the rows taken out", "trailing-text": "text after the rows taken out",
    "padding": "NUL bytes at the end taken out", "motion-repeated": "what follows the motion taken out",
    "decimal-comma": "decimal commas made points", "commas": "commas between numbers taken out",
    "not-a-number": "words that are no numbers filled in, or written as nan",
    "exponents": "exponents written out", "channel-scale": "", "channels-end-site": "",
}  # fmt: skip
_HEADINGS = {
    "frames-mismatch": "", "frames-missing": "", "frames-unreadable": "", "frames-spelling": "",
    "motion-keyword-missing": "MOTION added", "frame-time-missing": "", "frame-time-unreadable": "",
    "frame-time-negative": "", "frame-time-not-seconds": "", "heading-spelling": "headings spelled as usual",
}  # fmt: skip
_EVERYWHERE = {
    "comment": "comments taken out", "line-ends-cr": "lines end in LF", "line-ends-doubled": "lines end in LF",
    "line-ends-mixed": "lines end in LF",
}  # fmt: skip

_LINE_ENDS = {"line-ends-cr", "line-ends-doubled", "line-ends-mixed"}


@dataclass(frozen=True, kw_only=True)
class RepairParams:
    """What is filled in.

    Args:
        gap: [s] the longest stretch of missing values that is filled from its neighbours.
    """

    gap: float = 0.1


_PARAMS = RepairParams()


def repair(document: Document, params: RepairParams = _PARAMS) -> tuple[bytes, tuple[Note, ...]]:
    """Repair a file so that strict readers can read it, with a note for each change.

    Args:
        document: the file.
        params: what is filled in.

    Returns:
        The bytes to write, in UTF-8, and a note for each change, with the id of the oddity that is repaired; notes
        of severity "error" tell what could not be. A file without oddities is returned unchanged.
    """
    odd = {note.id: note for note in document.notes}
    values, filled, notes = _fill(document, params)
    new_tree, new_rows = odd.keys() & (_HIERARCHY | _EVERYWHERE), odd.keys() & (_ROWS | _EVERYWHERE)
    if not (new_tree or new_rows or odd.keys() & _HEADINGS or filled.any()):
        return document.text, tuple(notes)
    newline = b"\n" if odd.keys() & _LINE_ENDS else _newline(document.text)
    if new_tree:
        lines = _hierarchy(document)
    else:
        lines = document.text[: document.motion_at].rstrip().splitlines()
    head = newline.join([*lines, *_headings(document)])
    if new_rows or filled.any():
        body = newline + b"".join(_rows(document, values, filled, newline))
    else:
        body = newline + document.text[document.rows.start :].lstrip(b"\r\n")
    for id in odd:
        text = next((table[id] for table in (_HIERARCHY, _ROWS, _EVERYWHERE, _HEADINGS) if table.get(id)), "")
        text = text or _heading_change(document, id)
        if text:
            notes.append(replace(odd[id], text=text, severity="note"))
    return head + body, tuple(notes)


def _newline(text: bytes) -> bytes:
    return b"\r\n" if b"\r\n" in text[:1000] else b"\n"


def _hierarchy(document: Document) -> list[bytes]:
    skeleton, channels = document.skeleton, list[list[str]]([] for _ in document.skeleton.names)
    for channel in document.channels:
        if channel.kind:
            kind = "position" if channel.kind == "P" else "rotation"
            channels[channel.joint].append(_AXES[channel.axis] + kind)
    names = tuple(name or f"joint_{k}" for k, name in enumerate(skeleton.names))
    return hierarchy_lines(_with_end_sites(replace(skeleton, names=names)), channels, _exact)[0]


def _exact(values: Floats) -> bytes:
    return b" ".join(np.format_float_positional(value, trim="0").encode() for value in values)


def _with_end_sites(skeleton: Skeleton) -> Skeleton:
    """Add an End Site to each limb that lacks one: in the direction of its last bone, half as long."""
    ended = set(skeleton.end_parents.tolist())
    bare = [j for j, children in enumerate(skeleton.children) if not children and j not in ended]
    return replace(
        skeleton,
        end_parents=np.concatenate([skeleton.end_parents, np.array(bare, dtype=np.intp)]),
        end_offsets=np.concatenate([skeleton.end_offsets, 0.5 * skeleton.offsets[bare]]),
    )


def _headings(document: Document) -> list[bytes]:
    """Write `MOTION`, `Frames:` and `Frame Time:`; the time as the file writes it, where that makes sense."""
    moves = any(channel.kind for channel in document.channels)
    lines = motion_lines(len(document.values) if moves else 0, document.frame_time)
    own = document.text[document.motion_at : document.rows.start].splitlines()
    times = [line.strip() for line in own if line.strip().lower().startswith(b"frame time:")]
    mended = {note.id for note in document.notes if note.id.startswith("frame-time-")} - {"frame-time-unusual"}
    word = times[0].split()[2:3] if times and not mended else []
    if word and number(word[0]) is not None and b"," not in word[0]:
        lines[2] = b"Frame Time: " + word[0]
    return lines


def _heading_change(document: Document, id: str) -> str:
    if id.startswith("frames-"):
        return f"Frames set to {len(document.values)}"
    if id in _HEADINGS:
        return f"Frame Time set to {document.frame_time:.8g} s"
    return ""


def _fill(document: Document, params: RepairParams) -> tuple[Floats, Bools, list[Note]]:
    """Fill short gaps in the values; return the values, which were filled, and the notes about it."""
    values = document.values
    with np.errstate(invalid="ignore"):
        bad = ~(np.abs(values) < HUGE)
    if not bad.any():
        return values, bad, []
    longest = max(1, round(params.gap / document.frame_time))
    values, filled, notes = values.copy(), np.zeros_like(bad), list[Note]()
    left: list[tuple[int, int]] = []
    for column in np.flatnonzero(bad.any(axis=0)).tolist():
        for start, end in runs(bad[:, column]):
            if end - start > longest or end - start == len(values):
                left.append((start, end))
                continue
            _bridge(values[:, column], start, end, wraps=document.channels[column].kind == "R")
            filled[start:end, column] = True
    if filled.any():
        frames = np.flatnonzero(filled.any(axis=1))
        text = f"{int(filled.sum())} numbers filled in from the frames around them"
        notes.append(Note("value-nan", text, start=int(frames[0]), end=int(frames[-1]) + 1))
    if left:
        start, end = max(left, key=lambda gap: gap[1] - gap[0])
        seconds = (end - start) * document.frame_time
        text = f"{len(left)} gaps of up to {seconds:.2f} s are longer than {params.gap:g} s and left as they are"
        notes.append(Note("value-nan", text, "error", start, end))
    return values, filled, notes


def _bridge(column: Floats, start: int, end: int, *, wraps: bool) -> None:
    """Fill `column[start:end]` by linear interpolation between its neighbours; angles by the shorter way round."""
    before = column[start - 1] if start else column[end]
    after = column[end] if end < len(column) else column[start - 1]
    step = after - before
    if wraps:
        step = (step + 180.0) % 360.0 - 180.0
    column[start:end] = before + step * np.arange(1, end - start + 1) / (end - start + 1)


def _rows(document: Document, values: Floats, filled: Bools, newline: bytes) -> Iterator[bytes]:
    """Write all rows, one a line: numbers as they are written, but for those with exponents and those filled in."""
    columns = np.array([k for k, channel in enumerate(document.channels) if channel.kind], dtype=np.intp)
    text = document.rows.text
    if not len(columns):
        return
    for frame, starts, ends in row_blocks(document.rows):
        span = slice(frame, frame + len(starts))
        if starts.shape[1] < values.shape[1]:
            anew = np.ones((1, len(columns)), dtype=np.bool_)
            starts = ends = np.zeros((1, len(columns)), dtype=np.intp)
        else:
            starts, ends = starts[:, columns], ends[:, columns]
            anew = filled[span][:, columns] | _strange(text, starts, ends) | (ends - starts > _LONGEST)
            anew |= np.isnan(values[span][:, columns])  # a word that is no number, however it is spelled
        yield _lines(text, starts, ends, anew, values[span][:, columns], newline)


def _strange(text: bytes, starts: Ints, ends: Ints) -> Bools:
    """Find words that are more than digits, a sign and a point."""
    low, high = int(starts.min()), int(ends.max())
    raw = np.frombuffer(text, np.uint8, high - low, low)
    odd = np.concatenate([[0], np.cumsum((raw > ord("9")) | (raw == ord("+")))])
    return np.asarray(odd[ends - low] > odd[starts - low])


def _lines(text: bytes, starts: Ints, ends: Ints, anew: Bools, values: Floats, newline: bytes) -> bytes:
    new = values[anew]
    letters = fixed(np.where(np.isfinite(new), new, 0.0), _DECIMALS)
    letters[~np.isfinite(new)] = 0
    letters[~np.isfinite(new), :3] = np.frombuffer(b"nan", np.uint8)
    sizes = np.where(anew, letters.shape[1], ends - starts)
    wide = max(letters.shape[1], int(sizes.max(initial=0)))
    cells = np.zeros((*starts.shape, wide + len(newline)), dtype=np.uint8)
    cells[:, :, : letters.shape[1]][anew] = letters
    raw = np.frombuffer(text, np.uint8)
    for k in range(int(sizes.max(initial=0))):
        which = ~anew & (sizes > k)
        cells[..., k][which] = raw[starts[which] + k]
    cells[:, :-1, -1] = ord(" ")
    cells[:, -1, -len(newline) :] = np.frombuffer(newline, np.uint8)
    return cells.tobytes().translate(None, b"\0")
