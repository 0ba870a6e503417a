"""The hierarchy as read: joints, channels, End Sites."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from footfix.motion.clip import Skeleton


class Channel(NamedTuple):
    """One column of the motion rows.

    Args:
        joint: index of its joint; -1 for a channel of an End Site, or of a kind that is ignored (scale).
        kind: "P" position, "R" rotation, "" ignored.
        axis: 0, 1, 2 for x, y, z.
    """

    joint: int
    kind: str
    axis: int


@dataclass
class Hierarchy:
    """What the reader of the hierarchy found; the lists run over joints in the order of the file."""

    names: list[str] = field(default_factory=list)
    parents: list[int] = field(default_factory=list)
    offsets: list[tuple[float, float, float]] = field(default_factory=list)
    places: list[int] = field(default_factory=list)  # where in the text each joint is named
    ends: list[tuple[int, tuple[float, float, float]]] = field(default_factory=list)
    channels: list[Channel] = field(default_factory=list)
    end_channels: list[int] = field(default_factory=list)  # columns that End Sites own
    miscounts: list[tuple[int, int, int]] = field(default_factory=list)  # where, said, named

    def skeleton(self) -> Skeleton:
        """Make the skeleton in the units and axes of the file."""
        n = len(self.names)
        moved, turned = np.zeros((n, 3), dtype=bool), np.zeros((n, 3), dtype=bool)
        for channel in self.channels:
            if channel.kind:
                (moved if channel.kind == "P" else turned)[channel.joint, channel.axis] = True
        turns = np.bincount([c.joint for c in self.channels if c.kind == "R"], minlength=n)
        return Skeleton(
            names=tuple(self.names),
            parents=np.array(self.parents, dtype=np.intp),
            offsets=np.array(self.offsets).reshape(n, 3),
            end_parents=np.array([joint for joint, _ in self.ends], dtype=np.intp),
            end_offsets=np.array([offset for _, offset in self.ends]).reshape(-1, 3),
            translates=np.asarray(moved.all(axis=1)),
            rotates=np.asarray(turned.all(axis=1) & (turns == 3)),
        )
