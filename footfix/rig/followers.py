"""Helper joints that follow the feet, such as targets of inverse kinematics outside the legs.

Game rigs have such joints beside the skeleton proper. They are found by their motion, not by name.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats
from footfix.motion.kinematics import Pose, forward
from footfix.notes import Note
from footfix.rig.rig import Rig

_FRAMES = 240  # frames sampled
_AT = 0.01  # [leg lengths] a joint follows a foot's joint if it is usually nearer to it than this,
_NEVER = 0.05  # and never farther away than this,
_FIXED = 0.004  # [leg lengths] or if its place beside the foot varies by less than this,
_BESIDE = 0.35  # [leg lengths] not farther away than this,
_STEADY = 0.08  # and by less than this share of the way the foot goes in the world, and in the frame of its parent,
_MOVES = 0.005  # [leg lengths] which is at least this
_ALONG = 0.1  # [rad] a joint whose orientation relative to the foot varies by no more than this turns with it


@dataclass(frozen=True)
class Follower:
    """A joint that follows a foot.

    Args:
        joint: of the helper.
        foot: the joint of the foot that it follows.
        turns: whether it turns with the foot, too.
        level: whether its place beside the foot does not turn with the foot, as that of a point straight below it.
    """

    joint: int
    foot: int
    turns: bool
    level: bool = False


def find_followers(clip: Clip, rig: Rig) -> tuple[Follower, ...]:
    """Find the joints outside the legs that follow a foot's joint, or are fixed to it, over the whole clip.

    Args:
        clip: F frames.
        rig: its legs.

    Returns:
        The followers, parents before their children; without joints that have no position channels to follow with.
    """
    able = _outside(clip, rig)
    if not able or not len(clip):
        return ()
    at = np.unique(np.linspace(0, len(clip) - 1, min(_FRAMES, len(clip))).astype(np.intp))
    feet = [joint for leg in rig.legs for joint in (leg.ankle, leg.toe) if joint is not None]
    parents = {int(clip.skeleton.parents[joint]) for joint in able} - {-1}
    pose = forward(clip.frames(at), sorted({*able, *feet, *parents}))
    found = []
    for joint in able:
        near = min(feet, key=lambda foot: float(np.median(_apart(pose, joint, foot))))
        if _at(pose, joint, near, rig.leg_length):
            found.append(Follower(joint, near, _turns_along(pose, joint, near)))
        else:
            found += _beside(pose, joint, feet, int(clip.skeleton.parents[joint]), rig.leg_length)
    return tuple(found)


def left_behind(clip: Clip, rig: Rig, followers: Sequence[Follower]) -> tuple[Note, ...]:
    """Make a note on joints outside the legs that follow a foot but have no position channels to be moved by.

    Args:
        clip: F frames.
        rig: its legs.
        followers: joints that can be moved; their children follow, too.
    """
    led = {each.joint for each in followers}
    fixed = [j for j in _outside(clip, rig, movable=False) if not led & set(clip.skeleton.ancestors(j))]
    if not fixed or len(clip) < 2:
        return ()
    at = np.unique(np.linspace(0, len(clip) - 1, min(_FRAMES, len(clip))).astype(np.intp))
    feet = [joint for leg in rig.legs for joint in (leg.ankle, leg.toe) if joint is not None]
    pose = forward(clip.frames(at), sorted({*fixed, *feet}))

    def there(joint: int) -> bool:
        far = [_apart(pose, joint, foot) / rig.leg_length for foot in feet]
        return any(np.median(each) < _AT and each.max() < _NEVER for each in far)

    names = tuple(clip.skeleton.names[joint] for joint in fixed if there(joint))
    if not names:
        return ()
    text = f"outside the legs, where the feet are, but without position channels to go along: {', '.join(names)}"
    return (Note("followers-fixed", text, "warning", joints=names),)


def _outside(clip: Clip, rig: Rig, *, movable: bool = True) -> list[int]:
    """List the joints, with or without position channels, that belong to no leg and are above none."""
    skeleton = clip.skeleton
    tops = {leg.hip for leg in rig.legs}
    bearing = {rig.root, rig.pelvis}
    for leg in rig.legs:
        bearing.update((leg.hip, *skeleton.ancestors(leg.hip)))
    able = np.flatnonzero(skeleton.translates == movable).tolist()
    return [joint for joint in able if joint not in bearing and not tops & {joint, *skeleton.ancestors(joint)}]


def _apart(pose: Pose, joint: int, foot: int) -> Floats:
    """Measure the distance (F,) [m] between two joints."""
    return np.asarray(np.linalg.norm(pose.position(joint) - pose.position(foot), axis=1))


def _in_frame(pose: Pose, joint: int, frame: int) -> Floats:
    """Compute the place (F, 3) [m] of a joint in another's frame."""
    turn = rotation.inverse(pose.rotation(frame))
    return rotation.rotate(turn, pose.position(joint) - pose.position(frame))


def _at(pose: Pose, joint: int, foot: int, leg_length: float) -> bool:
    """Tell whether a joint is where a foot's joint is."""
    far = _apart(pose, joint, foot) / leg_length
    return bool(np.median(far) < _AT and far.max() < _NEVER)


def _beside(pose: Pose, joint: int, feet: Sequence[int], parent: int, leg_length: float) -> list[Follower]:
    """Find the foot's joint that a joint is fixed beside, in the foot's frame or in the world's axes; none or one."""
    near = [foot for foot in feet if _apart(pose, joint, foot).max() <= _BESIDE * leg_length]
    if not near:
        return []
    places = {
        (foot, level): pose.position(joint) - pose.position(foot) if level else _in_frame(pose, joint, foot)
        for foot in near for level in (False, True)
    }  # fmt: skip
    varies = {key: float(np.linalg.norm(each - np.median(each, axis=0), axis=1).max()) for key, each in places.items()}
    rigid = 0.1 * _FIXED * leg_length  # where a foot hardly bends, all its joints are alike: the ankle comes first
    foot, level = min(varies, key=lambda key: max(varies[key], rigid))
    ways = [pose.position(foot), *([_in_frame(pose, foot, parent)] if parent >= 0 else [])]
    moves = min(float(np.ptp(way, axis=0).max()) for way in ways)
    if moves < _MOVES * leg_length or varies[foot, level] > min(_FIXED * leg_length, _STEADY * moves):
        return []
    return [Follower(joint, foot, _turns_along(pose, joint, foot), level)]


def _turns_along(pose: Pose, joint: int, foot: int) -> bool:
    between = rotation.multiply(rotation.inverse(pose.rotation(foot)), pose.rotation(joint))
    middle = rotation.multiply(rotation.inverse(between[len(between) // 2][None]), between)
    return bool(np.median(rotation.angle(middle)) < _ALONG)
