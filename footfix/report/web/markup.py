"""Escape text of unknown origin for HTML and JSON.

File and joint names come with the clip. Besides the special characters of HTML, the slash is escaped too: no name can
then put an address into the page's source.
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
    clean = str(value).encode("utf-8", "replace").decode("utf-8")  # a lone surrogate can't be encoded
    return clean.translate(_HTML)


def name(value: object) -> str:
    """Write a name from a file as HTML; its writing direction does not affect the text around it."""
    return f"<bdi>{text(value)}</bdi>"


def path_name(value: object) -> str:
    """Write a long name as `name` does; a line may break after its separators."""
    return _SEPARATORS.sub(r"\1<wbr>", name(value))


def embedded_json(value: Any) -> str:
    """Write a document as JSON that is safe within a script element.

    It is plain ASCII without characters that could end the element or a line of script; `json.loads` and `JSON.parse`
    return the same value.
    """
    dumped = json.dumps(value, ensure_ascii=True, allow_nan=False, separators=(",", ":"))
    for char in "<>&":
        dumped = dumped.replace(char, f"\\u{ord(char):04x}")
    return dumped.replace("/", "\\/")
