"""Contacts: when each effector is planted."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from footfix.errors import ArgumentError
from footfix.motion.clip import Bools, Floats
from footfix.notes import Note

Part = Literal["heel", "toe"]
Wish = Literal["force", "forbid"]

# [leg lengths/s] A slower foot was locked by a program: captured feet are never so still for long.
PUT_TO_REST = 0.0012


@dataclass(frozen=True)
class Contact:
    """One stretch of frames in which an effector is planted.

    Args:
        start: the first frame in contact.
        end: the first frame after it.
        confidence: how likely it is right, 0 to 1.
        position: (x, y, z) [m] where it is planted, if that is known or asked for.
        wish: set by a person or a label file: "force" is enforced at any cost, "forbid" says that there is no contact
            here, whatever the detector finds.
    """

    start: int
    end: int
    confidence: float = 1.0
    position: tuple[float, float, float] | None = None
    wish: Wish | None = None


@dataclass(frozen=True)
class Effector:
    """A sole point by name, and when it is planted.

    Args:
        name: leg name and part, `left_heel`.
        side: "left", "right", or the leg's own name on a figure with more legs.
        part: "heel" or "toe".
        joint: name of the joint that carries the point.
        contacts: in order of time, not overlapping.
    """

    name: str
    side: str
    part: Part
    joint: str
    contacts: tuple[Contact, ...] = ()


@dataclass(frozen=True)
class Contacts:
    """The contacts of a clip.

    Examples:
        >>> heel = Effector("left_heel", "left", "heel", "LeftFoot")
        >>> found = Contacts(4, 1 / 30, (heel,)).with_mask(np.array([[0], [1], [1], [0]]))
        >>> [(contact.start, contact.end) for contact in found["left_heel"].contacts]
        [(1, 3)]

    Args:
        frames: frames of the clip.
        frame_time: [s].
        effectors: in the order of the rig: left heel, left toe, right heel, right toe.
        method: which detector found them, "labels" where they were given.
        notes: from the detector.
    """

    frames: int
    frame_time: float
    effectors: tuple[Effector, ...]
    method: str = "labels"
    notes: tuple[Note, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(effector.name for effector in self.effectors)

    def __getitem__(self, name: str) -> Effector:
        for effector in self.effectors:
            if effector.name == name:
                return effector
        raise KeyError(name)

    def mask(self) -> Bools:
        """Lay contacts out as (F, E), True where an effector is planted; forbidden stretches are not contacts."""
        mask = np.zeros((self.frames, len(self.effectors)), dtype=np.bool_)
        for e, effector in enumerate(self.effectors):
            for contact in effector.contacts:
                if contact.wish != "forbid":
                    mask[contact.start : contact.end, e] = True
        return mask

    def only(self, names: Iterable[str]) -> Contacts:
        """Take the contacts of some effectors."""
        wanted = frozenset(names)
        return replace(self, effectors=tuple(each for each in self.effectors if each.name in wanted))

    def with_mask(self, mask: Bools, confidence: Floats | None = None) -> Contacts:
        """Replace the contacts of the same effectors by those of a mask (F, E).

        `confidence` (F, E), if given, is averaged over each contact and rounded like label files, so that contacts give
        the same result directly and after being written and read. It stays below 1, which marks contacts that were
        given.
        """
        mask = self._fitting("the mask", mask)
        if mask.dtype != np.bool_ and not np.isin(mask, (0, 1)).all():
            raise ArgumentError("the mask must hold True and False (or 1 and 0); of likelihoods give `mask > 0.5`")
        mask = mask.astype(np.bool_)
        if confidence is not None:
            confidence = self._fitting("confidence", confidence)
        effectors = tuple(
            replace(
                effector,
                contacts=tuple(
                    Contact(a, b, 1.0 if confidence is None else _sureness(confidence[a:b, e]))
                    for a, b in runs(mask[:, e])
                ),
            )
            for e, effector in enumerate(self.effectors)
        )
        return replace(self, effectors=effectors)

    def _fitting(self, what: str, array: NDArray[Any]) -> NDArray[Any]:
        """Check that an array has the frames and effectors of these contacts, (F, E)."""
        array, wanted = np.asarray(array), (self.frames, len(self.effectors))
        if array.shape != wanted:
            names = ", ".join(self.names)
            raise ArgumentError(f"{what} must be {wanted}: {wanted[0]} frames of {names}; it is {array.shape}")
        return array


def _sureness(confidence: Floats) -> float:
    return min(round(float(confidence.mean()), 4), 0.9999)


def joined(parts: Sequence[Contacts]) -> Contacts:
    """Join the effectors of several."""
    return replace(
        parts[0],
        effectors=tuple(effector for part in parts for effector in part.effectors),
        notes=tuple(note for part in parts for note in part.notes),
    )


def runs(mask: Bools) -> list[tuple[int, int]]:
    """List the stretches `[start, end)` in which a mask (F,) is True."""
    # searching in bytes takes a tenth of the time of comparing neighbours, which matters for short masks
    marks = np.asarray(mask, dtype=np.bool_).tobytes()
    found, start = [], marks.find(1)
    while start >= 0:
        end = marks.find(0, start)
        end = len(marks) if end < 0 else end
        found.append((start, end))
        start = marks.find(1, end)
    return found
