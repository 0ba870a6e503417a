"""The strides of a clip, from one stance of a foot to its next, and differences between them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from footfix.motion import rotation
from footfix.motion.clip import Bools, Clip, Floats
from footfix.motion.contacts import Contacts, runs
from footfix.motion.kinematics import places
from footfix.rig.rig import Rig

_BRIEF = 0.08  # [s] shorter gaps between contacts do not end a stance
_SHORTEST = 0.3  # [s] of a stride
_LONGEST = 2.5  # [s]
_UNEVEN = 1.5  # longest stride, as a multiple of the usual one; a longer one has a pause, or a missed plant
_PHASES = 16  # at which strides are compared


@dataclass(frozen=True)
class Stride:
    """One stride: from the start of a foot's stance to the start of its next.

    Args:
        leg: index among `Rig.legs`.
        first, second: frames `[start, end)` of the two stances.
    """

    leg: int
    first: tuple[int, int]
    second: tuple[int, int]

    @property
    def frames(self) -> int:
        """Compute its length; from the ends of its stances where the clip begins in the first one."""
        edge = int(self.first[0] == 0)
        return self.second[edge] - self.first[edge]

    @property
    def start(self) -> int:
        """Compute its start, which is before the clip where that begins in the first stance."""
        return self.second[0] - self.frames


def stances(contacts: Contacts, rig: Rig, leg: int) -> list[tuple[int, int]]:
    """List the stances of a leg, frames `[start, end)` in which its heel or toe is planted."""
    own = [k for k, sole in enumerate(rig.soles) if sole.leg == leg]
    down: Bools = np.asarray(contacts.mask()[:, own].any(axis=1))
    brief = max(1, round(_BRIEF / contacts.frame_time))
    for start, end in runs(~down):
        if end - start < brief and start > 0 and end < len(down):
            down[start:end] = True
    return [each for each in runs(down) if each[1] - each[0] >= 2]


def find_strides(contacts: Contacts, rig: Rig) -> tuple[tuple[Stride, ...], ...]:
    """List the strides of each leg in order of time.

    On two legs the other foot must have a stance in between, which excludes half strides.

    Args:
        contacts: the effectors in the order of the rig.
        rig: its legs.
    """
    standing = [stances(contacts, rig, leg) for leg in range(len(rig.legs))]
    found = []
    for leg, own in enumerate(standing):
        others = [each for k, some in enumerate(standing) if k != leg for each in some]
        strides = [Stride(leg, a, b) for a, b in pairwise(own)]
        found.append([s for s in strides if len(rig.legs) != 2 or _stepped(s, others)])
    frames = [s.frames for own in found for s in own if s.frames * contacts.frame_time <= _LONGEST]
    if not frames:
        return tuple(() for _ in standing)
    most = min(_UNEVEN * float(np.median(frames)), _LONGEST / contacts.frame_time)
    least = max(_SHORTEST / contacts.frame_time, float(np.median(frames)) / _UNEVEN)
    return tuple(tuple(s for s in own if least <= s.frames <= most) for own in found)


def count_strides(contacts: Contacts, rig: Rig) -> int:
    """Count the strides of a closed cycle: strikes of a foot in a round.

    Args:
        contacts: of L + 1 frames, the last of which is the first one again.
        rig: its legs.
    """
    most = 0
    for leg in range(len(rig.legs)):
        own = stances(contacts, rig, leg)
        over = len(own) > 1 and own[0][0] == 0 and own[-1][1] == contacts.frames
        most = max(most, len(own) - over)
    return most


def _stepped(stride: Stride, others: Sequence[tuple[int, int]]) -> bool:
    """Tell whether the other foot comes down during the stride, or was planted before the clip began."""
    (a, _), (b, _) = stride.first, stride.second
    return any(a < start < b or (start == 0 and a == 0 and end < b) for start, end in others)


def weights(clip: Clip, rig: Rig) -> Floats:
    """Compute the weights (J,) of joints in pose comparison, with sum 1: half the length of a joint's bones.

    Joints above or beside the root are not part of the pose.
    """
    skeleton = clip.skeleton
    mine = np.array([rig.root in skeleton.ancestors(joint) for joint in range(len(skeleton))])
    bones = mine & (np.arange(len(skeleton)) != rig.root)
    length = np.linalg.norm(skeleton.offsets, axis=1) * bones
    share = length.copy()
    np.add.at(share, skeleton.parents[bones], length[bones])
    np.add.at(share, skeleton.end_parents, np.linalg.norm(skeleton.end_offsets, axis=1))
    share = share * mine
    return np.asarray(share / share.sum()) if share.sum() > 0.0 else mine / mine.sum()


def style_distances(clip: Clip, rig: Rig, strides: Sequence[Stride]) -> Floats:
    """Measure the difference of strides, (S, S) [leg lengths]: root mean square joint distance at equal phases.

    Poses are relative to the figure: without travel, each turned to the front by the line between its hips.

    Args:
        clip: F frames.
        rig: its legs.
        strides: S strides of one leg.
    """
    phase = np.linspace(0.0, 1.0, _PHASES, endpoint=False)
    times = np.concatenate([s.start + phase * s.frames for s in strides])
    seen = places(clip.frames(np.clip(np.rint(times), 0, len(clip) - 1).astype(np.intp)))
    hips = [leg.hip for leg in rig.legs]
    across = seen[:, hips[0]] - seen[:, hips[1]] if len(hips) == 2 else np.tile([1.0, 0.0, 0.0], (len(seen), 1))
    heading = np.arctan2(-across[:, 2], across[:, 0])
    front = rotation.about_vertical(-heading)
    seen = seen - seen[:, [rig.pelvis]] * [1.0, 0.0, 1.0]
    seen = rotation.rotate(front[:, None], seen) * np.sqrt(weights(clip, rig) / _PHASES)[:, None]
    rows = seen.reshape(len(strides), -1) / rig.leg_length
    square = np.einsum("si,si->s", rows, rows)
    return np.asarray(np.sqrt(np.maximum(square[:, None] + square - 2.0 * rows @ rows.T, 0.0)))
