"""FLOOR for the mesh of a foot: where a skin is given, no vertex of it goes below the floor.

A few vertices of each foot, chosen once, are points of their leg whose only cost is depth below the floor. With y the
height of a vertex, a function of its leg's unknowns (d, q, k, w, b) (see `leg`):

    1/2 sum_t r dt (max(0, lowest - y) / s)^2,   y = y(ankle) + (exp(w) (base + R(hinge, b) toes))_y
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from footfix.enforce.assembly import System
from footfix.enforce.costs import RATE
from footfix.enforce.leg import ANKLE, LEG, B, K, LegTracks, Q, W
from footfix.enforce.leg_state import LegState, cross, exponential, rotated
from footfix.motion import rotation
from footfix.motion.clip import Floats, Ints, Skeleton
from footfix.motion.kinematics import Pose
from footfix.rig.foot_mesh import FootMesh

_NEAR = 0.08  # [leg lengths] over the floor, up to which the lowest vertices of a foot are searched
_LACKS = 0.0006  # [leg lengths] the lowest of all vertices may be this much below the chosen ones
_MOST = 20  # most vertices chosen for a foot
_LOOKED_AT = 300  # most frames sampled for the choice
_TILTS = (-0.45, -0.2, 0.0, 0.2, 0.45)  # [rad] by which a correction may turn a foot about two level axes
_SIGMA = 0.001  # [leg lengths] standard deviation of depth


@dataclass(frozen=True, eq=False)
class Vertices:
    """Some vertices of a foot as captured, in the world.

    Args:
        base: (N, 3, F) [m] from the ankle: the part that does not bend with the toes.
        toes: (N, 3, F) [m] the part that bends with the toes, from the toe joint; zero where toes can't bend.
        lowest: (N, F) [m] least allowed height of each.
    """

    base: Floats
    toes: Floats | None
    lowest: Floats

    def frames(self, which: slice | Ints) -> Vertices:
        """Take some frames only."""
        toes = None if self.toes is None else self.toes[..., which]
        return Vertices(self.base[..., which], toes, self.lowest[:, which])


def vertices_of(
    mesh: FootMesh, leg: LegTracks, pose: Pose, lift: float, lowest: Floats, skeleton: Skeleton
) -> Vertices:
    """Choose vertices of a foot, and lay them out for the optimisation.

    Args:
        mesh: of the foot.
        leg: as captured, raised by `lift`.
        pose: of the clip as captured.
        lift: [m] by which the figure is raised.
        lowest: (F,) [m] least allowed height of a vertex.
        skeleton: of the clip.
    """
    which = _chosen(mesh, leg, pose, lift, lowest)
    ankle = leg.ankle - np.array([[0.0], [lift], [0.0]])
    whole = mesh.tracks(pose, which).transpose(1, 2, 0) - ankle  # (N, 3, F)
    toes = None
    if leg.bends and leg.leg.toe is not None:
        toes = np.zeros_like(whole)
        for joint in mesh.carriers:
            if leg.leg.toe in skeleton.ancestors(joint):
                toes += _share(mesh, which, joint, pose, pose.position(leg.leg.toe))
    base = whole if toes is None else whole - toes
    return Vertices(base, toes, np.broadcast_to(lowest, (len(which), len(lowest))))


def _share(mesh: FootMesh, which: Ints, joint: int, pose: Pose, origin: Floats) -> Floats:
    """Compute a joint's weighted share of vertices, seen from an origin (F, 3): (N, 3, F) [m]."""
    own = mesh.joints[which] == joint
    weights = np.where(own, mesh.weights[which], 0.0)  # (N, k)
    local = np.einsum("vk,vkc->vc", weights, mesh.offsets[which])
    turned = np.einsum("fab,vb->vaf", rotation.to_matrix(pose.rotation(joint)), local)
    return np.asarray(turned + weights.sum(axis=1)[:, None, None] * (pose.position(joint) - origin).T)


def _chosen(mesh: FootMesh, leg: LegTracks, pose: Pose, lift: float, lowest: Floats) -> Ints:
    """Choose vertices (N,) so that one of them is nearly the lowest of the foot, however it turns near the floor.

    They are chosen one by one: always the lowest vertex of the frame in which the chosen ones miss it most.
    """
    level = mesh.lowest(pose) + lift
    near = np.flatnonzero(level < lowest + _NEAR * _size(leg))
    some = near[np.unique(np.linspace(0, len(near) - 1, _LOOKED_AT).astype(np.intp))] if len(near) else near[:0]
    if not len(some):
        return some
    seen = mesh.tracks(pose.frames(some), np.arange(len(mesh))).transpose(2, 1, 0)  # (3, V, f)
    arms = seen - (leg.ankle[:, some] - np.array([[0.0], [lift], [0.0]]))[:, None]
    turns = [(a, b) for a in _TILTS for b in _TILTS]
    heights = np.concatenate([arms[1] + a * arms[0] + b * arms[2] for a, b in turns], axis=1)  # (V, 25 f)
    least = heights.min(axis=0)
    found, best = list[int](), np.full(heights.shape[1], np.inf)
    while len(found) < _MOST:
        worst = int(np.argmax(best - least)) if found else int(np.argmin(least))
        if found and best[worst] - least[worst] <= _LACKS * _size(leg):
            break
        found.append(int(np.argmin(heights[:, worst])))
        best = np.minimum(best, heights[found[-1]])
    return np.array(sorted(found), np.intp)


def _size(leg: LegTracks) -> float:
    """Compute the length of the leg [m]."""
    return float(np.median(np.linalg.norm(leg.thigh, axis=0) + np.linalg.norm(leg.shank, axis=0)))


def floor_cost(vertices: Vertices, leg: LegTracks, ankle: Floats, x: Floats, weight: float) -> float:
    """Compute the cost of vertices below the floor.

    Args:
        vertices: of the leg.
        leg: as captured.
        ankle: (3, F) [m] where it is in the state.
        x: (8, F) [rad] the leg's unknowns.
        weight: [1/m^2] r dt / s^2 of the objective, from `floor_weight`.
    """
    heights = _arms(vertices, leg, x)[0][1] + ankle[1]
    return 0.5 * weight * float(np.sum(np.maximum(vertices.lowest - heights, 0.0) ** 2))


def floor_weight(frame_time: float, leg_length: float) -> float:
    """Compute the cost of a squared depth in a frame [1/m^2]."""
    return RATE * frame_time / (_SIGMA * leg_length) ** 2


def add_floor(
    vertices: Vertices, leg: LegTracks, at: LegState, x: Floats, weight: float, out: System, base: int
) -> float:
    """Add the derivatives of FLOOR of a leg's vertices to a system; return what they cost.

    Args:
        vertices: of the leg.
        leg: as captured.
        at: the leg in the state.
        x: (8, F) [rad] its unknowns.
        weight: [1/m^2] from `floor_weight`.
        out: the system; the root's unknowns, if they are there, are its first.
        base: the row at which the leg's begin in it.
    """
    arms, toes = _arms(vertices, leg, x)
    low = np.maximum(vertices.lowest - arms[1] - at.places[ANKLE][1], 0.0)  # (N, F)
    foot = exponential(x[W])
    for v in np.flatnonzero(low.any(axis=1)).tolist():
        frames = np.flatnonzero(low[v])
        rise = np.zeros((len(out.rows), len(frames)))  # dy by each unknown
        if base:
            rise[1] = 1.0
        arm, own = arms[:, v, frames], rise[base : base + LEG]
        own[Q], own[K] = at.ankle[1, :3, frames].T, at.ankle[1, 3, frames]
        turn = at.turn[..., frames]
        own[W] = turn[2] * arm[0] - turn[0] * arm[2]  # (turn dw) x arm, along y
        if toes is not None:
            own[B] = cross(rotated(foot[..., frames], leg.toe_hinge[:, frames]), toes[:, v, frames])[1]
        out.gradient[:, frames] -= weight * low[v, frames] * rise
        out.main[frames] += weight * np.einsum("if,jf->fij", rise, rise)
    return 0.5 * weight * float(np.sum(low**2))


def _arms(vertices: Vertices, leg: LegTracks, x: Floats) -> tuple[Floats, Floats | None]:
    """Compute vertices from the ankle in a state, (3, N, F) [m], and the part that bends with the toes."""
    foot = exponential(x[W])[:, :, None]
    base = vertices.base.swapaxes(0, 1)
    if vertices.toes is None:
        return rotated(foot, base), None
    toes = rotated(exponential(x[B] * leg.toe_hinge)[:, :, None], vertices.toes.swapaxes(0, 1))
    return rotated(foot, base + toes), rotated(foot, toes)


def depths(vertices: Vertices, leg: LegTracks) -> Floats:
    """Measure how much deeper than allowed the deepest vertex is, as captured, (F,) [m]; 0 where none is."""
    whole = vertices.base if vertices.toes is None else vertices.base + vertices.toes
    low = vertices.lowest - whole[:, 1] - leg.ankle[1]
    return np.asarray(np.maximum(low.max(axis=0, initial=0.0), 0.0))
