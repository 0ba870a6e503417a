"""Events of a stream: strikes and lifts of effectors, each reported once."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Kind = Literal["strike", "lift"]


@dataclass(frozen=True)
class Event:
    """A strike or a lift of a sole point.

    Args:
        kind: "strike" or "lift".
        effector: name of the sole point, `left_heel`.
        frame: number of its first frame in contact, or of the first after it, since the stream began.
        time: [s] since the first frame; between two frames where that is known.
        confidence: how likely the contact is right, 0 to 1.
    """

    kind: Kind
    effector: str
    frame: int
    time: float
    confidence: float

    def moved(self, frames: int, frame_time: float) -> Event:
        """Shift the event by so many frames."""
        return Event(self.kind, self.effector, self.frame + frames, self.time + frames * frame_time, self.confidence)
