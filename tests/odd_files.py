"""Malformed and strange files of our own, each with its stated outcome."""

from __future__ import annotations

import gzip
from dataclasses import dataclass

from bvhmaker import PLAIN, plain


@dataclass(frozen=True)
class Outcome:
    """Either so many frames and these notes, or the words of the refusal."""

    frames: int = 0
    notes: tuple[str, ...] = ()
    error: str = ""


def read(frames: int, *notes: str) -> Outcome:
    return Outcome(frames, tuple(sorted(notes)))


def refused(error: str) -> Outcome:
    return Outcome(error=error)


ROWS = PLAIN[PLAIN.index("0.00 9.00") :]
HEAD = PLAIN[: PLAIN.index("0.00 9.00")]
TREE = PLAIN[PLAIN.index("ROOT") : PLAIN.index("MOTION")]
END = "\t\t\tEnd Site\n\t\t\t{\n\t\t\t\tOFFSET 0.00 0.00 1.00\n\t\t\t}\n"
LEG = "CHANNELS 3 Zrotation Xrotation Yrotation\n\t\tJOINT"

OWN_FILES = {
    # what the file is
    "nothing": (b"", refused("the file is empty")),
    "blanks": (b" \n\n\t\n", refused("the file holds nothing but blanks")),
    "zeros": (b"\0" * 500, refused("the file holds nothing but blanks")),
    "gzip": (gzip.compress(plain()), refused("this is a gzip archive")),
    "png": (b"\x89PNG\r\n\x1a\n" + bytes(range(256)) * 4,
        refused("this is a binary file of another kind, not a BVH")),
    "json": (b'{"frames": []}', refused("1:1: this is no BVH file: it begins with '{', not with HIERARCHY")),
    "csv": (b"time,x,y\n0,1,2\n",
        refused("1:1: this is no BVH file: it begins with 'time,x,y', not with HIERARCHY")),
    "xml": (b"<?xml version='1.0'?><COLLADA/>", refused("this is an XML file")),
    "web page": (b"\n<HTML><body>404</body>",
        refused("this is a web page, probably an error page of a download")),
    "acclaim": (b":ASF\n", refused("this is an Acclaim skeleton (ASF)")),
    "rows alone": (ROWS.encode(), refused("1:1: the file has motion rows but no HIERARCHY")),
    "only the word": (b"HIERARCHY\n", refused("2:1: the hierarchy has no ROOT")),
    "no MOTION": (PLAIN[: PLAIN.index("MOTION")].encode(),
        refused("21:1: the file ends after the hierarchy: there is no MOTION")),
    # encodings and line ends
    "utf-16 le": ("\ufeff" + PLAIN).encode("utf-16-le"),
    "utf-16 be": ("\ufeff" + PLAIN).encode("utf-16-be"),
    "utf-16 cut": (("\ufeff" + PLAIN).encode("utf-16-le")[:-1],
        refused("the text looks like UTF-16-LE, but is damaged")),
    "utf-32": (("\ufeff" + PLAIN).encode("utf-32-le"), refused("the text is UTF-32")),
    "latin-1 name": (plain().replace(b"LeftFoot", b"Fu\xdf"), read(4, "name-encoding")),
    "cr": (plain().replace(b"\n", b"\r"), read(4, "line-ends-cr")),
    "crlf": (plain().replace(b"\n", b"\r\n"), read(4)),
    "mixed line ends": (plain().replace(b"\n", b"\r\n", 5), read(4, "line-ends-mixed")),
    "no last line end": (plain().rstrip(), read(4)),
    "ctrl-z": (plain() + b"\x1a", read(4)),
    "zeros at the end": (plain() + b"\0" * 700, read(4, "padding")),
    "bom": (b"\xef\xbb\xbf" + plain(), read(4, "byte-order-mark")),
    # the hierarchy
    "text in front": (b"exported by a tool\n" + plain(), read(4, "leading-text")),
    "no HIERARCHY": (plain(("HIERARCHY\n", "")), read(4, "hierarchy-keyword-missing")),
    "JOINT for ROOT": (plain(("ROOT", "JOINT")), read(4, "root-keyword")),
    "lower case": (PLAIN.lower().encode(), read(4, "spelling", "heading-spelling")),
    "upper case": (PLAIN.upper().encode(), read(4, "spelling", "heading-spelling")),
    "all on one line": (" ".join(HEAD.split()).encode() + b"\n" + ROWS.encode(), read(4, "brace-on-line")),
    "everything on one line": (" ".join(PLAIN.split()).encode(), read(4, "brace-on-line", "rows-wrapped")),
    "typing error": (plain(("CHANNELS 3", "CHANELS 3")),
        refused("9:3: 'CHANELS' means nothing in a hierarchy")),
    "unknown word": (plain(("\t\tOFFSET 1.00", "\t\tMASS 3\n\t\tOFFSET 1.00")),
        refused("8:3: 'MASS' means nothing in a hierarchy")),
    "two OFFSETs": (plain(("\tCHANNELS 6", "\tOFFSET 1 2 3\n\tCHANNELS 6")),
        refused("5:2: a second OFFSET for the same joint")),
    "no OFFSET": (plain(("\t\tOFFSET 1.00 -4.00 0.00\n", "")), read(4, "offset-missing", "bone-zero")),
    "OFFSET of 4": (plain(("1.00 -4.00 0.00", "1.00 -4.00 0.00 1.00")), read(4, "offset-long")),
    "OFFSET cut": (plain(("OFFSET 1.00 -4.00 0.00", "OFFSET 1.00")),
        refused("9:3: OFFSET needs 3 numbers, nothing more after 1")),
    "OFFSET of words": (plain(("1.00 -4.00", "one -4.00")),
        refused("8:10: OFFSET needs 3 numbers, nothing more after 0")),
    "OFFSET of 1e30": (plain(("1.00 -4.00", "1e30 -4.00")), read(4, "offset-not-a-number")),
    "OFFSET with commas": (plain(("1.00 -4.00 0.00", "1.00, -4.00, 0.00")), read(4, "offset-brackets")),
    "no CHANNELS": (plain(("\t\t\tCHANNELS 3 Zrotation Xrotation Yrotation\n", "")),
        refused("23:1: rows have 12 numbers, but the hierarchy has 9 channels")),
    "CHANNELS of none": (plain(("CHANNELS 6", "CHANNELS ")),
        refused("5:12: CHANNELS needs a count, not 'Xposition'")),
    "CHANNELS too many": (plain(("CHANNELS 6", "CHANNELS 9")), read(4, "channel-count")),
    "CHANNELS too few": (plain(("CHANNELS 6", "CHANNELS 3")), read(4, "channel-count")),
    "CHANNELS said and rows agree, not the names": (
        plain(("CHANNELS 3 Zrotation Xrotation", "CHANNELS 3 Zrotation")),
        refused("9:3: CHANNELS says 3, 2 names follow")),
    "CHANNELS and rows disagree": (plain(("Zposition Zrotation", "Zrotation")),
        refused("5:2: CHANNELS says 6, 5 names follow")),
    "unknown channel": (plain(("Zposition", "Wposition")), refused("5:33: 'Wposition' is no channel")),
    "channel twice": (plain(("Zposition", "Yposition")),
        refused("5:33: Yposition is named twice for one joint")),
    "axis twice": (plain(("CHANNELS 3 Zrotation Xrotation Yrotation", "CHANNELS 3 Zrotation Xrotation Zrotation")),
        read(4, "rotation-partial")),
    "brace missing": (plain(("LeftLeg\n\t{", "LeftLeg\n")), read(4, "brace-missing")),
    "brace unclosed": (plain(("\t\t}\n\t}\n}\n", "\t\t}\n\t}\n")), read(4, "brace-unclosed")),
    "brace too many": (plain(("}\nMOTION", "}\n}\nMOTION")), read(4, "brace-extra")),
    "End Site unclosed": (plain((END, END[:-5])), read(4, "brace-unclosed")),
    "End Site without braces": (plain((END, "\t\t\tEnd Site\n\t\t\t\tOFFSET 0.00 0.00 1.00\n")),
        read(4, "brace-missing")),
    "End Site without OFFSET": (plain(("\t\t\t\tOFFSET 0.00 0.00 1.00\n", "")), read(4, "offset-missing")),
    "End Site missing": (plain((END, "")), read(4, "end-site-missing")),
    "End Sites twice": (plain((END, END + END)), read(4)),
    "End Site beside children": (plain((LEG, LEG.replace("JOINT", "End Site { OFFSET 0 1 0 }\n\t\tJOINT"))),
        read(4, "end-site-beside-children", "brace-on-line")),
    "End Site with CHANNELS 0": (plain(("1.00\n\t\t\t}", "1.00\n\t\t\t\tCHANNELS 0\n\t\t\t}")), read(4)),
    "End Site with channels of no column": (
        plain(("1.00\n\t\t\t}", "1.00\nCHANNELS 3 Zrotation Xrotation Yrotation\n\t\t\t}")),
        read(4, "channels-end-site")),
    "EndSite in one word": (plain(("End Site", "EndSite")), read(4, "spelling")),
    "End Site labelled": (plain(("End Site", "End Site Toe end")), read(4)),
    "comments": (plain(("\tJOINT", "\t# the legs\n\tJOINT")), read(4, "comment")),
    "a name of blanks": (plain(("LeftFoot", "Left  Foot (1)")), read(4)),
    "a name of 100,000 letters": (plain(("LeftFoot", "x" * 100_000)), read(4)),
    "no names": (plain(("LeftFoot", ""), ("LeftLeg", "")), read(4, "name-empty", "name-duplicate")),
    # headings
    "motion in lower case": (plain(("MOTION", "motion")), read(4, "heading-spelling")),
    "no word MOTION": (plain(("MOTION\n", "")), read(4, "motion-keyword-missing")),
    "no Frames": (plain(("Frames: 4\n", "")), read(4, "frames-missing")),
    "Frames of 1e12": (plain(("Frames: 4", "Frames: 1000000000000")), read(4, "frames-mismatch")),
    "Frames of 10,000 digits": (plain(("Frames: 4", "Frames: " + "9" * 10_000)),
        read(4, "frames-unreadable")),
    "Frames of nan": (plain(("Frames: 4", "Frames: nan")), read(4, "frames-unreadable")),
    "headings the other way round": (plain(("Frames: 4\nFrame Time: 0.0333333", "Frame Time: 0.0333333\nFrames: 4")),
        read(4)),
    "Frame Time close": (plain(("Time: 0", "Time:0")), read(4, "heading-spelling")),
    "Frame Time with comma": (plain(("0.0333333", "0,0333333")), read(4, "heading-spelling")),
    "FrameTime": (plain(("Frame Time", "FrameTime")), read(4, "heading-spelling")),
    "Frame Time of nothing": (plain((" 0.0333333", "")), read(4, "frame-time-unreadable")),
    "Frame Time of inf": (plain(("0.0333333", "inf")), read(4, "frame-time-unreadable")),
    "Frame Time of 1e-9": (plain(("0.0333333", "1e-9")), read(4, "frame-time-unreadable")),
    "Frame Time of 1/30": (plain(("0.0333333", "1/30")), read(4, "heading-spelling")),
    "Frame Time of 1/0": (plain(("0.0333333", "1/0")), read(4, "frame-time-unreadable", "heading-spelling")),
    "Frame Time of 0.5": (plain(("0.0333333", "0.5")), read(4, "frame-time-unusual")),
    # rows
    "no rows": (HEAD.encode(), read(0, "no-frames", "frames-mismatch")),
    "one row": (HEAD.encode() + ROWS.splitlines()[0].encode(), read(1, "one-frame", "frames-mismatch")),
    "two rows": (HEAD.encode() + "\n".join(ROWS.splitlines()[:2]).encode(), read(2, "frames-mismatch")),
    "nan": (plain(("0.10 9.01", "nan 9.01")), read(4, "value-nan")),
    "null": (plain(("0.10 9.01", "null 9.01")), read(4, "value-nan")),
    "inf": (plain(("0.10 9.01", "-inf 9.01")), read(4, "value-infinite")),
    "1e30": (plain(("0.10 9.01", "1e30 9.01")), read(4, "value-huge", "exponents", "jump")),
    "1e400": (plain(("0.10 9.01", "1e400 9.01")), read(4, "value-infinite", "exponents")),
    "a word": (plain(("0.10 9.01", "0.l0 9.01")), read(4, "not-a-number")),
    "two points": (plain(("0.10 9.01", "0.1.0 9.01")), read(4, "not-a-number")),
    "a line of text": (plain(("0.10 9.01", "take two\n0.10 9.01")), read(4, "text-in-rows")),
    "text at the end": (plain() + b"done.\n", read(4, "trailing-text")),
    "a second file": (plain() + plain(), read(4, "motion-repeated")),
    "short row": (plain(("9.90\n", "\n")), read(4, "row-short")),
    "short last row": (plain(("-175.00\n", "")), read(3, "last-row-cut", "frames-mismatch")),
    "long row": (plain(("9.90\n", "9.90 1 2\n")), read(4, "row-long")),
    "row doubled on a line": (plain(("9.90\n", "9.90 ")), read(4, "rows-wrapped")),
    "wrapped": (plain(*[(f"{x} ", f"{x}\n") for x in ("-4.50", "-4.40", "-4.30", "-4.20")]),
        read(4, "rows-wrapped")),
    "blank lines": (HEAD.encode() + ROWS.replace("\n", "\n\n").encode(), read(4)),
    "commas between": (HEAD.encode() + ROWS.replace(" ", ", ").encode(), read(4, "commas")),
    "decimal commas": (PLAIN.replace(".", ",").encode(), read(4, "decimal-comma", "heading-spelling")),
    "tabs and blanks": (HEAD.encode() + ROWS.replace(" ", " \t ").encode(), read(4)),
    "no channels at all": (b"HIERARCHY ROOT a { OFFSET 0 0 0 }\nMOTION\nFrames: 2\nFrame Time: 0.1\n\n\n",
        read(0, "end-site-missing", "frames-mismatch", "no-frames", "root-fixed", "brace-on-line")),
    "rows without channels": (
        b"HIERARCHY ROOT a { OFFSET 0 0 0 }\nMOTION\nFrames: 1\nFrame Time: 0.1\n1 2 3\n",
        refused("5:1: rows have 3 numbers, but the hierarchy has 0 channels")),
    "rows of words": (HEAD.encode() + b"end\n", refused("24:1: the rows are not numbers: 'end'")),
    "rows with semicolons": (
        HEAD.encode() + ROWS.replace(" ", ";").encode(),
        refused("24:1: the rows are not numbers: '0.00;9.00;0.00;1.00;2.00;3.00;-4.50;5.25...'")),
    "no rows but a word": (
        HEAD.replace("Frames: 4", "Frames: 0").encode() + b"end\n", read(0, "no-frames", "trailing-text")),
    # motions
    "frozen": (HEAD.encode() + (ROWS.splitlines()[0] + "\n").encode() * 4, read(4, "frozen")),
    "leap": (plain(("0.20 9.02", "999.20 9.02")), read(4, "jump")),
    "many turns": (plain(("9.90\n", "-99999.90\n")), read(4, "angle-unusual")),
    "two roots": (f"HIERARCHY\n{TREE}{TREE}MOTION\nFrames: 1\nFrame Time: 0.1\n{' '.join(['1'] * 24)}\n".encode(),
        read(1, "several-roots", "name-duplicate", "one-frame")),
    "zero bones": (plain(("1.00 -4.00 0.00", "0 0 0")), read(4, "bone-zero")),
}  # fmt: skip
OWN_FILES["utf-16 le"] = (OWN_FILES["utf-16 le"], read(4, "encoding-utf16", "byte-order-mark"))
OWN_FILES["utf-16 be"] = (OWN_FILES["utf-16 be"], read(4, "encoding-utf16", "byte-order-mark"))
