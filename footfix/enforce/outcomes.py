"""The outcome of each footplant, read from the solution."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from footfix.enforce.footing import Footing
from footfix.enforce.footplant import FEWEST, Footplant, Outcome
from footfix.enforce.leg import ANKLE, HEEL, TOE, LegTracks
from footfix.enforce.leg_state import places_of
from footfix.enforce.plant_faults import core
from footfix.motion.clip import Bools, Floats
from footfix.motion.contacts import runs
from footfix.rig.rig import Rig

_STANDS = 0.05  # [leg lengths/s] a point that slips less than this stands
_PINNED = 0.0055  # [leg lengths] a plant that strays no farther, except at its ends, is pinned
_MOST = 0.5  # [share] a plant that stands in a smaller share of its frames is released
_NOTICED = 30.0  # [degrees/s] a smaller knee speed is not given as a reason
_EASE = 0.1  # [s] in which a held foot would return to its captured path


@dataclass(frozen=True, eq=False)
class CorrectedLeg:
    """Where a corrected leg is, (3, F) [m] each."""

    hip: Floats
    ankle: Floats
    heel: Floats
    toe: Floats

    @classmethod
    def of_state(cls, leg: LegTracks, root: Floats, x: Floats) -> CorrectedLeg:
        """Place the leg in a state: shift of the root (3, F) [m] and its own unknowns (8, F)."""
        places = places_of(leg, root, x)
        return cls(leg.hip + root, places[ANKLE], places[HEEL], places[TOE])

    @classmethod
    def of_tracks(cls, leg: LegTracks) -> CorrectedLeg:
        """Place the leg as captured."""
        return cls(leg.hip, leg.ankle, leg.place(HEEL), leg.place(TOE))

    def point(self, plant: Footplant) -> Floats:
        """Compute the point that a plant holds, (3, F) [m]."""
        return self.heel if plant.part == "heel" else self.toe


def outcomes(
    footing: Footing, legs: Sequence[LegTracks], after: Sequence[CorrectedLeg], rig: Rig, frame_time: float
) -> tuple[Footplant, ...]:
    """Determine the outcome of each plant: kept, pinned, partly, or released.

    Args:
        footing: the plants as asked for, and what they stand on.
        legs: as captured.
        after: the legs as corrected.
        rig: size and floor.
        frame_time: [s].
    """
    found, ground = [], footing.ground
    for plant in footing.plants:
        track = after[plant.leg].point(plant)[:, plant.frames].T - ground[plant.frames]
        slip = np.hypot(*np.diff(track, axis=0)[:, [0, 2]].T)
        still = slip <= _STANDS * rig.leg_length * frame_time
        held = tuple((plant.start + a, plant.start + b + 1) for a, b in runs(still))
        on = np.append(still, still[-1:]) if len(still) else np.ones(1, dtype=np.bool_)
        place = np.median(track[on] if np.any(on) else track, axis=0)
        strays = np.hypot(*(track - place)[:, [0, 2]].T)
        far = float(strays.max())
        x, y, z = (place + ground[(plant.start + plant.end) // 2]).tolist()
        y -= footing.floors.rest[plant.effector] - rig.floor  # from the joint to its sole
        inner = core(plant, frame_time)
        within = strays[inner[0] - plant.start : inner[1] - plant.start].max()
        kept, turns = footing.keep[plant.id] and plant.asked is None, legs[plant.leg].turns
        outcome, reason = _outcome(kept, still, float(within), rig.leg_length, turns)
        if outcome in ("partly", "released") and turns:
            reason += _price(plant, legs[plant.leg], after[plant.leg], track - place, frame_time)
        found.append(replace(plant, target=(x, y, z), outcome=outcome, reason=reason, residual=far, held=held))
    return tuple(found)


def _outcome(keep: bool, still: Bools, within: float, leg_length: float, turns: bool) -> tuple[Outcome, str]:
    frames = len(still) + 1
    if within <= _PINNED * leg_length:
        return "kept" if keep else "pinned", ""
    if keep and frames < FEWEST:
        return "kept", f"{frames} {'frame is' if frames == 1 else 'frames are'} too few to hold"
    if not (keep or turns):
        return "released", "the file has no rotation channels for a joint of this leg"
    share = float(still.mean()) if len(still) else 0.0
    # No millimetres here: the report gives those of the measures, of the visible points, beside the reason.
    held = np.count_nonzero(still)
    if keep or share >= _MOST:
        return "kept" if keep else "partly", f"at rest in {held} of {len(still)} frames"
    return "released", f"at rest in {f'only {held}' if held else 'none'} of {len(still)} frames"


def _price(plant: Footplant, leg: LegTracks, after: CorrectedLeg, strays: Floats, frame_time: float) -> str:
    """Say what holding a plant throughout would demand of its knee; `strays` (n, 3) [m] from its place."""
    ease = max(1, round(_EASE / frame_time)) + 1  # frames; in the last one the foot is back on its path
    first, last = max(plant.start - ease, 0), min(plant.end + ease, after.ankle.shape[1])
    lacks = np.zeros((last - first, 3))  # [m] what would bring the foot to its place
    lacks[plant.start - first : plant.end - first] = -strays * [1.0, 0.0, 1.0]
    fade = np.linspace(1.0, 0.0, ease + 1)[1:, None]
    before, behind = plant.start - first, last - plant.end
    lacks[:before] = -strays[:1] * [1.0, 0.0, 1.0] * fade[:before][::-1]
    lacks[len(lacks) - behind :] = -strays[-1:] * [1.0, 0.0, 1.0] * fade[:behind]
    line = (after.ankle - after.hip)[:, first:last].T  # (n, 3) [m]
    bones = (np.linalg.norm(each[:, first:last], axis=0) for each in (leg.thigh, leg.shank))
    thigh, shank = bones
    now, then = (_flexion(np.linalg.norm(each, axis=1), thigh, shank) for each in (line, line + lacks))
    if len(now) < 2:
        return ""
    faster = np.abs(np.diff(then)) - np.abs(np.diff(now))
    at = int(np.argmax(faster))
    speed = float(np.degrees(faster[at])) / frame_time
    beyond = float(np.max(np.linalg.norm(line + lacks, axis=1) - thigh - shank))
    if beyond > 0.0:
        return f"; to hold it throughout, the leg would be {1000.0 * beyond:.0f} mm too short"
    if speed < _NOTICED:
        return ""
    side = leg.leg.name.replace("_", " ")
    return f"; to hold it throughout, the {side} knee would turn {speed:.0f} degrees/s faster at frame {first + at + 1}"


def _flexion(distance: Floats, thigh: Floats, shank: Floats) -> Floats:
    """Compute the flexion (n,) [rad] of a knee for the distance from hip to ankle (n,) [m], by the law of cosines."""
    cosine = (distance**2 - thigh**2 - shank**2) / np.maximum(2.0 * thigh * shank, 1e-12)
    return np.arccos(np.clip(cosine, -1.0, 1.0))
