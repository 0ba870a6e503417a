"""Joints outside the legs that are where a foot is: found by where they are, and taken along by a correction."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from walks import cleaned, rig_of
from walks import short_walk as walk

from footfix.enforce.correction import Correction, apply
from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats, Skeleton
from footfix.motion.contacts import Contacts
from footfix.motion.kinematics import forward
from footfix.rig.followers import Follower, find_followers, left_behind
from footfix.rig.rig import Rig

Y = np.array([0.0, 1.0, 0.0])


def skating() -> tuple[Clip, Contacts]:
    """A walker whose root wanders, so that its feet skate."""
    made = walk()
    t = np.arange(len(made.clip)) * made.clip.frame_time
    places = np.array(made.clip.position(0))
    places[:, 0] += 0.04 * np.sin(3.0 * t)
    return made.clip.with_joints({0: places}, {}), made.contacts


def with_joint(
    clip: Clip, name: str, parent: str, place: Floats, turn: Floats, *, translates: bool = True
) -> Clip:
    """The clip with one more joint, at (F, 3) [m] and turned by (F, 4) in the world."""
    skeleton, above = clip.skeleton, clip.skeleton.names.index(parent)
    pose = forward(clip, [above])
    back = rotation.inverse(pose.rotation(above))
    local = rotation.rotate(back, place - pose.position(above))
    more = Skeleton(
        (*skeleton.names, name), np.append(skeleton.parents, above), np.vstack([skeleton.offsets, local[0]]),
        skeleton.end_parents, skeleton.end_offsets, np.append(skeleton.translates, translates),
        np.append(skeleton.rotates, True),
    )  # fmt: skip
    return Clip(
        more,
        np.concatenate([clip.positions, local[:, None]], axis=1),
        np.concatenate([clip.rotations, rotation.multiply(back, turn)[:, None]], axis=1),
        clip.frame_time,
    )


def on(clip: Clip, name: str, parent: str, joint: str, *, offset: Floats | None = None, turned: bool = True) -> Clip:
    """The clip with one more joint that is where another is, or fixed beside it; turned as it is, or not at all."""
    at = clip.skeleton.names.index(joint)
    pose = forward(clip, [at])
    place = pose.point(at, np.zeros(3) if offset is None else offset)
    turn = pose.rotation(at) if turned else rotation.identity((len(clip),))
    return with_joint(clip, name, parent, place, turn)


def helped() -> tuple[Clip, Contacts]:
    """A walker with targets as game rigs have them, all below the root of its helpers, which turns and goes along."""
    clip, contacts = skating()
    t = np.arange(len(clip)) * clip.frame_time
    go = np.stack([0.1 * t, 0.0 * t, 0.7 * t], axis=1)
    clip = _rooted(clip)
    clip = with_joint(clip, "helpers", "world", go, rotation.from_axis_angle(Y, 0.3 * t))
    clip = on(clip, "target_l", "helpers", "LeftFoot")
    clip = on(clip, "target_r", "helpers", "RightFoot", turned=False)
    clip = on(clip, "target_toe", "target_l", "LeftToeBase")
    clip = on(clip, "control", "helpers", "RightFoot", offset=np.array([0.0, -0.05, -0.1]))
    foot = forward(clip).position(clip.skeleton.names.index("RightFoot"))
    clip = with_joint(clip, "below", "helpers", foot - 0.1 * Y, rotation.identity((len(clip),)))
    clip = on(clip, "hand", "helpers", "Spine", offset=np.array([0.1, 0.2, 0.5]))
    return with_joint(clip, "rider", "target_r", forward(clip).position(clip.skeleton.names.index("target_r")) + Y,
                      rotation.identity((len(clip),))), contacts  # fmt: skip


def _rooted(clip: Clip) -> Clip:
    """The clip below one more joint that stays where it is."""
    s = clip.skeleton
    more = Skeleton(
        ("world", *s.names), np.concatenate([[-1], s.parents + 1]), np.vstack([np.zeros(3), s.offsets]),
        s.end_parents + 1, s.end_offsets, np.concatenate([[True], s.translates]), np.concatenate([[True], s.rotates]),
    )  # fmt: skip
    still, unturned = np.zeros((len(clip), 1, 3)), rotation.identity((len(clip), 1))
    return Clip(
        more, np.concatenate([still, clip.positions], axis=1), np.concatenate([unturned, clip.rotations], axis=1),
        clip.frame_time,
    )  # fmt: skip


def rig_below() -> Rig:
    """The walker's rig, one joint further on."""
    rig = rig_of(walk())
    legs = tuple(
        replace(
            leg, hip=leg.hip + 1, knee=leg.knee + 1, ankle=leg.ankle + 1, toe=(leg.toe or 0) + 1,
            chain=tuple(joint + 1 for joint in leg.chain),
        )
        for leg in rig.legs
    )  # fmt: skip
    soles = tuple(replace(sole, joint=sole.joint + 1) for sole in rig.soles)
    return replace(rig, root=1, pelvis=1, legs=legs, soles=soles)


def test_they_are_found_by_where_they_are() -> None:
    clip, _ = helped()
    names = clip.skeleton.names
    found = find_followers(clip, rig_below())
    told = {names[each.joint]: (names[each.foot], each.turns, each.level) for each in found}
    assert told == {
        "target_l": ("LeftFoot", True, False), "target_r": ("RightFoot", False, False),
        "target_toe": ("LeftToeBase", True, False), "control": ("RightFoot", True, False),
        "below": ("RightFoot", False, True),
    }  # fmt: skip


def test_what_is_fixed_to_the_ankle_may_be_nearer_to_the_toe() -> None:
    clip, _ = skating()
    ankle = clip.skeleton.names.index("LeftFoot")
    beside = on(clip, "beside", "Hips", "LeftFoot", offset=np.array([0.02, -0.03, 0.13]), turned=False)
    (found,) = find_followers(beside, rig_of(walk()))
    assert (found.foot, found.level) == (ankle, False)
    places = clip.position(0).copy()
    places[:] = places[:1] + np.outer(np.linspace(0.0, 0.01, len(clip)), [1.0, 0.0, 0.0])  # [m]
    turns = {joint: np.repeat(clip.rotation(joint)[:1], len(clip), axis=0) for joint in range(len(clip.skeleton))}
    gliding = _rooted(clip.with_joints({0: places}, turns))  # no joint turns, and feet go one centimetre
    (found,) = find_followers(
        on(gliding, "beside", "world", "LeftFoot", offset=np.array([0.02, -0.03, 0.13])), rig_below()
    )
    assert found.foot == ankle + 1


def test_what_is_near_for_a_while_or_cannot_be_moved_is_none() -> None:
    clip, _ = skating()
    rig = rig_of(walk())
    assert find_followers(clip, rig) == ()
    clip = _rooted(clip)
    still = on(clip, "left", "world", "LeftFoot")
    places = still.positions.copy()
    places[len(clip) // 2 :, -1, 1] += 0.2  # it lets go of the foot
    assert find_followers(replace(still, positions=places), rig_below()) == ()
    bound = replace(still.skeleton, translates=np.append(still.skeleton.translates[:-1], False))
    assert find_followers(replace(still, skeleton=bound), rig_below()) == ()
    (note,) = left_behind(replace(still, skeleton=bound), rig_below(), ())
    assert note.joints == ("left",) and "position channels" in note.text
    assert left_behind(still, rig_below(), find_followers(still, rig_below())) == ()
    stand = clip.frames(np.zeros(50, dtype=np.intp))  # all is fixed to all where nothing moves
    beside = on(stand, "beside", "world", "LeftFoot", offset=np.array([0.0, 0.1, 0.1]))
    assert find_followers(beside, rig_below()) == ()


def test_they_go_along_with_the_foot_and_what_is_no_helper_of_it_stays() -> None:
    clip, contacts = helped()
    after, found = cleaned(clip, rig_below(), contacts)
    assert "followers" in {note.id for note in found.notes}
    names = clip.skeleton.names
    was, now = forward(clip), forward(after)

    def moved(joint: str) -> float:
        k = names.index(joint)
        return float(np.linalg.norm(was.position(k) - now.position(k), axis=1).max())

    def strays(joint: str, foot: str) -> tuple[float, float]:  # [m], [rad] in the frame of the foot
        k, f = names.index(joint), names.index(foot)
        places = [rotation.rotate(rotation.inverse(p.rotation(f)), p.position(k) - p.position(f)) for p in (was, now)]
        turns = [rotation.multiply(rotation.inverse(p.rotation(f)), p.rotation(k)) for p in (was, now)]
        twist = rotation.angle(rotation.multiply(rotation.inverse(turns[0]), turns[1])).max()
        return float(np.abs(places[1] - places[0]).max()), float(twist)

    assert moved("LeftFoot") > 0.02 and moved("RightFoot") > 0.02, "there was to be something to do"
    for joint, foot in (("target_l", "LeftFoot"), ("target_toe", "LeftToeBase"), ("control", "RightFoot")):
        assert strays(joint, foot)[0] < 1e-8 and strays(joint, foot)[1] < 1e-7
    assert strays("target_r", "RightFoot")[0] < 1e-8
    foot, below = names.index("RightFoot"), names.index("below")
    assert now.position(foot) - now.position(below) == pytest.approx(was.position(foot) - was.position(below), abs=1e-9)
    r = names.index("target_r")
    assert rotation.angle(rotation.multiply(rotation.inverse(was.rotation(r)), now.rotation(r))).max() < 1e-7
    assert np.allclose(
        now.position(names.index("rider")) - now.position(r), was.position(names.index("rider")) - was.position(r)
    )
    for joint in ("helpers", "hand", "world"):
        assert moved(joint) == pytest.approx(0.0, abs=1e-12)


def test_where_the_foot_stays_the_numbers_do() -> None:
    clip, _ = helped()
    names = clip.skeleton.names
    joint, foot, knee = (names.index(name) for name in ("target_l", "LeftFoot", "LeftLeg"))
    turns = np.array(clip.rotation(knee))
    bend = rotation.from_axis_angle(np.array([1.0, 0.0, 0.0]), np.full(20, 0.1))
    turns[40:60] = rotation.multiply(turns[40:60], bend)
    frames = len(clip)
    correction = Correction(1, np.zeros((frames, 3)), (knee,), turns[:, None], (Follower(joint, foot, True),))
    after = apply(clip, correction)
    rest = np.r_[0:40, 60:frames]
    for before, now in ((clip.position(joint), after.position(joint)), (clip.rotation(joint), after.rotation(joint))):
        assert np.array_equal(before[rest], now[rest]) and np.all(np.any(before[40:60] != now[40:60], axis=1))
    nothing = Correction(1, np.zeros((frames, 3)), (), np.zeros((frames, 0, 4)), (Follower(joint, foot, True),))
    assert apply(clip, nothing) is clip
