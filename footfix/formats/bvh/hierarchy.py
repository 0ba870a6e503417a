"""The HIERARCHY part: joints, offsets, channels and End Sites, read word by word."""

from __future__ import annotations

import re
from dataclasses import dataclass
from difflib import get_close_matches

import numpy as np

from footfix.formats.bvh.numbers import number
from footfix.formats.bvh.text import Cursor, Limits, Notes, readable
from footfix.formats.bvh.tree import Channel, Hierarchy

_CHANNEL = re.compile(rb"([xyz])[_-]?(pos(?:ition)?|trans(?:lation)?|rot(?:ation)?|scal(?:e|ing))", re.IGNORECASE)
_END = re.compile(rb"end(?:[_-]?site)?", re.IGNORECASE)
_NUMBERISH = re.compile(rb"[-+.,]?\d|[-+]?nan|[-+]?inf|[-+]?1\.#", re.IGNORECASE)
_CHANNEL_NAMES = tuple(b"%c%s" % (axis, kind) for axis in b"XYZ" for kind in (b"position", b"rotation"))
_USUAL = (b"HIERARCHY", b"ROOT", b"JOINT", b"OFFSET", b"CHANNELS", b"{", b"}")
_HEADINGS = (b"MOTION", b"FRAMES", b"FRAME", b"FRAMES:", b"FRAMETIME", b"FRAMETIME:")
_WORDS = ("HIERARCHY", "ROOT", "JOINT", "End", "OFFSET", "CHANNELS", "MOTION")


@dataclass
class _Open:
    """A block whose brace is open: a joint, or an End Site of a joint."""

    joint: int
    end_site: bool
    at: int
    offset: bool = False
    channels: bool = False
    brace: bool = True


def read_hierarchy(cursor: Cursor, limits: Limits) -> Hierarchy:
    """Read up to the MOTION part, and leave the cursor before it.

    Raises:
        InputError: it has no meaning as a hierarchy.
    """
    tree, stack, notes = Hierarchy(), list[_Open](), cursor.notes
    _begin(cursor)
    while True:
        word = cursor.peek()
        key = word.upper()
        if not word or key in _HEADINGS or key.startswith((b"FRAMES:", b"FRAMETIME:")):
            break
        if not (stack or tree.names or key in (b"ROOT", b"JOINT", b"}", b"HIERARCHY")):
            raise cursor.fail(f"the hierarchy begins with '{readable(word)}', not with ROOT", hint="it is damaged")
        if cursor.start > limits.header:
            what = f"there is no MOTION in the first {limits.header} bytes"
            raise cursor.fail(what, hint="limits.header allows more")
        cursor.take()
        _spelling(cursor, word, (b"End",) if _END.fullmatch(word) else _USUAL)
        if key in (b"ROOT", b"JOINT"):
            _open_joint(cursor, tree, stack, key)
            if len(tree.names) > limits.joints:
                raise cursor.fail(f"more than {limits.joints} joints", hint="limits.joints allows more")
            if len(stack) > limits.nesting:
                what = f"joints are nested more than {limits.nesting} deep"
                raise cursor.fail(what, hint="limits.nesting allows more")
        elif key == b"}":
            _close(cursor, tree, stack)
        elif key == b"HIERARCHY" and not stack:
            continue
        else:
            _property(cursor, tree, stack, word)
    _finish(cursor, tree, stack, notes)
    return tree


def _property(cursor: Cursor, tree: Hierarchy, stack: list[_Open], word: bytes) -> None:
    """Read one property of a joint: its OFFSET, its CHANNELS, or its End Site."""
    key = word.upper()
    if stack and _END.fullmatch(word):
        _open_end_site(cursor, tree, stack)
    elif stack and key == b"OFFSET":
        _offset(cursor, tree, stack)
    elif stack and key == b"CHANNELS":
        _channels(cursor, tree, stack[-1])
    else:
        raise _unknown(cursor, word)


def _spelling(cursor: Cursor, word: bytes, usual: tuple[bytes, ...]) -> None:
    if word not in usual and not cursor.notes.has("spelling"):
        cursor.notes.add("spelling", f"'{readable(word)}' is spelled in a way that strict readers don't know",
                         at=cursor.start)  # fmt: skip


def _begin(cursor: Cursor) -> None:
    """Step over HIERARCHY and over what stands before it."""
    if cursor.text.startswith(b"\xef\xbb\xbf"):
        cursor.pos = 3
        cursor.notes.add("byte-order-mark", "the file begins with a byte order mark, which strict readers refuse", at=0)
    word = cursor.peek()
    if word.upper() in (b"HIERARCHY", b"ROOT"):
        if word.upper() == b"ROOT":
            cursor.notes.add("hierarchy-keyword-missing", "the word HIERARCHY is missing", at=cursor.start)
        return
    start = cursor.start
    found = re.compile(rb"^[ \t]*HIERARCHY\b", re.IGNORECASE | re.MULTILINE).search(cursor.text, start, start + 65536)
    if found and b"\0" not in cursor.text[start : found.start()]:
        cursor.notes.add("leading-text", "there is text before HIERARCHY; passed over", "warning", at=start)
        cursor.pos = found.start()
    elif word.upper() in _HEADINGS or _NUMBERISH.match(word):
        raise cursor.fail("the file has motion rows but no HIERARCHY", hint="the part with the skeleton is missing")
    else:
        raise cursor.fail(f"this is no BVH file: it begins with '{readable(word)}', not with HIERARCHY",
                          hint="give a BVH")  # fmt: skip


def _unknown(cursor: Cursor, word: bytes) -> Exception:
    shown = readable(word)
    near = get_close_matches(shown.upper(), [each.upper() for each in _WORDS], n=1)
    hint = f"is {near[0]} meant?" if near else "OFFSET, CHANNELS, JOINT, End Site or a brace can stand here"
    return cursor.fail(f"'{shown}' means nothing in a hierarchy", hint=hint)


def _braced(cursor: Cursor) -> bool:
    """Tell whether braces in the rest of the line are part of a name: the joint's own brace is on the next line."""
    # names are short; a line may be very long, and must not be scanned whole for each of its joints
    line = re.compile(rb"([^\r\n]{0,1000})[\r\n]+\s*\{").match(cursor.text, cursor.pos)
    return line is not None and b"{" in line[1] and not line[1].rstrip().endswith(b"{")


def _name(cursor: Cursor) -> str:
    """Read the rest of the line, or up to the brace; spaces inside are part of it."""
    raw = cursor.line(stop=b"" if _braced(cursor) else b"{").strip()
    if not raw and cursor.peek().upper() not in (b"{", b"}", b"OFFSET", b"CHANNELS", b""):
        cursor.pos = cursor.start
        raw = cursor.line(stop=b"{").strip()
    try:
        return raw.decode("utf-8")
    except UnicodeDecodeError:
        name = raw.decode("latin-1")
        if not cursor.notes.has("name-encoding"):
            cursor.notes.add("name-encoding", f"the name '{readable(raw)}' is not UTF-8; shown as Latin-1",
                             at=cursor.start, joints=(name,))  # fmt: skip
        return name


def _brace(cursor: Cursor, what: str) -> bool:
    before = cursor.pos
    if cursor.peek() == b"{":
        if not (cursor.text[before : cursor.start].strip(b" \t") or cursor.notes.has("brace-on-line")):
            cursor.notes.add("brace-on-line", "braces stand on the line of the name, which strict readers refuse",
                             at=cursor.start)  # fmt: skip
        cursor.take()
        return True
    if not cursor.peek() or cursor.peek() == b"}":
        raise cursor.fail(f"{what} has no opening brace", hint="the file is cut short or damaged")
    cursor.notes.add("brace-missing", f"{what} has no opening brace; read as if it had", "warning", at=cursor.start)
    return False


def _open_joint(cursor: Cursor, tree: Hierarchy, stack: list[_Open], key: bytes) -> None:
    at, notes = cursor.start, cursor.notes
    name = _name(cursor)
    shown = readable(name)
    if stack and stack[-1].end_site:
        raise cursor.fail(f"joint '{shown}' stands inside an End Site", at=at, hint="a brace is missing above it")
    if key == b"ROOT" and stack:
        notes.add("brace-unclosed", f"a new ROOT begins before {len(stack)} braces were closed", "warning", at=at)
        stack.clear()
    if key == b"JOINT" and not stack:
        if tree.names:
            what = f"joint '{shown}' stands outside any ROOT"
            raise cursor.fail(what, at=at, hint="there is a brace too many above it")
        notes.add("root-keyword", "the first joint is called JOINT, not ROOT; read as the root", at=at)
    tree.names.append(name)
    tree.parents.append(stack[-1].joint if stack else -1)
    tree.offsets.append((0.0, 0.0, 0.0))
    tree.places.append(at)
    if not name:
        notes.add("name-empty", "a joint has no name", at=at)
    _brace(cursor, f"joint '{shown}'")
    stack.append(_Open(len(tree.names) - 1, False, at))


def _open_end_site(cursor: Cursor, tree: Hierarchy, stack: list[_Open]) -> None:
    at = cursor.start
    if stack[-1].end_site:
        raise cursor.fail("an End Site stands inside an End Site", hint="a brace is missing above it")
    cursor.line(stop=b"{")  # `Site`, and a label that some exporters write
    braced = _brace(cursor, "the End Site")
    tree.ends.append((stack[-1].joint, (0.0, 0.0, 0.0)))
    stack.append(_Open(stack[-1].joint, True, at, brace=braced))


def _close(cursor: Cursor, tree: Hierarchy, stack: list[_Open]) -> None:
    if not stack:
        if not cursor.notes.has("brace-extra"):
            cursor.notes.add("brace-extra", "a closing brace too many; passed over", "warning", at=cursor.start)
        return
    block = stack.pop()
    if not block.offset:
        what = "an End Site" if block.end_site else f"joint '{readable(tree.names[block.joint])}'"
        cursor.notes.add("offset-missing", f"{what} has no OFFSET; taken as 0 0 0", "warning", at=block.at)


def _offset(cursor: Cursor, tree: Hierarchy, stack: list[_Open]) -> None:
    at, numbers, block = cursor.start, list[float](), stack[-1]
    if block.offset:
        raise cursor.fail("a second OFFSET for the same joint", hint="a brace or a JOINT line is missing above it")
    while len(numbers) < 3:
        word = cursor.peek()
        plain = word.strip(b"[(,;)]")
        value = number(plain)
        if value is None:
            found = "nothing more" if word.isalpha() or word in (b"{", b"}", b"") else f"'{readable(word)}'"
            raise cursor.fail(f"OFFSET needs 3 numbers, {found} after {len(numbers)}", hint="complete the line")
        if plain != word and not cursor.notes.has("offset-brackets"):
            cursor.notes.add("offset-brackets", "an OFFSET has brackets or commas; read without", at=cursor.start)
        if b"," in plain and not cursor.notes.has("decimal-comma"):
            cursor.notes.add("decimal-comma", "numbers have a decimal comma, which few readers take; read as such",
                             at=cursor.start)  # fmt: skip
        cursor.take()
        numbers.append(value)
    if not np.all(np.abs(numbers) < 1e9):
        shown = " ".join(f"{x:g}" for x in numbers)
        cursor.notes.add("offset-not-a-number", f"an OFFSET is not a number, or far too large: {shown}",
                         "error", at=at, joints=(tree.names[block.joint],))  # fmt: skip
    while number(cursor.peek()) is not None:
        if not cursor.notes.has("offset-long"):
            cursor.notes.add("offset-long", "an OFFSET has more than 3 numbers; the first 3 are used", "warning", at=at)
        cursor.take()
    block.offset = True
    if block.end_site:
        tree.ends[-1] = (block.joint, (numbers[0], numbers[1], numbers[2]))
        if not block.brace:
            stack.pop()  # an End Site without braces has nothing else to say
    else:
        tree.offsets[block.joint] = (numbers[0], numbers[1], numbers[2])


def _channels(cursor: Cursor, tree: Hierarchy, block: _Open) -> None:
    at = cursor.start
    if block.channels:
        raise cursor.fail("a second CHANNELS for the same joint", hint="a brace or a JOINT line is missing above it")
    block.channels = True
    count = number(cursor.peek())
    if count is None or not count.is_integer() or not 0 <= count < 1000:
        raise cursor.fail(f"CHANNELS needs a count, not '{readable(cursor.peek())}'", hint="say how many names follow")
    cursor.take()
    said, named = int(count), 0
    while found := _CHANNEL.fullmatch(cursor.peek()):
        cursor.take()
        _spelling(cursor, found[0], _CHANNEL_NAMES)
        kind = {b"p": "P", b"t": "P", b"r": "R"}.get(found[2][:1].lower(), "")
        if block.end_site:
            tree.end_channels.append(len(tree.channels))
            kind = ""
        elif not kind and not cursor.notes.has("channel-scale"):
            cursor.notes.add("channel-scale", "scale channels are passed over", "warning", at=cursor.start)
        channel = Channel(block.joint if kind else -1, kind, b"xyz".index(found[1].lower()))
        if kind == "P" and channel in tree.channels[len(tree.channels) - named :]:
            raise cursor.fail(f"{readable(found[0])} is named twice for one joint", hint="name each axis once")
        tree.channels.append(channel)
        named += 1
    word = cursor.peek()
    ends = word.upper() in (b"JOINT", b"{", b"}", b"OFFSET", b"CHANNELS", b"") or _END.fullmatch(word)
    if named < said and not ends:
        hint = "Xposition to Zposition and Xrotation to Zrotation can stand here"
        raise cursor.fail(f"'{readable(word)}' is no channel", hint=hint)
    if named != said:
        tree.miscounts.append((at, said, named))
    if block.end_site and named and not cursor.notes.has("channels-end-site"):
        cursor.notes.add("channels-end-site", "an End Site has channels, which move nothing", at=at)


def _finish(cursor: Cursor, tree: Hierarchy, stack: list[_Open], notes: Notes) -> None:
    at = cursor.start
    if not tree.names:
        raise cursor.fail("the hierarchy has no ROOT", hint="there is no skeleton in this file")
    if at >= len(cursor.text):
        what = "the hierarchy ends in the middle" if stack else "the file ends after the hierarchy"
        raise cursor.fail(f"{what}: there is no MOTION", hint="the file is cut short; export or download it again")
    if stack:
        many = f"{len(stack)} braces are" if len(stack) > 1 else "one brace is"
        notes.add("brace-unclosed", f"{many} not closed before MOTION; read as if they were", "warning", at=at)
    if notes.has("brace-unclosed") or notes.has("brace-extra"):
        _check_indents(cursor, tree)


def _check_indents(cursor: Cursor, tree: Hierarchy) -> None:
    """Check by the indentation, where braces don't pair up, whether the tree is still the intended one."""
    depths, indents = list[int](), dict[int, bytes]()
    for joint, (parent, at) in enumerate(zip(tree.parents, tree.places, strict=True)):
        depths.append(depths[parent] + 1 if parent >= 0 else 0)
        start = max(cursor.text.rfind(b"\n", 0, at), cursor.text.rfind(b"\r", 0, at)) + 1
        indent = cursor.text[start:at]
        if indent.strip() or not (indent or depths[joint] == 0):
            return  # several joints on a line, or no indentation: nothing to check by
        if indents.setdefault(depths[joint], indent) != indent:
            raise cursor.fail(
                f"braces don't pair up: joint '{readable(tree.names[joint])}' is {depths[joint]} deep by "
                "braces, but not by its indentation", at=at, hint="a brace is missing, or there is one too many, above",
            )  # fmt: skip
