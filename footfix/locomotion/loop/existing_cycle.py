"""Clips that are cycles already: nothing is to be cut out of them, nor closed."""

from __future__ import annotations

import numpy as np

from footfix.enforce.papers.leg import effector_tracks
from footfix.enforce.task import pose_of
from footfix.locomotion.loop.root_motion import Travel, carrier, root_in_world, with_root
from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats
from footfix.motion.contacts import PUT_TO_REST, Contacts
from footfix.rig.cycle import find_cycle
from footfix.rig.rig import Rig

_TURNED = 1e-4  # [rad] what three decimals of a degree leave, and their sum over a few axes
_MOVED = 2e-4  # [leg lengths]
_FEWEST = 8  # frames
_LEADS = 0.3  # of the usual step, root mean square over the joints: a step over the seam like those beside it
_BENDS = 0.7  # of the usual step: as much may a step over the seam be unlike those beside it, where others are, too
_MOVES = 0.2  # of the usual step: less at the seam is a pause, not a stride
_HEIGHT = 0.02  # [leg lengths] by which the root's height may go on otherwise
_FEW, _RESTS = 4, 0.3  # steps of a plant that tell, and the share of them in which a foot rests that is held
_STILL = 1e-3  # [rad] a step less than this at the seam is a pose that is held


def closed_travel(clip: Clip, rig: Rig) -> Travel | None:
    """How a closed cycle travels in one round; None where the last frame is not the first one again.

    Args:
        clip: F frames.
        rig: its root and size.
    """
    if len(clip) < _FEWEST:
        return None
    root = carrier(clip, rig)
    ends = np.array([0, 1, len(clip) - 1])
    few = clip.frames(ends)
    place, turn = root_in_world(few, root)
    travel = travel_between((place[0], turn[0]), (place[2], turn[2]))
    again, turned = travel.places(place[0]), rotation.multiply(travel.turn, turn[0])
    below = [joint for joint in range(len(clip.skeleton)) if joint not in clip.skeleton.ancestors(root)]
    turns = np.stack([few.rotation(joint) for joint in below], axis=1)
    off = rotation.angle(rotation.multiply(turns[2], rotation.inverse(turns[0]))).max(initial=0.0)
    off = max(off, float(rotation.angle(rotation.multiply(turn[2], rotation.inverse(turned)))))
    far = max((float(np.abs(few.position(j)[2] - few.position(j)[0]).max()) for j in below), default=0.0)
    far = max(far, float(np.abs(place[2] - again).max()))
    goes = rotation.angle(rotation.multiply(turns[1], rotation.inverse(turns[0]))).max(initial=0.0) > _STILL
    return travel if goes and off <= _TURNED and far <= _MOVED * rig.leg_length else None


def put_to_rest(clip: Clip, rig: Rig, contacts: Contacts) -> bool:
    """Whether a program has held the feet of a cycle already, where they are planted: captured ones are never so still.

    Args:
        clip: L + 1 frames.
        rig: its legs and soles.
        contacts: of the cycle.
    """
    most = PUT_TO_REST * rig.leg_length * clip.frame_time
    for track, effector in zip(effector_tracks(rig, rig.pose(clip)), contacts.effectors, strict=True):
        still = np.linalg.norm(np.diff(track[:, [0, 2]], axis=0), axis=1) <= most
        for contact in effector.contacts:
            own = still[contact.start : contact.end - 1]
            if len(own) >= _FEW and own.mean() >= _RESTS:
                return True
    return False


def whole_cycle(clip: Clip, rig: Rig) -> Clip | None:
    """A clip that is one round as it is, or lacks its last frame; None where it is none.

    Its ends are alike, not the same: it is to be closed.
    """
    found = find_cycle(clip, rig, pose_of(clip, rig))
    return clip if found is not None and found.frames == len(clip) - 1 else completed(clip, rig)


def completed(clip: Clip, rig: Rig, held: bool = False) -> Clip | None:
    """A cycle whose last frame is a step before its first one, with the frame that it lacks; None where it is no cycle.

    How far the root goes in that step is what it goes in the one before it.

    Args:
        clip: F frames.
        rig: its root and size.
        held: whether its feet were put to rest by a program, as those of a loop are: the step may then bend more.
    """
    if len(clip) < _FEWEST or not _leads_on(clip, rig, _BENDS if held else _LEADS):
        return None
    root = carrier(clip, rig)
    frames = np.append(np.arange(len(clip)), 0)
    place, turn = root_in_world(clip, root)
    step = travel_between((place[-2], turn[-2]), (place[-1], turn[-1]))
    after = step.places(place[-1]), rotation.multiply(step.turn, turn[-1])
    travel = travel_between((place[0], turn[0]), after)
    place, turn = np.array(place[frames]), np.array(turn[frames])
    place[-1], turn[-1] = travel.places(place[0]), rotation.multiply(travel.turn, turn[0])
    return with_root(clip.frames(frames), root, place, turn)


def _leads_on(clip: Clip, rig: Rig, bends_most: float) -> bool:
    """Whether a step from the last frame to the first is what the steps before and after it make one expect.

    Args:
        clip: F frames.
        rig: its root and size.
        bends_most: of the usual step, by which it may differ from those beside it where others do, too.
    """
    root = carrier(clip, rig)
    below = [joint for joint in range(len(clip.skeleton)) if joint not in clip.skeleton.ancestors(root)]
    turns = np.stack([clip.rotation(joint) for joint in below], axis=1)  # (F, J, 4)
    every = np.concatenate([turns[-2:], turns, turns[:2]])
    steps = rotation.to_rotation_vector(rotation.multiply(rotation.inverse(every[:-1]), every[1:]))
    usual = _size(steps[2:-2])
    bends = np.sqrt(np.mean(np.sum((steps[1:-1] - 0.5 * (steps[:-2] + steps[2:])) ** 2, axis=-1), axis=-1))
    most = max(_LEADS * usual, min(float(bends[2:-2].max()), bends_most * usual))
    height = root_in_world(clip, root)[0][[-2, -1, 0, 1], 1]
    moves = usual > _STILL / 10.0 and min(_size(steps[0]), _size(steps[2])) >= _MOVES * usual
    rise = np.diff(height)
    return bool(moves and bends[0] < most and abs(rise[1] - 0.5 * (rise[0] + rise[2])) < _HEIGHT * rig.leg_length)


def _size(turns: Floats) -> float:
    """[rad] root mean square of rotation vectors (..., 3)."""
    return float(np.sqrt(np.mean(np.sum(turns**2, axis=-1))))


def travel_between(first: tuple[Floats, Floats], last: tuple[Floats, Floats]) -> Travel:
    """The travel that takes a root's place (3,) [m] and heading (4,) to others."""
    turn = Travel(float(rotation.yaw(rotation.multiply(last[1], rotation.inverse(first[1])))))
    x, _, z = last[0] - turn.places(first[0])
    return Travel(turn.yaw, float(x), float(z))
