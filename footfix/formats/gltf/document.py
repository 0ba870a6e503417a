"""One animation of a glTF file as a document: its joints, their motion, and what is doubtful about them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from footfix.errors import InputError
from footfix.formats.bvh.channels import check_unit_and_up
from footfix.formats.bvh.channels import placed as in_metres
from footfix.formats.gltf.container import Container
from footfix.formats.gltf.frame_times import Grid
from footfix.formats.gltf.mesh import skin_of
from footfix.formats.gltf.nodes import Nodes
from footfix.formats.gltf.tracks import WIDTHS, Track
from footfix.motion.clip import Bools, Clip, Floats, Ints, Skeleton, constant_track
from footfix.notes import Note
from footfix.rig.frame_sample import sample
from footfix.rig.leg_assignment import figures
from footfix.rig.params import RigParams
from footfix.rig.skin import Skin

_UNEVEN = 1e-3  # of a scale, by which its axes or frames may differ
_STILL = 5e-4  # of the figure's size: a joint that moves less in its parent's frame does not move there


@dataclass(frozen=True, eq=False)
class Document:
    """One animation of a glTF file.

    Args:
        name: of the file and the animation, for messages.
        container: the file.
        animation: index of the animation.
        nodes: of the file.
        joints: (J,) the node of each joint.
        tracks: (node, path) -> what the animation does with it.
        grid: the times of the frames.
        notes: what was assumed, and what is doubtful.
        unit_m: [m] one unit of the file.
        up: the file's upward axis.
        cut: whether tracks and grid are not those of the file, but of some of its frames.
    """

    name: str
    container: Container
    animation: int
    nodes: Nodes
    joints: tuple[int, ...]
    tracks: Mapping[tuple[int, str], Track]
    grid: Grid
    notes: tuple[Note, ...] = ()
    unit_m: float = 1.0
    up: str = "y"
    cut: bool = False

    metric = True  # glTF is in metres, y up

    @property
    def frames(self) -> int:
        """Count the frames."""
        return self.grid.frames

    @property
    def columns(self) -> int:
        """Count the animated numbers of joints."""
        return sum(track.values.shape[1] for (_, path), track in self.tracks.items() if path in WIDTHS)

    @property
    def frame_time(self) -> float:
        """Get the duration of a frame [s]."""
        return self.grid.step

    @cached_property
    def skin(self) -> Skin | None:
        """Get the character whose meshes the file shows; None where it shows none, or none that can be read."""
        try:
            return skin_of(self.container, self.nodes)
        except InputError:
            return None

    @property
    def moved(self) -> Bools:
        """Mark the joints (J,) that the animation turns or displaces, if only by a little."""
        moving = {node for (node, path), track in self.tracks.items() if path in WIDTHS and not track.constant}
        return np.array([node in moving for node in self.joints], np.bool_)

    @cached_property
    def scales(self) -> tuple[Floats, ...]:
        """Compute the uniform scale of each joint's frame in the world, (1,) or (F,)."""
        found: list[Floats] = []
        for k, parent in zip(self.joints, self._parents.tolist(), strict=True):
            track = self.tracks.get((k, "scale"))
            sizes = self.nodes.scales[k : k + 1] if track is None else track.at(self.grid.times)
            sizes = sizes[:1] if sizes.strides[0] == 0 else sizes
            own = np.cbrt(np.maximum(np.abs(np.prod(sizes, axis=1)), 1e-30))
            found.append(own if parent < 0 else own * found[parent])
        return tuple(found)

    @cached_property
    def crooked(self) -> Mapping[int, str]:
        """Find joints whose frames can't be told as rotation and place: joint -> what is wrong with its scale."""
        found = {}
        for j, k in enumerate(self.joints):
            sizes, track = self._own_scale(k), self.tracks.get((k, "scale"))
            if track is not None and float(np.ptp(track.values, axis=0).max()) > _UNEVEN * np.abs(sizes).max():
                found[j] = "is scaled by the animation"
            elif np.any(sizes <= 0.0):
                found[j] = "is mirrored, or has no size"
            elif np.ptp(sizes) > _UNEVEN * sizes.max() or self.nodes.sheared[k]:
                found[j] = "is scaled unevenly"
        return found

    @cached_property
    def unusable(self) -> tuple[Note, ...]:
        """Tell what keeps this animation from being cleaned: scale on a leg that changes, or differs along its axes."""
        broken = [self.crooked[j] for j in self.crooked]
        if not broken or not self.frames:
            return ()
        try:
            found = figures(sample(self.clip), RigParams(), y_up=False)
        except InputError:
            return ()  # no legs, which is reported when they are searched
        for limb in (limb for figure in found for limb in figure.limbs):
            for joint in self.clip.skeleton.with_ancestors([*limb.chain, limb.ankle]):
                if joint in self.crooked:
                    own = self.clip.skeleton.names[joint]
                    text = (
                        f"{own}, a joint of a leg or above one, {self.crooked[joint]}; scale there must be the same "
                        "along all axes and in all frames: apply it in the program that the file comes from"
                    )
                    return (Note("scaled-leg", text, "error", joints=(own,)),)
        return ()

    @cached_property
    def file_clip(self) -> Clip:
        """Get the motion in the file's units and axes."""
        places, turns, times = [], [], self.grid.times
        for j, k in enumerate(self.joints):
            turn = self.tracks.get((k, "rotation"))
            places.append(self._scaled(j, self.local(j)))
            turns.append(constant_track(self.nodes.rotations[k], len(times)) if turn is None else turn.at(times))
        return Clip.from_tracks(self._skeleton(places), places, turns, self.grid.step)

    @cached_property
    def clip(self) -> Clip:
        """Get the motion in metres, y up."""
        return self.file_clip if self.plain else in_metres(self.file_clip, self.unit_m, self.up)

    @property
    def start(self) -> float:
        """Get the time of the first frame, as players count it [s]."""
        return self.grid.start

    @property
    def plain(self) -> bool:
        """Tell whether unit and up axis are those of glTF."""
        return self.unit_m == 1.0 and self.up == "y"

    def placed(self, *, unit_m: float | None = None, up: str | None = None) -> Document:
        """Return the same file read with another unit [m] and upward axis."""
        unit_m, up = self.unit_m if unit_m is None else unit_m, self.up if up is None else up
        check_unit_and_up(unit_m, up)
        document = replace(self, unit_m=unit_m, up=up)
        for key in ("file_clip", "scales", "crooked", "unusable"):
            if key in self.__dict__:
                document.__dict__[key] = self.__dict__[key]
        return document

    def parent(self, joint: int) -> int:
        """Find the joint above another one; -1 for a root."""
        return int(self._parents[joint])

    def local(self, joint: int) -> Floats:
        """Get the translation (F, 3) of a joint's node, in its parent's frame and scale."""
        node = self.joints[joint]
        track = self.tracks.get((node, "translation"))
        if track is None:
            return constant_track(self.nodes.translations[node], self.frames)
        values: Floats = np.asarray(track.at(self.grid.times))
        return values

    @cached_property
    def _parents(self) -> Ints:
        number = {node: j for j, node in enumerate(self.joints)}
        return np.array([number.get(int(self.nodes.parents[node]), -1) for node in self.joints], dtype=np.intp)

    def _own_scale(self, node: int) -> Floats:
        track = self.tracks.get((node, "scale"))
        return np.asarray(self.nodes.scales[node] if track is None else track.values[0])

    def _scaled(self, joint: int, local: Floats) -> Floats:
        """Get the place (F, 3) of a joint in its parent's frame, in the units of the world."""
        parent = int(self._parents[joint])
        size = np.ones(1) if parent < 0 else self.scales[parent]
        if len(size) > 1:
            return np.asarray(local * size[:, None])
        if float(size[0]) == 1.0:
            return local
        if local.strides[0] == 0:
            return constant_track(local[0] * float(size[0]), len(local))
        return np.asarray(local * float(size[0]))

    def _skeleton(self, places: list[Floats]) -> Skeleton:
        parents = self._parents
        offsets = np.array([
            self.nodes.translations[k] * (1.0 if p < 0 else float(self.scales[p][0]))
            for k, p in zip(self.joints, parents.tolist(), strict=True)
        ]).reshape(-1, 3)  # fmt: skip
        size = float(np.linalg.norm(offsets, axis=1).sum())
        moves = [float(np.ptp(place, axis=0).max(initial=0.0)) > _STILL * size for place in places]
        names = tuple(self.nodes.names[k] for k in self.joints)
        return Skeleton(names, parents, offsets, translates=np.array(moves, np.bool_) | _stems(parents))


def _stems(parents: Ints) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    """Find the joints from each root down to the first that branches: any of them can move the figure as a whole."""
    count = np.bincount(parents[parents >= 0], minlength=len(parents))
    stem = np.zeros(len(parents), np.bool_)
    for joint, parent in enumerate(parents.tolist()):
        stem[joint] = parent < 0 or (stem[parent] and count[parent] == 1)
    return stem
