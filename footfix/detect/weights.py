"""The fitted weights of detection, read once from the table beside this module.

`weights.txt` is written by `benchmarks/fit_auto.py`: sections of whole numbers, each headed by its name in brackets.
The numbers of the network are thousandths, those of the timing ten-thousandths; taps are grid steps.
"""

from __future__ import annotations

from functools import cache

import numpy as np

from footfix.detect.evidence import COLUMNS
from footfix.detect.network import Network
from footfix.detect.timing import Line, Timing
from footfix.motion.clip import Floats

THOUSANDTHS, TEN_THOUSANDTHS = 1e3, 1e4
PARTS = ("hidden_bias", "mixing", "mixing_bias", "answer", "answer_bias")  # of the network, after what is hidden


@cache
def network() -> Network:
    """Read the fitted weights of the network."""
    table = _fitted()
    centre = np.array([table[f"{name}: mean, spread"][0] for name in COLUMNS]) / THOUSANDTHS  # (E, 2)
    hidden = np.array([table[f"{name}: hidden"] for name in COLUMNS]) / THOUSANDTHS  # (E, T, H)
    rest: dict[str, Floats] = {part: np.array(table[part]) / THOUSANDTHS for part in PARTS}
    return Network(
        taps=tuple(table["taps"][0]), mean=centre[:, 0], spread=centre[:, 1], hidden=hidden.swapaxes(0, 1),
        hidden_bias=rest["hidden_bias"][0], mixing=rest["mixing"], mixing_bias=rest["mixing_bias"][0],
        answer=rest["answer"], answer_bias=rest["answer_bias"][0],
    )  # fmt: skip


@cache
def timing() -> Timing:
    """Read the fitted coefficients that refine landing and lift-off times."""
    table = _fitted()
    return Timing(landing=_line(table, "landing"), leaving=_line(table, "leaving"))


@cache
def _fitted() -> dict[str, list[list[int]]]:
    from importlib import resources  # slow to import, and most commands detect nothing

    return sections(resources.files("footfix.detect").joinpath("weights.txt").read_text(encoding="utf-8"))


def sections(text: str) -> dict[str, list[list[int]]]:
    """Split a table into the rows of each section; lines that start with # are remarks."""
    found: dict[str, list[list[int]]] = {}
    name = ""
    for row in text.splitlines():
        if row.startswith("["):
            name = row[1:-1]
            found[name] = []
        elif row and not row.startswith("#"):
            found[name].append([int(number) for number in row.split()])
    return found


def _line(table: dict[str, list[list[int]]], name: str) -> Line:
    bias, farthest = np.array(table[f"{name}: bias, farthest"][0]) / TEN_THOUSANDTHS
    weights = np.array(table[f"{name}: weights"][0]) / TEN_THOUSANDTHS
    return Line(tuple(table[f"{name}: taps"][0]), weights, float(bias), float(farthest))
