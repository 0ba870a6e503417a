"""Recognise clips that are closed cycles already, and need no cutting or closing."""

from __future__ import annotations

import numpy as np

from footfix.enforce.task import pose_of
from footfix.locomotion.loop.root_motion import Travel, carrier, root_in_world, with_root
from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats
from footfix.motion.contacts import PUT_TO_REST, Contacts
from footfix.rig.cyclic_clip import find_cycle
from footfix.rig.rig import Rig

_TURNED = 1e-4  # [rad] rounding error of angles with three decimals of a degree
_MOVED = 2e-4  # [leg lengths]
_FEWEST = 8  # frames
_LEADS = 0.3  # of the usual step (rms over the joints): greatest difference of the seam's step from its neighbours
_BENDS = 0.7  # of the usual step: the same where other steps differ from their neighbours as much
_MOVES = 0.2  # of the usual step: a smaller step across the seam is a pause, not a stride
_HEIGHT = 0.02  # [leg lengths] greatest discontinuity of the root's height
_FEW, _RESTS = 4, 0.3  # least number of steps of a plant, and the share of them at rest in a locked foot
_STILL = 1e-3  # [rad] a smaller step across the seam is a held pose


def closed_travel(clip: Clip, rig: Rig) -> Travel | None:
    """Find the travel of a closed cycle in one round; None where the last frame does not repeat the first.

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
    """Tell whether a program has locked the planted feet of a cycle: captured feet are never so still.

    Args:
        clip: L + 1 frames.
        rig: its legs and soles.
        contacts: of the cycle.
    """
    most = PUT_TO_REST * rig.leg_length * clip.frame_time
    for track, effector in zip(rig.held(rig.pose(clip)), contacts.effectors, strict=True):
        still = np.linalg.norm(np.diff(track[:, [0, 2]], axis=0), axis=1) <= most
        for contact in effector.contacts:
            own = still[contact.start : contact.end - 1]
            if len(own) >= _FEW and own.mean() >= _RESTS:
                return True
    return False


def whole_cycle(clip: Clip, rig: Rig) -> Clip | None:
    """Get a clip that is one round as it is, or lacks its last frame; None for other clips.

    Its ends are similar, not equal: it still has to be closed.
    """
    found = find_cycle(clip, rig, pose_of(clip, rig))
    return clip if found is not None and found.frames == len(clip) - 1 else completed(clip, rig)


def completed(clip: Clip, rig: Rig, held: bool = False) -> Clip | None:
    """Add the missing last frame to a cycle that ends one step before its first frame; None for other clips.

    The root moves in that step as in the one before it.

    Args:
        clip: F frames.
        rig: its root and size.
        held: whether its feet were locked by a program, as in a loop: the step may then differ more.
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
    """Tell whether the step from the last frame to the first is consistent with the steps before and after it.

    Args:
        clip: F frames.
        rig: its root and size.
        bends_most: greatest difference from neighbouring steps, in usual steps, where others differ as much.
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
    """Compute the root mean square of rotation vectors (..., 3) [rad]."""
    return float(np.sqrt(np.mean(np.sum(turns**2, axis=-1))))


def travel_between(first: tuple[Floats, Floats], last: tuple[Floats, Floats]) -> Travel:
    """Compute the travel from a root's place (3,) [m] and heading (4,) to others."""
    turn = Travel(float(rotation.yaw(rotation.multiply(last[1], rotation.inverse(first[1])))))
    x, _, z = last[0] - turn.places(first[0])
    return Travel(turn.yaw, float(x), float(z))
