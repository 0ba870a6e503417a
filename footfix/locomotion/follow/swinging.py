"""Legs that swing from one stance to the next where walks are mixed."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from footfix.enforce.papers.leg import CapturedLeg, LegTurns, flexion_for, two_bones
from footfix.locomotion.follow.blend import ease
from footfix.locomotion.follow.body_placement import Goal
from footfix.motion import rotation
from footfix.motion.clip import Floats
from footfix.motion.vectors import norm, unit

_ROUNDED = (0.15, 0.5, 1.0)  # [rad] of a knee's flexion, below which it is taken to be less than it is told by
_MORE = 0.15  # [rad] by which a knee is bent more for its leg's plane to be steadied
_CLEAR = 0.01  # [m] over which a foot that gets too low is lifted
_ENDS = 0.25  # of a swing, in which that comes and goes
_OUT = 0.3  # [rad] by which slopes at the ends of a swing carry a leg out, at most
_BESIDE = 3  # frames before a swing, and after it


@dataclass(frozen=True, eq=False)
class _Swing:
    """What becomes of a leg, or several ways (W, ...) of that.

    Args:
        bent: (..., n) [rad] its knee's flexion.
        line: (..., n, 3) [m] from hip to ankle; only its direction counts.
        foot: (..., n, 4) the ankle's frame.
    """

    bent: Floats
    line: Floats
    foot: Floats


def swung(leg: CapturedLeg, ankle: Floats, goal: Goal, astray: Floats) -> tuple[LegTurns, Floats]:
    """Solve a leg for where its foot stands; where it swings, as it is mixed, led over from one stance to the next.

    Led over are the knee's flexion, the direction from hip to ankle, and the turn of the foot. Flexion may be led over
    by itself, or the more it is rounded off, the more like the distance from hip to ankle. A knee that is straightened
    with a jolt, as many are before a foot comes down, hardly moves a foot while the leg is nearly straight. Led over by
    itself to a bent one, it would move the foot; where the leg gets nearly straight, by its length, it would be torn.
    Directions may also be those that the foot asks for. Which of all that jolts a leg least is seen for each swing.

    Args:
        leg: as it is mixed.
        ankle: (F, 3) [m] where it is to be.
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
    """The way to lead a swing over that jolts a leg least, in frames about it."""
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
    """A swing whose directions are led over from how its leg is mixed."""
    aside = rotation.to_rotation_vector(rotation.between(leg.ankle - leg.hip, asked.line))
    turned = rotation.to_rotation_vector(rotation.continuous(rotation.multiply(asked.foot, rotation.inverse(leg.turn))))
    line, foot = asked.line.copy(), asked.foot.copy()
    line[some] = rotation.rotate(rotation.from_rotation_vector(_led_over(aside, some)), (leg.ankle - leg.hip)[some])
    foot[some] = rotation.multiply(rotation.from_rotation_vector(_led_over(turned, some)), leg.turn[some])
    return _Swing(asked.bent, line, foot)


def _part(leg: CapturedLeg, some: slice) -> CapturedLeg:
    """A leg in some frames."""
    tracks = {name: getattr(leg, name)[some] for name in _TRACKS}
    return replace(leg, **tracks)


_TRACKS = ("hip", "knee", "ankle", "turn", "heel", "toe", "knee_axis", "flexion")


def steadying(leg: CapturedLeg, bent: Floats, astray: Floats) -> Floats:
    """Tell (F,) [rad] by which a leg that is bent (F,) [rad] now turns about its own line, see `legs.astray`."""
    return np.asarray(astray * ease((np.abs(bent) - np.abs(leg.flexion)) / _MORE))


def _turns(leg: CapturedLeg, led: _Swing, astray: Floats) -> LegTurns:
    swivel = steadying(leg, led.bent, astray)
    bend = rotation.from_axis_angle(leg.knee_axis, led.bent - leg.flexion)
    swing = rotation.between(leg.knee - leg.hip + rotation.rotate(bend, leg.ankle - leg.knee), led.line)
    return LegTurns(rotation.multiply(rotation.from_axis_angle(unit(-led.line), swivel), swing), bend)


def _jolts(leg: CapturedLeg, led: _Swing, astray: Floats, usual: Floats) -> Floats:
    """(W,) the most by which knee, ankle or toe accelerate, of what is usual (n, 3) for each."""
    knee = leg.hip + rotation.rotate(_turns(leg, led, astray).swing, leg.knee - leg.hip)
    ankle = leg.hip + _far(leg, led.bent)[..., None] * unit(led.line)
    toe = ankle + rotation.rotate(led.foot, leg.in_foot(leg.toe))
    speedy = [norm(np.diff(track, n=2, axis=-2)) for track in (knee, ankle, toe)]
    return np.asarray(np.max([each / usual[1:-1, k] for k, each in enumerate(speedy)], axis=(0, -1)))


def _far(leg: CapturedLeg, bent: Floats) -> Floats:
    """(..., n) [m] from hip to ankle, a knee being bent so far (..., n) [rad]."""
    bend = rotation.from_axis_angle(leg.knee_axis, bent - leg.flexion)
    return norm(leg.knee - leg.hip + rotation.rotate(bend, leg.ankle - leg.knee))


def _low(leg: CapturedLeg, ankle: Floats, foot: Floats) -> Floats:
    """(..., n) [m] how high the lower end of a foot is."""
    heel, toe = (rotation.rotate(foot, leg.in_foot(end))[..., 1] for end in (leg.heel, leg.toe))
    return np.asarray(ankle[..., 1] + np.minimum(heel, toe))


def _lifted(leg: CapturedLeg, led: _Swing, some: slice, lowest: float) -> _Swing:
    """Lift a swinging foot so that it gets no lower than `lowest` [m], than it ever does by itself.

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
    """(W, F) [rad] ways to lead a knee's flexion over while its foot swings.

    It is told by itself, or by how straight it is, the more rounded off the more like its leg's length. A knee that is
    overstretched by some degrees in one frame and bent in the next, its leg being straight in both, is told by the
    latter.

    Args:
        mixed: (F,) [rad] as the leg is mixed,
        asked: (F,) [rad] and as its stances ask.
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
    """(n, D) a curve over frames of a track (F, D) that leads on at both ends with the slopes there.

    It is the cubic that does. Where its slopes are so steep that they would carry it far out, each of them comes to
    rest earlier: a leg that is nearly straight at the one end is bent quickly there, and no farther for that.
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
    """(n, D) how far a slope (D,) [rad a frame] carries (n,) frames away, at rest after so many of them or fewer."""
    most = _OUT / (4.0 / 27.0 * max(float(np.linalg.norm(slope)), 1e-12))  # u (1 - u)^2 gets to 4 / 27
    until = min(float(frames), most)
    u = np.clip(away / until, 0.0, 1.0)[:, None]
    return np.asarray(until * u * (1.0 - u) ** 2 * slope)
