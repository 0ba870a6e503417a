"""Fixed-point formatting of whole arrays, by tables of three digits at a time."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from footfix.motion.clip import Bools, Floats

Bytes = NDArray[np.uint8]
Words = NDArray[np.uint32]  # four letters each

_MOST_PLACES = 9  # beyond that a double has no digits to spare, and numbers are formatted one by one


def _table(front: str, leading: bool = False, digits: int = 3) -> Words:
    """For 0 to 999: a letter or NUL, then its digits, as one word of four letters each.

    With `leading` there are no zeros in front, and of 0 nothing is left; without, the first `digits` are kept.
    """
    n = np.arange(1000)
    letters = np.zeros((1000, 4), dtype=np.uint8)
    letters[:, 1:] = np.stack([n // 100, n // 10 % 10, n % 10], axis=1) + ord("0")
    letters[:, 1 + digits :] = 0
    letters[:, 0] = ord(front) if front else 0
    if leading:
        letters[n < 100, 1] = 0
        letters[n < 10, 2] = 0
        letters[0] = 0
    return letters.view(np.uint32)[:, 0]


def _units(table: Words) -> Words:
    """The same table for the last three digits before the point, where of 0 a "0" is left."""
    table = table.copy()
    for row, front in ((0, 0), (1000, ord("-"))):
        table[row : row + 1].view(np.uint8)[:] = (front, 0, 0, ord("0"))
    return table


# Three digits before the point, by 0 to 999 plus 1000 times: 0 nothing before it, 1 the same and negative,
# 2 there are digits before it.
_BEFORE = np.concatenate([_table("", leading=True), _table("-", leading=True), _table("")])
_UNITS = _units(_BEFORE)
_POINT = [_table(".", digits=k) for k in range(4)]
_AFTER = [_table("", digits=k) for k in range(4)]


def fixed(values: Floats, places: int) -> Bytes:
    """Numbers as text with a fixed number of decimals: equal to `'%.*f'`, but that nothing prints as -0.

    Five to ten times faster than formatting one by one.

    Args:
        values: (N,) finite.
        places: digits after the point.

    Returns:
        (N, width) letters; NUL where there is none, so that deleting NUL joins them to words.
    """
    if not 0 < places <= _MOST_PLACES:
        return _one_by_one(values, places)
    with np.errstate(over="ignore", invalid="ignore"):
        return _by_tables(values, places)


def _by_tables(values: Floats, places: int) -> Bytes:
    scaled = values * 10.0**places
    nearest = np.rint(scaled)
    # The product is off by at most 2^-53 of itself: below 2^42 that is 2^-11, so only what lies closer to a
    # tie than 2^-10 can round otherwise than its exact decimal expansion.
    size = np.abs(scaled)
    hard: Bools = (np.abs(scaled - nearest) > 0.5 - 2.0**-10) | (size >= 2.0**42)
    largest = float(size.max(initial=0.0))
    if largest >= 2.0**42:
        nearest = np.where(hard, 0.0, nearest)
    whole, part = _split(np.abs(nearest), 10**places, np.uint32 if largest < 2.0**31 else np.uint64)
    groups = max(1, (len(str(int(whole.max(initial=0)))) + 2) // 3)
    out = np.empty((len(values), groups + (places + 2) // 3), dtype=np.uint32)
    state = (nearest < 0.0).astype(np.uint32) * 1000
    for k in range(groups):
        power = 1000 ** (groups - 1 - k)
        three = (whole // whole.dtype.type(power) % whole.dtype.type(1000)).astype(np.uint32)
        out[:, k] = (_BEFORE if power > 1 else _UNITS)[three + state]
        if power > 1:
            state[three > 0] = 2000
    _fraction(out[:, groups:], part, places)
    letters = out.view(np.uint8)
    if hard.any():
        by_hand = _one_by_one(values[hard], places)
        if by_hand.shape[1] > letters.shape[1]:
            letters = np.pad(letters, ((0, 0), (0, by_hand.shape[1] - letters.shape[1])))
        letters[hard] = 0
        letters[hard, : by_hand.shape[1]] = by_hand
    return letters


def _split(size: Floats, unit: int, dtype: type[np.unsignedinteger]) -> tuple[NDArray, NDArray]:  # type: ignore[type-arg]
    number = size.astype(dtype)
    whole = number // dtype(unit)
    return whole, number - whole * dtype(unit)


def _fraction(out: Words, part: NDArray, places: int) -> None:  # type: ignore[type-arg]
    """Writes the point and the digits after it."""
    count = out.shape[1]
    part = (part * part.dtype.type(10 ** (3 * count - places))).astype(np.uint32)  # below 10^9
    for k in range(count - 1, -1, -1):
        part, three = part // np.uint32(1000), part % np.uint32(1000)
        digits = min(3, places - 3 * k)
        out[:, k] = (_AFTER if k else _POINT)[digits][three]


def _one_by_one(values: Floats, places: int) -> Bytes:
    words = [b"%.*f" % (places, value) for value in values.tolist()]
    words = [word[1:] if word[:1] == b"-" and not word.strip(b"-0.") else word for word in words]
    width = max(map(len, words), default=1)
    return np.array(words, dtype=f"S{width}").view(np.uint8).reshape(-1, width)
