"""The legs of a clip's figures, found or given."""

from __future__ import annotations

import difflib
import re
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from footfix.errors import NoLegsError, UsageError
from footfix.motion.clip import Floats, Skeleton
from footfix.rig.frame_sample import Sample
from footfix.rig.leg_candidates import Limb, Pair, limb_of, pairs
from footfix.rig.names import bare, read
from footfix.rig.params import LegParams, RigParams
from footfix.rig.toes import ball, balls

_LEAST = 1.2  # least score of a pair of legs
_LEAST_FRONT = -1.2  # least score of a pair of front legs, from shape and sides in names
_ALIKE = (0.75, 1.35)  # range of the length of front legs over hind legs; human arms have 0.63 of the legs' length
_BACK = 0.5  # [leg lengths] least horizontal distance from hind to front legs
_HIGH = 0.45  # [leg lengths] least height of hips and shoulders over the lowest joint, when the animal stands
_GROUND = 0.25  # [leg lengths] a foot within this height of the lowest joint's usual height may be planted
_FRONT = re.compile(r"front|fore(?!arm)", re.IGNORECASE)
_REAR = re.compile(r"back|hind|(?<!fo)rear", re.IGNORECASE)
_MOSTLY = 0.4  # share of the frames in which each pair must have a foot on the ground; half of them in a gallop


@dataclass(frozen=True)
class Figure:
    """The legs of one figure, before it is known which is left.

    Args:
        root: the figure's root, or the joint that carries it where one root holds several figures.
        pelvis: the joint that its (hind) legs hang from.
        limbs: the legs.
        toes: the ball joint of each, None without one.
        names: the name of each, "" until sides are known.
        sides: "left", "right" or "" of each, as given or as the joints' names say.
        origin: how they were found: "config", "names and geometry" or "geometry".
    """

    root: int
    pelvis: int
    limbs: tuple[Limb, ...]
    toes: tuple[int | None, ...]
    names: tuple[str, ...]
    sides: tuple[str, ...]
    origin: str

    @property
    def length(self) -> float:
        """Compute the mean length of the legs, hip to ankle along the bones."""
        return float(np.mean([limb.length for limb in self.limbs]))


def figures(seen: Sample, params: RigParams, *, y_up: bool) -> tuple[Figure, ...]:
    """Find the figures of a clip that have legs: one for each root that has some, or for each body below one root.

    Args:
        seen: frames of the clip.
        params: legs that are given, if any.
        y_up: whether y is known to be up; only then can front legs be told from arms.

    Raises:
        NoLegsError: no figure has legs.
        UsageError: a joint that is given is not there.
    """
    if params.legs:
        return _given(seen, params.legs)
    found = []
    for root in np.flatnonzero(seen.skeleton.parents < 0).tolist():
        candidates = pairs(seen, root)
        bodies = _bodies(seen, root, candidates)
        for body in bodies:
            own = [pair for pair in candidates if body in seen.skeleton.ancestors(pair.pelvis)]
            found.append(_figure(seen, body, own, y_up))
    if not found:
        raise NoLegsError(
            f"no legs found among {len(seen.skeleton)} joints",
            hint="if it has some, name their joints in the config under rig: legs:",
        )
    return tuple(found)


def _bodies(seen: Sample, root: int, candidates: list[Pair]) -> list[int]:
    """Find the joints that carry a figure each: the root, or several joints that travel side by side below it."""
    bodies: list[int] = []
    for pair in candidates:
        above = seen.skeleton.ancestors(pair.pelvis)
        carrier = next((joint for joint in above if seen.travel[joint] > 0.05 * pair.length), root)
        apart = all(
            carrier not in seen.skeleton.ancestors(body) and body not in seen.skeleton.ancestors(carrier)
            for body in bodies
        )
        if pair.score >= _LEAST and apart:
            bodies.append(carrier)
    return sorted(bodies) if len(bodies) > 1 else [root] if bodies else []


def _figure(seen: Sample, root: int, candidates: list[Pair], y_up: bool) -> Figure:
    hind = candidates[0]
    front = _front_legs(seen, hind, candidates[1:]) if y_up and len(seen) > 1 else None
    if front is not None and _named_front(seen.skeleton, hind) > _named_front(seen.skeleton, front):
        hind, front = front, hind
    legs: list[Limb] = []
    toes: list[int | None] = []
    ends: list[str] = []
    for pair, end in ((front, "front"), (hind, "hind" if front else "")):
        if pair is not None:
            legs += pair.limbs
            toes += balls(seen, pair.limbs)
            ends += [end, end]
    sides = tuple(_named_side(seen.skeleton, limb, toe) for limb, toe in zip(legs, toes, strict=True))
    origin = "names and geometry" if hind.named > 1.0 else "geometry"
    return Figure(root, hind.pelvis, tuple(legs), tuple(toes), tuple(ends), sides, origin)


def _front_legs(seen: Sample, hind: Pair, others: list[Pair]) -> Pair | None:
    """Find the second pair of legs of an animal that stands on four for most of the clip."""
    taken = {joint for limb in hind.limbs for joint in seen.below(limb.branch)}
    judged = [(pair.shape + _mirrored(seen.skeleton, pair), pair) for pair in others]
    for worth, pair in sorted(judged, key=lambda each: -each[0]):
        apart = all(limb.branch not in taken for limb in pair.limbs) and not any(
            limb.branch in seen.skeleton.ancestors(hind.pelvis) for limb in pair.limbs
        )
        if not apart or worth < _LEAST_FRONT:
            continue
        if (
            _ALIKE[0] <= pair.length / hind.length <= _ALIKE[1]
            and _apart(seen, hind, pair)
            and _stand(seen, hind, pair)
        ):
            return pair
    return None


def _named_front(skeleton: Skeleton, pair: Pair) -> int:
    """Count the joints of a pair of legs that are named after the front, less those named after the back."""
    names = [skeleton.names[joint] for limb in pair.limbs for joint in limb.chain]
    return sum(bool(_FRONT.search(name)) - bool(_REAR.search(name)) for name in names)


def _mirrored(skeleton: Skeleton, pair: Pair) -> float:
    """Score the sides in names: one each speaks for a pair; only one with a side (a leg and a neck) against it."""
    one, other = (_named_side(skeleton, limb, None) for limb in pair.limbs)
    return 0.0 if one == other == "" else 1.0 if one and other and one != other else -1.0


def _apart(seen: Sample, hind: Pair, front: Pair) -> bool:
    """Tell whether two pairs of legs are joined by a level back, well above the ground when the animal stands."""
    middles = [np.mean([seen.places[:, limb.hip] for limb in pair.limbs], axis=0) for pair in (hind, front)]
    level = np.linalg.norm((middles[1] - middles[0])[:, [0, 2]], axis=-1)
    high = np.minimum(*(middle[:, 1] for middle in middles)) - seen.places[..., 1].min(axis=1)
    return bool(np.median(level) > _BACK * hind.length and np.quantile(high, 0.75) > _HIGH * hind.length)


def _stand(seen: Sample, hind: Pair, front: Pair) -> bool:
    """Tell whether both pairs have a foot on the ground for much of the clip."""
    down = [np.min([_lowest(seen, limb.ankle) for limb in pair.limbs], axis=0) for pair in (hind, front)]
    near = _GROUND * hind.length
    ground = float(np.quantile(np.minimum(*down), 0.1))
    return all(bool(np.mean(each < ground + near) > _MOSTLY) for each in down)


def _lowest(seen: Sample, ankle: int) -> Floats:
    """Find the height of the lowest point from the ankle down, (S,)."""
    joints = list(seen.below(ankle))
    ends = [e for e, parent in enumerate(seen.skeleton.end_parents.tolist()) if parent in joints]
    heights = np.concatenate([seen.places[:, joints, 1], seen.ends[:, ends, 1]], axis=1)
    return np.asarray(heights.min(axis=1))


def _named_side(skeleton: Skeleton, limb: Limb, toe: int | None) -> str:
    joints = (limb.branch, *limb.chain, *(() if toe is None else (toe,)))
    votes = [read(skeleton.names[joint]).side for joint in joints]
    left, right = votes.count("left"), votes.count("right")
    return "left" if left > right else "right" if right > left else ""


def _given(seen: Sample, legs: Mapping[str, LegParams]) -> tuple[Figure, ...]:
    """Make the figures whose legs the config names."""
    by_root: dict[int, list[tuple[str, LegParams, Limb]]] = {}
    for name, leg in legs.items():
        limb = _given_limb(seen, name, leg)
        by_root.setdefault(seen.skeleton.ancestors(limb.ankle)[-1], []).append((name, leg, limb))
    figures = []
    for root, entries in by_root.items():
        limbs = tuple(limb for _, _, limb in entries)
        toes = [_given_toe(seen, name, leg, limb) for name, leg, limb in entries]
        sides = [leg.side or read(name).side or _named_side(seen.skeleton, limb, None) for name, leg, limb in entries]
        shared = set.intersection(*(set(seen.skeleton.ancestors(limb.hip)[1:] or (limb.hip,)) for limb in limbs))
        names = tuple(name for name, _, _ in entries)
        figures.append(Figure(root, max(shared), limbs, tuple(toes), names, tuple(sides), "config"))
    return tuple(figures)


def _given_toe(seen: Sample, name: str, leg: LegParams, limb: Limb) -> int | None:
    if leg.toe == "none":
        return None
    return joint(seen.skeleton, leg.toe, f"rig.legs.{name}.toe") if leg.toe else ball(seen, limb)


def _given_limb(seen: Sample, name: str, leg: LegParams) -> Limb:
    if not leg.ankle:
        raise UsageError(f"rig.legs.{name} names no ankle; at least that joint is needed")
    if leg.side not in ("", "left", "right"):
        raise UsageError(f"rig.legs.{name}.side must be left or right, not {leg.side!r}")
    places = {
        part: joint(seen.skeleton, getattr(leg, part), f"rig.legs.{name}.{part}")
        for part in ("hip", "knee", "ankle")
        if getattr(leg, part)
    }
    above = seen.skeleton.ancestors(places["ankle"])
    for part in ("hip", "knee"):
        if part in places and places[part] not in above[1:]:
            raise UsageError(f"rig.legs.{name}: {getattr(leg, part)} is not above {leg.ankle} in the skeleton")
    limb = limb_of(seen, places["ankle"], places.get("knee"), places.get("hip"))
    if limb is None:
        raise UsageError(f"rig.legs.{name}: no thigh and shin found above {leg.ankle}; name its hip and knee")
    return limb


def joint(skeleton: Skeleton, name: str, where: str) -> int:
    """Find the index of a joint by its name.

    Raises:
        UsageError: no joint has it, or several do; `where` says which setting asked for it.
    """
    for form in (str, bare, lambda text: bare(text).casefold()):
        hits = [index for index, own in enumerate(skeleton.names) if form(own) == form(name)]
        if len(hits) == 1:
            return hits[0]
        if hits:
            raise UsageError(f"{where}: {len(hits)} joints are called {name!r}")
    near = difflib.get_close_matches(name, skeleton.names, 1, 0.5)
    raise UsageError(f"{where}: no joint is called {name!r}" + (f"; did you mean {near[0]!r}?" if near else ""))
