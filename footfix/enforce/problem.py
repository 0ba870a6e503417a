"""The optimisation problem of a clip: the legs as captured, the pins of their points, and the costs of unknowns.

The terms are in `terms`, their sum in `objective`, its minimisation in `solve`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from footfix.enforce.costs import CUT, CUT_ROOT, FAR_TURN, FIRM_TURN, GROWN, NOISY, RATE, TOES, UNNOTICED, CostParams
from footfix.enforce.leg import LEG, ROOT, B, LegTracks
from footfix.enforce.pins import Pins
from footfix.enforce.vertices import Vertices
from footfix.motion.clip import Bools, Floats, Ints, frozen


@dataclass(frozen=True, eq=False)
class Problem:
    """One clip's objective.

    Args:
        legs: as captured, F frames.
        pins: for each leg those of its points.
        frame_time: [s].
        leg_length: [m].
        costs: the standard deviations.
        noise: (U,) [m, rad] standard deviation of the capture's frame-to-frame noise,
        white: (U,) and whether the fastest changes are all noise.
        root_moves: whether the root may move.
        fault: (F,) [m] how far plants nearby slide, or are from their floor.
        cut: whether a T-pose was cut off before the first frame, and after the last.
        onward: whether the motion goes on after the last frame, in a stream.
        skins: vertices of the foot of some legs, by the leg's index.
    """

    legs: tuple[LegTracks, ...]
    pins: tuple[tuple[Pins, ...], ...]
    frame_time: float
    leg_length: float
    costs: CostParams
    noise: Floats
    white: Bools
    fault: Floats
    root_moves: bool = True
    cut: tuple[bool, bool] = (False, False)
    onward: bool = False
    skins: Mapping[int, Vertices] = field(default_factory=dict)

    @property
    def frames(self) -> int:
        return len(self.legs[0].flexion)

    @property
    def unknowns(self) -> int:
        return ROOT + LEG * len(self.legs)

    def columns(self, leg: int) -> slice:
        """Get the slice of a leg's eight unknowns in a state."""
        return slice(ROOT + LEG * leg, ROOT + LEG * (leg + 1))

    def unknown_legs(self, leg: int | None) -> Sequence[int]:
        """List the legs whose unknowns are solved for: one alone, or, without one, all."""
        return range(len(self.legs)) if leg is None else (leg,)

    def rows(self, leg: int | None) -> Ints:
        """Get the places of a leg's unknowns in a state, one after the other; without a leg those of all unknowns."""
        return np.arange(self.unknowns)[slice(None) if leg is None else self.columns(leg)]

    def with_pins(self, pins: Sequence[tuple[Pins, ...]]) -> Problem:
        """Replace the pins, and keep what was computed without them."""
        found = replace(self, pins=tuple(pins))
        found.__dict__.update(near_bands=self.near_bands, farthest=self.farthest, beyond=self.beyond)
        return found

    def free(self) -> Bools:
        """Mark the unknowns that may differ from zero, (U,)."""
        free = np.ones(self.unknowns, dtype=np.bool_)
        free[:ROOT] = self.root_moves
        for k, leg in enumerate(self.legs):
            own = free[self.columns(k)]
            own[:] = leg.turns
            own[B] = leg.bends and leg.turns
        return free

    @cached_property
    def farthest(self) -> tuple[Floats, Floats, Floats, Floats]:
        """Compute the bounds on the turns of line, knee, ankle and toes, each (F,) [rad]; they grow with the fault.

        They grow in proportion. Toes reach their own bound at a fault twice as large as viewers notice: while the heel
        rises, toe joint and tip can both be held only if the toes bend.
        """
        c, seen = self.costs, self._seen
        line, ankle = (np.minimum(c.unnoticed_turn * seen, most) for most in (c.line_farthest, c.ankle_farthest))
        least = min(TOES * c.unnoticed_turn, c.toes_farthest)
        toes = np.interp(seen, [1.0, UNNOTICED, 2.0], [least, min(UNNOTICED * least, c.toes_farthest), c.toes_farthest])
        return np.radians(line), np.radians(ankle), np.radians(ankle), np.radians(toes)

    @cached_property
    def beyond(self) -> Floats:
        """Compute the standard deviation of turns beyond `farthest`, (F,) [rad]: less where no fault is noticed.

        Static friction is strong enough to turn a joint by several degrees beyond a soft bound. To mend what nobody
        sees that is too much: there a foot slides rather than that.
        """
        return np.radians(np.interp(self._seen, [1.0, UNNOTICED], [FIRM_TURN, FAR_TURN]))

    @property
    def _seen(self) -> Floats:
        """Compute how many times as large as noticed ones the faults are, (F,), at least 1."""
        return np.maximum(self.fault / (self.costs.noticed * self.leg_length), 1.0)

    def near(self) -> tuple[Floats, Floats]:
        """Compute the standard deviations of NEAR: s0 [m, rad] and s2 [m/s^2, rad/s^2], both (U,)."""
        c, size = self.costs, self.leg_length
        deg = np.pi / 180.0
        s0 = np.concatenate([
            size * np.array([c.root, c.root_height, c.root]),
            *[deg * np.repeat([c.line, c.knee, c.foot, c.toes], [3, 1, 3, 1])] * len(self.legs),
        ])  # fmt: skip
        accelerations = [c.line_acceleration, c.knee_acceleration, c.foot_acceleration, c.toes_acceleration]
        s2 = np.concatenate([
            np.full(3, size * c.root_acceleration),
            *[deg * np.repeat(accelerations, [3, 1, 3, 1])] * len(self.legs),
        ])  # fmt: skip
        # motions of similar figures: accelerations of joints go with 1 / size, those of places are the same
        s2 *= GROWN / size
        # accelerations of the capture's noise need not be kept: second differences have 1 + 4 + 1 times its variance
        noise = np.sqrt(6.0) * self.noise / self.frame_time**2
        return s0, np.hypot(s2, np.where(self.white, noise, np.minimum(noise, NOISY * s2)))

    @cached_property
    def near_bands(self) -> Floats:
        """Compute the matrix of NEAR and CUT, (3, U, F): its main, first lower and second lower diagonal, in frames."""
        s0, s2 = self.near()
        dt, F = self.frame_time, self.frames
        calm = RATE * dt / s2**2 / dt**4
        bands = np.zeros((3, len(s0), F))
        bands[0] += (RATE * dt / s0**2)[:, None]
        if F > 2:  # D2' D2
            for offset, weight in ((0, 1.0), (1, 4.0), (2, 1.0)):
                bands[0, :, offset : F - 2 + offset] += weight * calm[:, None]
            for offset in (0, 1):
                bands[1, :, offset : F - 2 + offset] -= 2.0 * calm[:, None]
            bands[2, :, : F - 2] += calm[:, None]
        sigma = np.full(len(s0), np.radians(CUT)) * 120.0 * dt
        sigma[:ROOT] = CUT_ROOT * self.leg_length * 120.0 * dt
        for end, frame in zip(self.cut, (0, F - 1), strict=True):
            if end:
                bands[0, :, frame] += 1.0 / sigma**2
        if self.onward and F > 2:
            _onward(bands, s0, s2, dt)
        return frozen(bands)


def _onward(bands: Floats, s0: Floats, s2: Floats, dt: float) -> None:
    """Add the cost-to-go of returning to the capture after the last frame (state x, speed v), with no more plants.

    The least integral of r ((x / s0)^2 + (x'' / s2)^2) from then on is r (s2/s0 p x^2 + 2 x v / (s0 s2) + p v^2),
    p = sqrt(2 / (s0 s2)) / s2. Source: the linear-quadratic regulator of a double integrator (Riccati's equation).
    """
    both, fast = 1.0 / (s0 * s2) / dt, np.sqrt(2.0 / (s0 * s2)) / s2 / dt**2
    bands[0, :, -1] += RATE * (s2 / s0 * fast * dt**2 + 2.0 * both + fast)
    bands[0, :, -2] += RATE * fast
    bands[1, :, -2] -= RATE * (both + fast)
