"""Text from strangers into HTML and JSON, so that it stays text.

File and joint names come from wherever the clip came from. Besides the characters that mean something in
HTML, the slash is written as a reference too: no name can then put an address into the page's source.
"""

from __future__ import annotations

import json
import re
from typing import Any

_HTML = str.maketrans(
    {"&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;", "'": "&#39;", "`": "&#96;", "/": "&#47;"}
    | {chr(code): "\N{REPLACEMENT CHARACTER}" for code in (*range(9), 11, 12, *range(14, 32), 127)}
)

_SEPARATORS = re.compile(r"(&#47;|_|-)")


def text(value: object) -> str:
    """Write a value as HTML text, safe within elements and within quoted attributes."""
    clean = str(value).encode("utf-8", "replace").decode("utf-8")  # a lone surrogate can't be written
    return clean.translate(_HTML)


def name(value: object) -> str:
    """Isolate a name from a file, so that its writing direction can't reorder the page around it."""
    return f"<bdi>{text(value)}</bdi>"


def path_name(value: object) -> str:
    """Isolate a name that may be long, as `name`; a line may break behind its separators."""
    return _SEPARATORS.sub(r"\1<wbr>", name(value))


def embedded_json(value: Any) -> str:
    """Write a document as JSON that can stand within a script element.

    Plain ASCII, with no character that could end the element or a line of script; `json.loads` and
    `JSON.parse` give back the very value.
    """
    dumped = json.dumps(value, ensure_ascii=True, allow_nan=False, separators=(",", ":"))
    for char in "<>&":
        dumped = dumped.replace(char, f"\\u{ord(char):04x}")
    return dumped.replace("/", "\\/")
