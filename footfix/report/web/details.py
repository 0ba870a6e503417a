"""The details of a report: every value of its rig, correction and settings in words, as a row of a table."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from footfix.report.verdict import Report, floor_taken
from footfix.report.web.markup import text

_PARTS = {
    "": "Run",
    "rig": "Rig",
    "figures": "Figures",
    "correction": "Correction",
    "settings": "Settings",
    "seconds": "Times",
}
# Ending of a key -> the unit of its value.
_UNITS = {
    "m": "m", "mm": "mm", "cm": "cm", "deg": "degrees", "s": "s", "cm_s": "cm/s", "m_s": "m/s", "m_s2": "m/s²",
    "deg_s": "degrees/s", "hz": "Hz", "fps": "frames/s",
}  # fmt: skip


def details_table(report: Report) -> str:
    """Write rig, correction, settings and times as table rows, under a heading for each part."""
    parts = []
    for key, title in _PARTS.items():
        part = report.get(key) if key else {name: report.get(name) for name in ("method", "output")}
        rows = list(_leaves((), part))
        if key == "rig" and floor_taken(report):  # with where it is from, in the place of the bare number
            rows = [(("floor",), floor_taken(report), ""), *(row for row in rows if row[0] != ("floor",))]
        if key == "seconds":
            rows = [(path, value, unit or "s") for path, value, unit in rows]
        if rows:
            parts.append(f'<tr class="part"><th scope="rowgroup" colspan="2">{title}</th></tr>')
            parts += [_row(path, value, unit) for path, value, unit in rows]
    return "\n".join(parts)


def _row(path: Sequence[str], value: str, unit: str) -> str:
    shown = " › ".join(path)
    return f'<tr><th scope="row">{text(shown)}</th><td>{text(value)}{f" {text(unit)}" if unit else ""}</td></tr>'


def _leaves(path: tuple[str, ...], value: Any, unit: str = "") -> Iterator[tuple[tuple[str, ...], str, str]]:
    """List path, words and unit of every value within a value; those without words are left out."""
    if isinstance(value, Mapping):
        for key, item in value.items():
            words, of_key = _words_of(str(key))
            yield from _leaves((*path, words), item, of_key)
    elif isinstance(value, list | tuple) and any(isinstance(item, Mapping) for item in value):
        for k, item in enumerate(value):
            named = item.get("name") if isinstance(item, Mapping) else None
            inner = {key: each for key, each in item.items() if key != "name"} if named else item
            yield from _leaves((*path, str(named).replace("_", " ") if named else str(k + 1)), inner)
    else:
        said = _said(value)
        if said:
            yield path, said, unit


def _words_of(key: str) -> tuple[str, str]:
    """Split a key into its words and the unit that it ends in."""
    pieces = key.split("_")
    for count in (3, 2, 1):
        unit = "_".join(pieces[-count:])
        if len(pieces) > count and unit in _UNITS:
            return " ".join(pieces[:-count]), _UNITS[unit]
    return " ".join(pieces), ""


def _said(value: Any) -> str:
    """Write a value in words; "" for one that is not shown."""
    if value is None or value == "":
        return ""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, list | tuple):
        nested = any(isinstance(item, list | tuple) for item in value)
        return ("; " if nested else ", ").join(_said(item) or "none" for item in value)
    return str(value)
