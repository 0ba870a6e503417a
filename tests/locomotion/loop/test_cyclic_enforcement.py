"""Rounds laid end to end: no contact is lost where only some frames, or some rounds, are looked at."""

from __future__ import annotations

import numpy as np
import pytest

from footfix.locomotion.loop.cyclic_enforcement import cropped, laid_contacts, thinned
from footfix.motion.contacts import Contact, Contacts, Effector

LENGTH = 24
CONTACTS = Contacts(
    LENGTH + 1,
    1 / 30,
    (
        Effector("left_heel", "left", "heel", "Foot", (Contact(0, 5), Contact(9, 10), Contact(20, 25))),
        Effector("left_toe", "left", "toe", "Toe", (Contact(3, 14),)),
    ),
)


def spans(planted: tuple[tuple, ...]) -> list[list[tuple[int, int]]]:  # type: ignore[type-arg]
    return [[(each.contact.start, each.contact.end) for each in own] for own in planted]


@pytest.mark.parametrize("start", [0, 2, 21, 30])
def test_what_is_cropped_is_what_lies_in_these_frames(start: int) -> None:
    laid = laid_contacts(CONTACTS, 3)
    frames = 3 * LENGTH + 1 - 2 * start
    for whole, part in zip(spans(laid), spans(cropped(laid, start, frames)), strict=True):
        on = np.zeros(3 * LENGTH + 1, dtype=bool)
        for a, b in whole:
            on[a:b] = True
        some = np.zeros(frames, dtype=bool)
        for a, b in part:
            some[a:b] = True
        assert np.array_equal(some, on[start : start + frames])


@pytest.mark.parametrize("every", [1, 2, 3])
@pytest.mark.parametrize("first", [0, 1])
def test_of_fewer_frames_each_contact_has_those_that_it_had_and_one_at_least(every: int, first: int) -> None:
    laid = laid_contacts(CONTACTS, 3)
    which = np.arange(first, 3 * LENGTH + 1, every)
    for whole, part in zip(spans(laid), spans(thinned(laid, which)), strict=True):
        assert len(whole) == len(part)
        for (a, b), (start, end) in zip(whole, part, strict=True):
            inside = np.flatnonzero((which >= a) & (which < b))
            assert end - start == max(len(inside), 1)
            assert len(inside) == 0 or start == inside[0]
            assert 0 <= start < end <= len(which)
