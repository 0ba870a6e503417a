"""Legs that swing from one stance to the next while walks are blended."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from footfix.enforce.two_bone_ik import CapturedLeg, LegTurns, flexion_for, two_bones
from footfix.locomotion.follow.blend_weight import ease
from footfix.locomotion.follow.body_placement import Goal
from footfix.motion import rotation
from footfix.motion.clip import Floats
from footfix.motion.vectors import norm, unit

_ROUNDED = (0.15, 0.5, 1.0)  # [rad] flexions below which a knee's flexion is rounded off before interpolation
_MORE = 0.15  # [rad] increase of a knee's flexion from which its leg's plane is fully stabilised
_CLEAR = 0.01  # [m] clearance over which a foot that swings too low is lifted
_ENDS = 0.25  # share of a swing over which the lift fades in and out
_OUT = 0.3  # [rad] greatest overshoot from slopes at the ends of a swing
_BESIDE = 3  # frames before and after a swing that are compared, too


@dataclass(frozen=True, eq=False)
class _Swing:
    """A leg's pose in a swing, or several candidates (W, ...) for it.

    Args:
        bent: (..., n) [rad] its knee's flexion.
        line: (..., n, 3) [m] from hip to ankle; only its direction counts.
        foot: (..., n, 4) the ankle's frame.
    """

    bent: Floats
    line: Floats
    foot: Floats


def swung(leg: CapturedLeg, ankle: Floats, goal: Goal, astray: Floats) -> tuple[LegTurns, Floats]:
    """Solve a leg for its planted foot; in swings, add to the blended pose an offset from one stance to the next.

    Interpolated are the knee's flexion, the direction from hip to ankle, and the turn of the foot. Flexion is
    interpolated as it is, or rounded off near zero, which comes closer to interpolating the distance from hip to ankle.
    Many knees straighten abruptly before a foot comes down, which hardly moves the foot while the leg is nearly
    straight. Interpolated as it is, towards a bent knee, this would move the foot; by leg length it would make the knee
    jerk near straight. Directions may also be those that the foot requires. For each swing the candidate with the least
    acceleration is used.

    Args:
        leg: as blended.
        ankle: (F, 3) [m] goal of the ankle.
        goal: its foot.
        astray: (F,) [rad] see `legs.astray`.

    Returns:
        What turns the leg, and (F, 4) the ankle's frame.
    """
    asked = _Swing(flexion_for(leg, ankle), ankle - leg.hip, goal.turn)
    if not goal.swings:
        return two_bones(leg, ankle, steadying(leg, asked.bent, astray)), goal.turn
    bent, line, foot = asked.bent.copy(), asked.line.copy(), asked.foot.copy()
    lowest = float(np.min(_low(leg, ankle, goal.turn)))
    for some in goal.swings:
        around = slice(max(some.start - _BESIDE, 0), min(some.stop + _BESIDE, len(leg)))
        mine, own = _part(leg, around), slice(some.start - around.start, some.stop - around.start)
        there = _Swing(asked.bent[around], asked.line[around], asked.foot[around])
        led = _least(mine, there, own, lowest, astray[around], goal.usual[around])
        bent[around], line[around], foot[around] = led.bent, led.line, led.foot
    return _turns(leg, _Swing(bent, line, foot), astray), foot


def _least(
    leg: CapturedLeg, asked: _Swing, some: slice, lowest: float, astray: Floats, usual: Floats
) -> _Swing:  # fmt: skip
    """Choose the interpolation of a swing in which the leg accelerates least."""
    led = _led(leg, asked, some)

    def best_of(ways: _Swing) -> tuple[int, _Swing]:
        lifted = _lifted(leg, ways, some, lowest)
        best = int(np.argmin(_jolts(leg, lifted, astray, usual)))
        return best, _Swing(lifted.bent[best], lifted.line[best], lifted.foot[best])

    bent = _led_flexions(leg.flexion, asked.bent, some)
    best, _ = best_of(_Swing(bent, np.stack([led.line] * len(bent)), np.stack([led.foot] * len(bent))))
    line, foot = np.stack([led.line, led.line, asked.line]), np.stack([led.foot, asked.foot, led.foot])
    return best_of(_Swing(np.stack([bent[best]] * 3), line, foot))[1]


def _led(leg: CapturedLeg, asked: _Swing, some: slice) -> _Swing:
    """Interpolate the directions of a swing's offset from the blended leg."""
    aside = rotation.to_rotation_vector(rotation.between(leg.ankle - leg.hip, asked.line))
    turned = rotation.to_rotation_vector(rotation.continuous(rotation.multiply(asked.foot, rotation.inverse(leg.turn))))
    line, foot = asked.line.copy(), asked.foot.copy()
    line[some] = rotation.rotate(rotation.from_rotation_vector(_led_over(aside, some)), (leg.ankle - leg.hip)[some])
    foot[some] = rotation.multiply(rotation.from_rotation_vector(_led_over(turned, some)), leg.turn[some])
    return _Swing(asked.bent, line, foot)


def _part(leg: CapturedLeg, some: slice) -> CapturedLeg:
    """Take some frames of a leg."""
    tracks = {name: getattr(leg, name)[some] for name in _TRACKS}
    return replace(leg, **tracks)


_TRACKS = ("hip", "knee", "ankle", "turn", "heel", "toe", "knee_axis", "flexion")


def steadying(leg: CapturedLeg, bent: Floats, astray: Floats) -> Floats:
    """Compute the turn (F,) [rad] of a leg, now bent by (F,) [rad], about its own line; see `legs.astray`."""
    return np.asarray(astray * ease((np.abs(bent) - np.abs(leg.flexion)) / _MORE))


def _turns(leg: CapturedLeg, led: _Swing, astray: Floats) -> LegTurns:
    swivel = steadying(leg, led.bent, astray)
    bend = rotation.from_axis_angle(leg.knee_axis, led.bent - leg.flexion)
    swing = rotation.between(leg.knee - leg.hip + rotation.rotate(bend, leg.ankle - leg.knee), led.line)
    return LegTurns(rotation.multiply(rotation.from_axis_angle(unit(-led.line), swivel), swing), bend)


def _jolts(leg: CapturedLeg, led: _Swing, astray: Floats, usual: Floats) -> Floats:
    """Compute the largest acceleration (W,) of knee, ankle or toe, relative to usual ones (n, 3)."""
    knee = leg.hip + rotation.rotate(_turns(leg, led, astray).swing, leg.knee - leg.hip)
    ankle = leg.hip + _far(leg, led.bent)[..., None] * unit(led.line)
    toe = ankle + rotation.rotate(led.foot, leg.in_foot(leg.toe))
    speedy = [norm(np.diff(track, n=2, axis=-2)) for track in (knee, ankle, toe)]
    return np.asarray(np.max([each / usual[1:-1, k] for k, each in enumerate(speedy)], axis=(0, -1)))


def _far(leg: CapturedLeg, bent: Floats) -> Floats:
    """Compute the distance from hip to ankle (..., n) [m] for a flexion of the knee (..., n) [rad]."""
    bend = rotation.from_axis_angle(leg.knee_axis, bent - leg.flexion)
    return norm(leg.knee - leg.hip + rotation.rotate(bend, leg.ankle - leg.knee))


def _low(leg: CapturedLeg, ankle: Floats, foot: Floats) -> Floats:
    """Compute the height of the lower end of a foot, (..., n) [m]."""
    heel, toe = (rotation.rotate(foot, leg.in_foot(end))[..., 1] for end in (leg.heel, leg.toe))
    return np.asarray(ankle[..., 1] + np.minimum(heel, toe))


def _lifted(leg: CapturedLeg, led: _Swing, some: slice, lowest: float) -> _Swing:
    """Lift a swinging foot that would get lower than `lowest` [m].

    Args:
        leg: as it is mixed.
        led: ways to lead it over.
        some: frames of the swing.
        lowest: [m].
    """
    ankle = leg.hip + _far(leg, led.bent)[..., None] * unit(led.line)
    lack = (lowest - _low(leg, ankle, led.foot))[:, some]
    if not np.any(lack > 0.0):
        return led
    u = np.arange(1, lack.shape[1] + 1) / (lack.shape[1] + 1)
    soft = 0.5 * (lack + np.hypot(lack, _CLEAR)) * ease(u / _ENDS) * ease((1.0 - u) / _ENDS)
    up = ankle.copy()
    up[:, some, 1] += soft * np.any(lack > 0.0, axis=1)[:, None]
    return _Swing(led.bent + flexion_for(leg, up) - flexion_for(leg, ankle), up - leg.hip, led.foot)


def _led_flexions(mixed: Floats, asked: Floats, some: slice) -> Floats:
    """Make candidates (W, F) [rad] of a knee's flexion during a swing.

    Flexion is interpolated as it is, or rounded off near zero, which comes closer to leg length. The latter suits a
    knee that is overstretched by some degrees in one frame and bent in the next, with a straight leg in both.

    Args:
        mixed: (F,) [rad] of the blended leg,
        asked: (F,) [rad] and as its stances require.
        some: frames of the swing.
    """
    signs = np.sign(mixed[some])
    one = bool(np.all(signs == signs[0]))
    out = np.stack([asked] * (len(_ROUNDED) + one))
    for way, rounded in zip(out, _ROUNDED, strict=False):
        bent = np.hypot(mixed, rounded)
        led = bent[some] + _led_over((np.hypot(asked, rounded) - bent)[:, None], some)[:, 0]
        way[some] = np.sqrt(np.maximum(led**2 - rounded**2, 0.0)) * (signs[0] if one else 1.0)
    if one:
        out[-1, some] = mixed[some] + _led_over((asked - mixed)[:, None], some)[:, 0]
    return out


def _led_over(track: Floats, some: slice) -> Floats:
    """Fill frames of a track (F, D) by a curve (n, D) that continues the slopes at both ends.

    It is a cubic. Where steep slopes would make it overshoot, each slope fades out earlier, as for a leg that is nearly
    straight at one end, where flexion changes fast.
    """
    a, b = max(some.start - 1, 1), min(some.stop, len(track) - 2)
    count = np.arange(some.start, some.stop, dtype=np.float64)
    u = ((count - a) / (b - a))[:, None]
    step = track[b] - track[a]
    out = track[a] + u**2 * (3.0 - 2.0 * u) * step
    return np.asarray(
        out + _led_on(track[a] - track[a - 1], count - a, b - a) - _led_on(track[b + 1] - track[b], b - count, b - a)
    )


def _led_on(slope: Floats, away: Floats, frames: int) -> Floats:
    """Compute the offset (n, D) from a slope (D,) [rad a frame] that fades to rest within some frames."""
    most = _OUT / (4.0 / 27.0 * max(float(np.linalg.norm(slope)), 1e-12))  # u (1 - u)^2 gets to 4 / 27
    until = min(float(frames), most)
    u = np.clip(away / until, 0.0, 1.0)[:, None]
    return np.asarray(until * u * (1.0 - u) ** 2 * slope)
