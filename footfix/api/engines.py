"""Locomotion from cycles, from Python: models fitted to clips, and engines that walk and run in real time."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from footfix.api.parameters import check_settings
from footfix.batch.cycles import load_model as _load_model
from footfix.batch.file_io import read_whole, write_whole
from footfix.errors import ArgumentError, InputError
from footfix.formats.cycle_models import encode_model
from footfix.formats.locomotion_plans import PlanRow
from footfix.jobs.fit_cycles import Fitted, cycles_of_file, fit_files
from footfix.jobs.make_cycles import plan_of
from footfix.locomotion.cycles.engine_state import Live
from footfix.locomotion.cycles.model import CycleModel
from footfix.locomotion.cycles.plan import Plan
from footfix.locomotion.follow.path import make_path
from footfix.motion.clip import Clip, Floats, Skeleton, frozen
from footfix.rig.rig import Rig
from footfix.settings import Settings

__all__ = ["Ahead", "Engine", "Frame", "fit_cycles", "load_model", "save_model"]


@dataclass(frozen=True, eq=False)
class Frame:
    """One posture.

    Args:
        time: [s] since the engine began.
        positions: (J, 3) [m] each joint's place in its parent's frame, as in a `Clip`; the root's in the world.
        rotations: (J, 4) xyzw likewise.
        contacts: effector -> whether it is planted.
    """

    time: float
    positions: Floats
    rotations: Floats
    contacts: Mapping[str, bool]


@dataclass(frozen=True, eq=False)
class Ahead:
    """What comes next, if nothing else is asked for.

    Args:
        times: (T,) [s] since the engine began.
        positions: (T, J, 3) [m] as in a `Clip`.
        rotations: (T, J, 4) xyzw.
        contacts: (T, E) whether each effector is planted.
        effectors: their names.
        plants: effector -> (start [s], end [s], (x, y, z) [m]) of its contacts, begun ones too.
    """

    times: Floats
    positions: Floats
    rotations: Floats
    contacts: np.ndarray
    effectors: tuple[str, ...]
    plants: Mapping[str, tuple[tuple[float, float, tuple[float, float, float]], ...]]


class Engine:
    """Walks and runs, frame by frame, at any speed, and knows what comes next.

    Args:
        model: of `fit_cycles` or `load_model`, or the file of one.
        speed: [m/s]; by default the middle of what the model's first gait was captured at.
        run: 0 to walk, 1 to run, or between; by default what people do at that speed.
        turn: [degrees/s] to the left.
        style: a name, or weights by name.
        path: points (N, 2) [m], x and z, to go along; it begins at the first of them, and `turn` is not looked at.
    """

    def __init__(
        self, model: CycleModel | str | Path, *, speed: float | None = None, run: float | None = None,
        turn: float = 0.0, style: str | Mapping[str, float] | None = None, path: ArrayLike | None = None,
    ) -> None:  # fmt: skip
        self.model = model if isinstance(model, CycleModel) else load_model(model)
        line = None if path is None else make_path(np.asarray(path, dtype=np.float64))
        self._live = Live(self.model, self._row(speed, run, turn, style), line)
        self._at_rest = frozen(self.model.skeleton.offsets)

    @property
    def time(self) -> float:
        """Get the time since it began [s]."""
        return self._live.time

    @property
    def skeleton(self) -> Skeleton:
        """Get the figure's joints."""
        return self.model.skeleton

    @property
    def rig(self) -> Rig:
        """Get its legs and soles."""
        return self.model.rig

    def set(
        self, *, speed: float | None = None, run: float | None = None, turn: float | None = None,
        style: str | Mapping[str, float] | None = None, over: float = 1.0,
    ) -> None:  # fmt: skip
        """Ask for something else, from now on; what is not named goes on as it was asked for before.

        To ask for the same again, and no sooner, changes nothing.

        Args:
            speed: [m/s].
            run: 0 to walk, 1 to run, or between.
            turn: [degrees/s] to the left.
            style: a name, or weights by name; "" for the plain one.
            over: [s] how long the change takes: a quarter of a second at least, and as long as feet need to follow,
                which is a second for 150 degrees/s or 1.5 m/s (of legs of 0.9 m), and 1.4 s from a walk to a run.
        """
        if not np.isfinite(over) or over < 0.0:
            raise ArgumentError(f"over must be the seconds that a change takes, not {over!r}")
        target = self._row(speed, run, turn, style)
        named = [speed is not None, run is not None, turn is not None] + [style is not None] * len(self.model.styles)
        self._live.ask(target, np.array(named), over)

    def step(self, dt: float) -> Frame:
        """Go on by `dt` [s], and give the posture then."""
        if not 0.0 <= dt < 10.0:
            raise ArgumentError(f"dt must be the seconds since the last frame, not {dt!r}")
        found, k = self._live.step(dt)
        down = dict(zip(found.names, found.contacts[k].tolist(), strict=True))
        return Frame(self.time, self._places(found.place[k]), frozen(found.turns[k]), down)

    def ahead(self, seconds: float, *, frames: int = 25) -> Ahead:
        """Predict what comes next: postures from now on, and where the feet are going to stand.

        What was asked for is in it; where something else is asked for in every frame, what was a tenth of a second ago.

        Args:
            seconds: [s] how far.
            frames: how many postures, at even times, the first of them now.
        """
        if not 0.0 < seconds <= 60.0 or frames < 1:
            raise ArgumentError(f"ahead needs up to 60 seconds and a frame at least, not {seconds!r} and {frames!r}")
        found = self._live.ahead(seconds, frames)
        places, turns = self._places(found.place), frozen(found.turns)
        return Ahead(found.times, places, turns, found.contacts, found.names, self._plants(seconds))

    def clip(self, frames: Sequence[Frame], frame_time: float) -> Clip:
        """Make a clip of frames that were stepped through."""
        positions = np.stack([each.positions for each in frames])
        return Clip(self.skeleton, positions, np.stack([each.rotations for each in frames]), frame_time)

    def _row(
        self, speed: float | None, run: float | None, turn: float | None, style: str | Mapping[str, float] | None
    ) -> Plan:
        bounds = (("speed", speed, 0.0, 100.0), ("run", run, 0.0, 1.0), ("turn", turn, -720.0, 720.0))
        for name, value, low, high in bounds:
            if value is not None and not low <= value <= high:
                raise ArgumentError(f"{name} must be {low:g} to {high:g}, not {value!r}")
        weights = ({style: 1.0} if style else {}) if isinstance(style, str) else style
        return plan_of([PlanRow(0.0, speed, run, turn, weights)], self.model)

    def _places(self, root: Floats) -> Floats:
        """Place all joints (..., J, 3) [m] by the root's place (..., 3)."""
        places = np.empty((*root.shape[:-1], *self._at_rest.shape))
        places[:] = self._at_rest
        places[..., self.rig.root, :] = root
        return frozen(places)

    def _plants(self, seconds: float) -> dict[str, tuple[tuple[float, float, tuple[float, float, float]], ...]]:
        out = {}
        for sole in self.rig.soles:
            own, part = [], int(sole.part == "toe")
            for stance in self._live.prediction.feet.stances[sole.leg]:
                span = stance.spans[part]
                if span is not None and span[1] > self.time and span[0] <= self.time + seconds:
                    x, y, z = stance.points[part].tolist()
                    own.append((*span, (x, y, z)))
            out[sole.name] = tuple(own)
        return out


def fit_cycles(
    files: Iterable[str | Path], settings: Settings | None = None, *, styles: Mapping[str, str] | None = None,
    components: int | None = None,
) -> Fitted:  # fmt: skip
    """Fit a model to the straight walks and runs in clips of one skeleton.

    Args:
        files: the clips.
        settings: how figures and contacts are found.
        styles: file -> name of its style; files that are not named are plain.
        components: the most principal components that a gait keeps.

    Returns:
        The model, the error of a file left out, and what was not used.

    Raises:
        InputError: there is too little to learn from; a clip that can't be read is passed over.
    """
    settings = check_settings(settings)
    found, wrong = [], {}
    names = {str(key): value for key, value in (styles or {}).items()}
    for file in files:
        try:
            data = read_whole(file, settings.limits.bytes)
            found.append(cycles_of_file(data, str(file), settings, style=names.get(str(file), "")))
        except InputError as error:
            wrong[str(file)] = str(error)
    fitted = fit_files(found, components=components)
    return Fitted(fitted.model, fitted.error, {**fitted.skipped, **wrong})


def load_model(path: str | Path) -> CycleModel:
    """Read a model of cycles.

    Raises:
        InputError: the file can't be read, or is not a model.
    """
    return _load_model(path)


def save_model(path: str | Path, model: CycleModel) -> None:
    """Write a model of cycles, whole or not at all."""
    write_whole(Path(path), encode_model(model))
