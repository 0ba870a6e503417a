"""BVH files for tests: a plain one to start from, and a grammar of odd ones for hypothesis."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from hypothesis import strategies as st

PLAIN = """HIERARCHY
ROOT Hips
{
\tOFFSET 0.00 0.00 0.00
\tCHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
\tJOINT LeftLeg
\t{
\t\tOFFSET 1.00 -4.00 0.00
\t\tCHANNELS 3 Zrotation Xrotation Yrotation
\t\tJOINT LeftFoot
\t\t{
\t\t\tOFFSET 0.00 -4.00 0.00
\t\t\tCHANNELS 3 Zrotation Xrotation Yrotation
\t\t\tEnd Site
\t\t\t{
\t\t\t\tOFFSET 0.00 0.00 1.00
\t\t\t}
\t\t}
\t}
}
MOTION
Frames: 4
Frame Time: 0.0333333
0.00 9.00 0.00 1.00 2.00 3.00 -4.50 5.25 6.00 7.00 8.00 9.00
0.10 9.01 1.00 1.10 2.20 3.30 -4.40 5.50 6.60 7.70 8.80 9.90
0.20 9.02 2.00 1.20 2.40 3.60 -4.30 5.75 7.20 8.40 9.60 170.00
0.30 9.03 3.00 1.30 2.60 3.90 -4.20 6.00 7.80 9.10 10.40 -175.00
"""


def plain(*changes: tuple[str, str], text: str = PLAIN) -> bytes:
    """The plain file with some strings replaced, each once."""
    for old, new in changes:
        assert old in text, old
        text = text.replace(old, new, 1)
    return text.encode("utf-8")


@dataclass
class Joint:
    name: str
    offset: tuple[float, float, float]
    channels: tuple[str, ...]
    children: list[Joint] = field(default_factory=list)
    ends: list[tuple[float, float, float]] = field(default_factory=list)


_LETTERS = "".join(map(chr, range(33, 127))).translate(str.maketrans("", "", "{}#;/")) + "äßéÑλЖ足の한🦶€·"
NAMES = st.text(_LETTERS, min_size=1, max_size=8) | st.sampled_from(
    ["LeftFoot", "mixamorig:Hips", "Bip01 L Foot", "char|hip", "足", "Bone.001"]
)
LENGTHS = st.floats(-50, 50).map(lambda x: round(x, 3))
OFFSETS = st.tuples(LENGTHS, LENGTHS, LENGTHS)
AXES = st.permutations("XYZ")


@st.composite
def channels(draw: st.DrawFn) -> tuple[str, ...]:
    """Any subset in any order: rotations before positions, one or two of either, or none."""
    rotations = [f"{a}rotation" for a in draw(AXES)][: draw(st.sampled_from([3, 3, 3, 0, 1, 2]))]
    positions = [f"{a}position" for a in draw(AXES)][: draw(st.sampled_from([0, 0, 3, 3, 1, 2]))]
    return tuple(rotations + positions if draw(st.booleans()) else positions + rotations)


@st.composite
def trees(draw: st.DrawFn, depth: int = 3) -> Joint:
    joint = Joint(draw(NAMES), draw(OFFSETS), draw(channels()))
    if depth:
        joint.children = draw(st.lists(trees(depth=depth - 1), max_size=2))
    joint.ends = draw(st.lists(OFFSETS, max_size=2))
    return joint


@dataclass(frozen=True)
class Style:
    """How an exporter writes."""

    newline: str
    indent: str
    blank: str  # between numbers
    decimals: int
    exponents: bool
    brace_on_line: bool
    case: int
    bom: bool
    trailing: str

    def number(self, value: float) -> str:
        return f"{value:.{self.decimals}e}" if self.exponents else f"{value:.{self.decimals}f}"

    def word(self, word: str) -> str:
        return (word, word.lower(), word.upper())[self.case]


STYLES = st.builds(
    Style,
    newline=st.sampled_from(["\n", "\r\n", "\r", "\r\r\n"]),
    indent=st.sampled_from(["\t", "  ", ""]),
    blank=st.sampled_from([" ", "\t", "  "]),
    decimals=st.integers(1, 9),
    exponents=st.booleans(),
    brace_on_line=st.booleans(),
    case=st.integers(0, 2),
    bom=st.booleans(),
    trailing=st.sampled_from(["", " ", "\t"]),
)


def _lines(joint: Joint, style: Style, depth: int, keyword: str, out: list[str]) -> None:
    tab, inner = style.indent * depth, style.indent * (depth + 1)
    head = f"{tab}{style.word(keyword)} {joint.name}"
    out += [head + " {"] if style.brace_on_line else [head, tab + "{"]
    out.append(inner + style.word("OFFSET") + " " + " ".join(map(style.number, joint.offset)))
    names = [style.word(name) for name in joint.channels]
    out.append(inner + " ".join([style.word("CHANNELS"), str(len(names)), *names]))
    for end in joint.ends:
        out += [inner + style.word("End Site"), inner + "{"]
        out += [inner + style.word("OFFSET") + " " + " ".join(map(style.number, end)), inner + "}"]
    for child in joint.children:
        _lines(child, style, depth + 1, "JOINT", out)
    out.append(tab + "}")


def walk(joint: Joint) -> list[Joint]:
    return [joint, *(below for child in joint.children for below in walk(child))]


def write(roots: list[Joint], values: np.ndarray, style: Style, frame_time: float = 1 / 30) -> bytes:
    """The file that an exporter of this style makes."""
    out = [style.word("HIERARCHY")]
    for root in roots:
        _lines(root, style, 0, "ROOT", out)
    out += [style.word("MOTION"), f"{style.word('Frames:')} {len(values)}"]
    out.append(f"{style.word('Frame Time:')} {frame_time:.7f}")
    out += [style.blank.join(map(style.number, row)) + style.trailing for row in values.tolist()]
    text = style.newline.join(out) + style.newline
    return (b"\xef\xbb\xbf" if style.bom else b"") + text.encode("utf-8")


@st.composite
def files(draw: st.DrawFn) -> tuple[list[Joint], np.ndarray, Style, bytes]:
    """A file with at least one channel, its joints in order, and its numbers as written."""
    roots = draw(st.lists(trees(), min_size=1, max_size=2))
    joints = [joint for root in roots for joint in walk(root)]
    if not any(joint.channels for joint in joints):
        joints[0].channels = ("Xposition", "Yposition", "Zposition", "Zrotation", "Xrotation", "Yrotation")
    width = sum(len(joint.channels) for joint in joints)
    frames = draw(st.integers(1, 6))
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    style = draw(STYLES)
    values = rng.uniform(-200.0, 200.0, (frames, width))
    values = np.array([[float(style.number(x)) for x in row] for row in values.tolist()]).reshape(values.shape)
    return joints, values, style, write(roots, values, style)


def side_by_side(one: bytes, other: bytes) -> bytes:
    """Two files of as many frames as one file with two roots."""
    (head, rows), (other_head, other_rows) = (each.decode().split("MOTION\n") for each in (one, other))
    lines, other_lines = rows.splitlines(), other_rows.splitlines()
    both = [f"{a.strip()} {b.strip()}" for a, b in zip(lines[2:], other_lines[2:], strict=True)]
    return "\n".join([head + other_head.removeprefix("HIERARCHY\n") + "MOTION", *lines[:2], *both, ""]).encode()
