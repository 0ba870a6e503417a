"""Estimate the soles, heel and ball of each foot, from the pose in which the foot lies flat; and the floor.

A skeleton's ankle is about 8 cm above the floor, and no joint marks the heel. So typical proportions are used, measured
on 130 feet with markers: the ankle is 0.075 to 0.11 leg lengths above the floor, the MTP joint (the ball) 0.04 to
0.065, and the back of the heel 0.07 behind the ankle. The heel touches the floor a little in front of its back.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from footfix.motion import rotation
from footfix.motion.clip import Bools, Floats, Ints
from footfix.rig.frame_sample import Sample

# In leg lengths, except shares.
_ANKLE_HEIGHT, _ANKLE_HEIGHTS = 0.095, (0.06, 0.14, 0.115)  # the usual one, least, most, most of a guess
_BALL_HEIGHT, _BALL_HEIGHTS = 0.045, (0.025, 0.06)
_TIP_HEIGHT = 0.012  # of the tip of the toes
_HEEL_BEHIND = 0.07
_BALL_AHEAD = 0.16
_DEEPEST = 0.13  # if the toe joint is farther below its ankle, the foot is not flat
_PAW = 0.1  # length of the sole of a paw
_ON_TOES = 0.2  # a foot that reaches this far below its ankle stands on its toes
_BALL_OF_TIP = 0.72  # distance of the ball ahead of the ankle, as a share of the tip's
_HEEL_OF_BALL = 0.45  # distance of the heel behind the ankle, as a share of the ball's distance ahead
_STILL = 0.25  # [leg lengths / s] a foot that moves less may be standing
_LEVEL = 0.12  # [leg lengths / s] a foot that rises and falls less may be standing on something that moves
OVER_LOW = 0.01  # of a sole point
MESH_OVER_LOW = 0.08  # of the lowest vertex of a foot, of which toe and heel are a part
_OFTEN = 0.4  # share of the most used level's frames that makes another height a level too


@dataclass(frozen=True)
class SoleEstimate:
    """A foot that lies flat, seen from its ankle.

    Args:
        up, ahead: unit vectors in the ankle's frame.
        up_at_toe: the unit vector up in the toe joint's frame; None without one.
        ankle_height, ball_height: above the floor, in the clip's units. Without a toe joint, the height at which it
            would be; 0 where a foot stands on the tips of its toes.
        behind: how far the heel is behind the ankle.
        reach: how far the ball is ahead of the ankle.
        drop: how far the toe joint lies below the ankle; the lowest tip on a foot without one.
        usual: how high that joint or tip usually is over a floor.
        guessed: what had to be assumed, since the clip does not show it.
        measured: whether its heights are measured over the file's zero plane, not assumed.
        ball: (3,) the toe joint in the ankle's frame; None without one.
        toe_turn: (4,) the toe joint's frame in the ankle's; None without one.
    """

    up: Floats
    ahead: Floats
    up_at_toe: Floats | None
    ankle_height: float
    ball_height: float
    behind: float
    reach: float
    drop: float
    usual: float
    guessed: tuple[str, ...]
    measured: bool = False
    ball: Floats | None = None
    toe_turn: Floats | None = None

    @property
    def origin(self) -> str:
        """Describe how it was found."""
        how = "a usual foot on this leg" if self.guessed else "the pose in which the foot lies flat"
        return f"{how}, its height over the file's zero plane" if self.measured else how


UP = np.array([0.0, 1.0, 0.0])


def foot(sample: Sample, ankle: int, toe: int | None, facing: Floats, leg: float) -> SoleEstimate:
    """Estimate how a foot lies when it is flat on the floor.

    Args:
        sample: frames of a clip [m], y up.
        ankle, toe: its joints.
        facing: (S, 3) the way the figure faces, level, in the world.
        leg: leg length [m].
    """
    flat = _flat_frames(sample, [ankle] if toe is None else [ankle, toe], leg)
    back = rotation.inverse(sample.turns[flat, ankle])
    up = _usual(rotation.rotate(back, UP))
    seen = _seen_from(sample, ankle, tips(sample, ankle) if toe is None else [sample.places[:, toe]], flat)
    tip = max(seen, key=lambda each: float(np.linalg.norm(_level(each, up))), default=np.zeros(3))
    guessed: tuple[str, ...] = ()
    if toe is not None and not -0.02 * leg <= -float(tip @ up) <= _DEEPEST * leg:
        guessed = ("slope",)
        up = _upright(tip, up, (_ANKLE_HEIGHT - _BALL_HEIGHT) * leg)
    ahead = _level(tip, up)
    if np.linalg.norm(ahead) < 0.03 * leg:
        guessed = (*guessed, "direction")
        ahead = _level(_usual(rotation.rotate(back, facing[flat])), up)
    ahead = ahead / max(float(np.linalg.norm(ahead)), 1e-12)
    far, deep = float(tip @ ahead), max((-float(each @ up) for each in seen), default=0.0)
    if toe is None:
        return _without_toe(up, ahead, far, deep, leg, guessed)
    up_at_toe = _usual(rotation.rotate(rotation.inverse(sample.turns[flat, toe]), UP))
    below = max((-float(each @ up_at_toe) for each in _seen_from(sample, toe, tips(sample, toe), flat)), default=0.0)
    ball = _BALL_HEIGHT * leg if below <= 0.0 else _within(below + _TIP_HEIGHT * leg, _BALL_HEIGHTS, leg)
    height = _within(deep + ball, _ANKLE_HEIGHTS, leg)
    usual = _BALL_HEIGHT * leg
    turns = rotation.multiply(back, sample.turns[flat, toe])
    return SoleEstimate(
        up, ahead, up_at_toe, height, ball, _behind(far, leg), far, deep, usual, guessed, ball=seen[0],
        toe_turn=_usual(turns * np.sign(turns @ turns[len(turns) // 2] + 1e-12)[:, None]),
    )  # fmt: skip


def _without_toe(
    up: Floats, ahead: Floats, far: float, deep: float, leg: float, guessed: tuple[str, ...]
) -> SoleEstimate:
    """Describe a foot of one piece from the ankle on, its tip so `far` ahead, its deepest point so `deep` below."""
    if deep > _ON_TOES * leg:
        return _on_toes(up, ahead, far, deep, leg)
    end_at_ball = far < 0.5 * (_BALL_AHEAD + _BALL_AHEAD / _BALL_OF_TIP) * leg
    height = _ANKLE_HEIGHT * leg
    end_height = (_BALL_HEIGHT if end_at_ball else _TIP_HEIGHT) * leg
    if deep > 0.02 * leg:
        most = max(_ANKLE_HEIGHTS[2] * leg, deep + _TIP_HEIGHT * leg)
        height = float(np.clip(deep + end_height, _ANKLE_HEIGHTS[0] * leg, most))
    # the MTP joint is on the bone from the ankle to the end of the foot, if that slopes as a foot does
    on_bone = end_height + (0.0 if end_at_ball else (1.0 - _BALL_OF_TIP) * deep)
    ball = _within(on_bone, _BALL_HEIGHTS, leg) if deep > 0.02 * leg else _BALL_HEIGHT * leg
    if far < 0.03 * leg:
        guessed, far, end_at_ball = (*guessed, "length"), _BALL_AHEAD * leg, True
    ball_ahead = float(np.clip(far * (1.0 if end_at_ball else _BALL_OF_TIP), 0.1 * leg, 0.22 * leg))
    return SoleEstimate(
        up, ahead, None, height, ball, _behind(ball_ahead, leg), ball_ahead, deep, end_height, guessed
    )


def paw(sample: Sample, ankle: int, leg: float) -> SoleEstimate:
    """Estimate how the foot of a four-legged animal stands: on its toes, the ankle high.

    Args:
        sample: frames of a clip [m], y up.
        ankle: its joint.
        leg: leg length [m].
    """
    below = sample.below(ankle)
    ends = [e for e, parent in enumerate(sample.skeleton.end_parents.tolist()) if parent in below]
    below = below[1:] if len(below) + len(ends) > 1 else below  # the hock itself is on the ground when the animal sits
    places = np.concatenate([sample.places[:, below], sample.ends[:, ends]], axis=1)
    velocities = np.concatenate([sample.velocities[:, below], sample.end_velocities[:, ends]], axis=1)
    deepest = int(np.argmin(np.quantile(places[..., 1], 0.2, axis=0)))
    rest = resting(places[:, [deepest], 1], velocities[:, [deepest]], leg)[:, 0]
    low = places[:, deepest, 1] <= np.quantile(places[rest, deepest, 1], 0.5) + 0.03 * leg
    frames = np.flatnonzero(rest & low)
    up = _usual(rotation.rotate(rotation.inverse(sample.turns[frames, ankle]), UP))
    (tip,) = _seen_from(sample, ankle, [places[:, deepest]], frames)
    ahead = _level(tip, up)
    ahead = ahead / max(float(np.linalg.norm(ahead)), 1e-12)
    return _on_toes(up, ahead, float(tip @ ahead), max(0.0, -float(tip @ up)), leg)


def _on_toes(up: Floats, ahead: Floats, far: float, deep: float, leg: float) -> SoleEstimate:
    height = deep + _TIP_HEIGHT * leg
    return SoleEstimate(up, ahead, None, height, 0.0, _PAW * leg - far, far, deep, _TIP_HEIGHT * leg, ())


def _within(value: float, limits: tuple[float, ...], leg: float) -> float:
    return float(np.clip(value, limits[0] * leg, limits[1] * leg))


def _upright(tip: Floats, up: Floats, deep: float) -> Floats:
    """Find the direction nearest to `up` for which a tip is so deep below the ankle, as usual feet are."""
    along = tip / max(float(np.linalg.norm(tip)), 1e-12)
    across = up - (up @ along) * along
    across = across / max(float(np.linalg.norm(across)), 1e-12)
    sine = min(0.9, deep / max(float(np.linalg.norm(tip)), 1e-12))
    return np.asarray(np.sqrt(1.0 - sine * sine) * across - sine * along)


def _behind(ahead: float, leg: float) -> float:
    """Estimate how far the heel is behind the ankle when the ball is this far ahead of it."""
    return float(np.clip(_HEEL_OF_BALL * ahead, 0.04 * leg, _HEEL_BEHIND * leg))


def _flat_frames(sample: Sample, joints: list[int], leg: float) -> Ints:
    """Find the frames in which a foot most likely stands flat: still and low. (n,) indices.

    Args:
        sample: frames of a clip.
        joints: the ankle, and the toe joint where there is one.
        leg: leg length.
    """
    heights, velocities = sample.places[:, joints, 1], sample.velocities[:, joints]
    rest = resting(heights, velocities, leg).all(axis=1)
    if not rest.any():
        rest = heights[:, 0] <= np.quantile(heights[:, 0], 0.2)
    low = heights[:, 0] <= float(np.quantile(heights[rest, 0], 0.5)) + 0.03 * leg
    return np.flatnonzero(rest & low)


def _usual(vectors: Floats) -> Floats:
    """Find the direction (3,) that most of `vectors` (n, 3) have."""
    centre = np.median(vectors, axis=0)
    for _ in range(3):
        centre = centre / max(float(np.linalg.norm(centre)), 1e-12)
        closeness = vectors @ centre / np.maximum(np.linalg.norm(vectors, axis=-1), 1e-12)
        near = closeness >= min(0.966, float(np.quantile(closeness, 0.5)))  # within 15 degrees, or the nearer half
        centre = np.mean(vectors[near], axis=0)
    return np.asarray(centre / max(float(np.linalg.norm(centre)), 1e-12))


def _level(vector: Floats, up: Floats) -> Floats:
    return np.asarray(vector - (vector @ up) * up)


def tips(sample: Sample, joint: int) -> list[Floats]:
    """List the tracks (S, 3) of all joints and End Sites below a joint."""
    below = sample.below(joint)
    ends = enumerate(sample.skeleton.end_parents.tolist())
    return [sample.places[:, j] for j in below[1:]] + [sample.ends[:, e] for e, parent in ends if parent in below]


def _seen_from(sample: Sample, joint: int, tracks: list[Floats], frames: Ints) -> list[Floats]:
    """Find where tracks (S, 3) usually are in a joint's frame, each (3,)."""
    origin, back = sample.places[frames, joint], rotation.inverse(sample.turns[frames, joint])
    return [np.median(rotation.rotate(back, track[frames] - origin), axis=0) for track in tracks]


def alike(feet: list[SoleEstimate], ends: list[str]) -> list[SoleEstimate]:
    """Give left and right foot of one end of the body the mean of their measures.

    Both feet have equally thick soles: where they seem to differ, one foot was seldom flat. What only one foot shows is
    used for both.
    """
    out = list(feet)
    for end in set(ends):
        pair = [i for i, own in enumerate(ends) if own == end]
        if len(pair) != 2:
            continue
        a, b = (feet[i] for i in pair)
        if (a.up_at_toe is None) != (b.up_at_toe is None):
            continue
        sure = [foot for foot in (a, b) if not foot.guessed] or [a, b]
        means = {name: sum(getattr(foot, name) for foot in sure) / len(sure) for name in _MEASURES}
        for i in pair:
            out[i] = replace(feet[i], **means)
    return out


_MEASURES = ("ankle_height", "ball_height", "behind", "reach", "drop", "usual")


def floor(
    heights: Floats, velocities: Floats, leg: float, over: float = OVER_LOW
) -> tuple[float, tuple[float, ...]]:  # fmt: skip
    """Find the lowest height at which soles rest often, and the others at which they do.

    A figure that jumps off a box or walks up stairs rests on several levels; the floor is the lowest level that is used
    at least `_OFTEN` times as often as the most used one.

    Args:
        heights: (S, P) [m] of the sole points.
        velocities: (S, P, 3) [m/s].
        leg: leg length [m].
        over: as in `resting`.
    """
    values = np.sort(heights[resting(heights, velocities, leg, over)])
    band = 0.015 * leg
    count = np.searchsorted(values, values + band, side="right") - np.searchsorted(values, values - band)
    levels = []
    left = count.copy()
    while left.max() > _OFTEN * count.max():
        level = values[np.argmax(left)]
        levels.append(float(np.median(values[np.abs(values - level) <= band])))
        left[np.abs(values - level) < 6.0 * band] = 0
    levels.sort()
    return levels[0], tuple(levels[1:])


def resting(heights: Floats, velocities: Floats, leg: float, over: float = OVER_LOW) -> Bools:
    """Mark the points (S, P) that may be resting: still ones, or level and low ones if none is still for long.

    On a treadmill, or in a clip with a fixed root, planted feet move horizontally, but not up or down.

    Args:
        heights: (S, P) [m].
        velocities: (S, P, 3) [m/s].
        leg: leg length [m].
        over: [leg lengths] greatest height of a resting point over the lowest; a toe that sinks into the floor at each
            step is lower than where the foot stands.
    """
    still = np.linalg.norm(velocities, axis=-1) <= _STILL * leg
    if still.mean() >= 0.25:
        return np.asarray(still)
    low, high = np.quantile(heights, [0.03, 0.97], axis=0)
    level = (np.abs(velocities[..., 1]) <= _LEVEL * leg) & (heights <= low + 0.25 * (high - low) + over * leg)
    return np.asarray(level if level.any() else heights <= low)
