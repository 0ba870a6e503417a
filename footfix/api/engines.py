"""Locomotion from cycles, from Python: models fitted to clips, and engines that walk and run in real time."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from footfix.api.parameters import check_settings
from footfix.batch.cycles import load_model as _load_model
from footfix.batch.files import read_whole, write_whole
from footfix.errors import ArgumentError, InputError
from footfix.formats.models import encode_model
from footfix.formats.plans import PlanRow
from footfix.jobs.fit import Fitted, cycles_of_file, fit_files
from footfix.jobs.make import plan_of
from footfix.locomotion.cycles.engine import Begun, begin, changed_plan, finish, foresee, postures
from footfix.locomotion.cycles.model import CycleModel
from footfix.locomotion.cycles.plan import Plan, Point
from footfix.locomotion.cycles.postures import Postures, held
from footfix.locomotion.follow.path import make_path
from footfix.motion.clip import Clip, Floats, Skeleton, frozen
from footfix.rig.rig import Rig
from footfix.settings import Settings

__all__ = ["Ahead", "Engine", "Frame", "fit_cycles", "load_model", "save_model"]

_KNOWN = 0.9  # [s] that are foreseen when something else is asked for,
_LEAST = 0.45  # [s] and when this is left, foreseen anew,
_LONG = 1.6  # [s] and farther, since nothing else was asked for
_PAST = 0.3  # [s] in which it is remembered what was asked for
_BATCH = 4  # frames that are made at once: they cost little more than one
_BRIEF = 0.02  # [s] frames that are briefer are spared half of the work when something else is asked for


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
        self.time = 0.0
        line = None if path is None else make_path(np.asarray(path, dtype=np.float64))
        self._plan = self._row(speed, run, turn, style)
        self._until = _KNOWN
        self._foreseen = foresee(self.model, self._plan, line, Point(), self._until)
        self._begun: Begun | None = None  # what is being foreseen anew, from now on
        self._wanted = self._plan.some(slice(-1, None))  # what is asked for in the end, and from when on,
        self._ends = self._plan.ends()
        self._asked = np.zeros(len(self._ends), dtype=np.bool_)  # and what of that is not in the plan yet
        self._made: tuple[Postures, int] | None = None  # frames, and which of them is the one now
        self._at_rest = frozen(self.model.skeleton.offsets)

    @property
    def skeleton(self) -> Skeleton:
        """The figure's joints."""
        return self.model.skeleton

    @property
    def rig(self) -> Rig:
        """Its legs and soles."""
        return self.model.rig

    def set(
        self, *, speed: float | None = None, run: float | None = None, turn: float | None = None,
        style: str | Mapping[str, float] | None = None, over: float = 1.0,
    ) -> None:  # fmt: skip
        """Ask for something else, from now on; what is not named goes to where it was going.

        To ask for the same again, and no sooner, changes nothing.

        Args:
            speed: [m/s].
            run: 0 to walk, 1 to run, or between.
            turn: [degrees/s] to the left.
            style: a name, or weights by name; "" for the plain one.
            over: [s] how long the change takes: a quarter of a second at least, and as long as feet need to follow,
                which is a second for 150 degrees/s, 1.5 m/s (of legs of 0.9 m), or from a walk to a run.
        """
        if not np.isfinite(over) or over < 0.0:
            raise ArgumentError(f"over must be the seconds that a change takes, not {over!r}")
        new = self._row(speed, run, turn, style)
        named = np.array([each is not None for each in (speed, run, turn)] + [style is not None] * new.style.shape[1])
        row, last = new.table[0], self._wanted.table[0]
        end = self.time + over
        changed = named & ((row != last) | (end < self._ends))
        if changed.any():
            self._wanted = Plan.of_table(new.times, np.where(changed, row, last)[None])
            self._ends = np.where(changed, end, self._ends)
            self._asked |= changed

    def step(self, dt: float) -> Frame:
        """Go on by `dt` [s], and give the posture then."""
        if not 0.0 <= dt < 10.0:
            raise ArgumentError(f"dt must be the seconds since the last frame, not {dt!r}")
        if dt > _BRIEF:
            if self._begun is not None:
                self._finish(0.0)
            self._begin(dt)
        self.time += dt
        known = self._known()
        if self._begun is not None:
            self._finish(dt)
        elif known is None:
            self._made = postures(self.model, self._foreseen, self._next(dt)), 0
        else:
            self._made = known
            self._begin()
        found, k = self._made
        down = dict(zip(found.names, found.contacts[k].tolist(), strict=True))
        return Frame(self.time, self._places(found)[k], frozen(found.turns[k]), down)

    def ahead(self, seconds: float, *, frames: int = 25) -> Ahead:
        """Foresee what comes next: postures from now on, and where the feet are going to stand.

        Args:
            seconds: [s] how far.
            frames: how many postures, at even times, the first of them now.
        """
        if not 0.0 < seconds <= 60.0 or frames < 1:
            raise ArgumentError(f"ahead needs up to 60 seconds and a frame at least, not {seconds!r} and {frames!r}")
        self._take_up(seconds)
        times = np.linspace(self.time, self.time + seconds, frames)
        found = postures(self.model, self._foreseen, times)
        return Ahead(
            times, self._places(found), frozen(found.turns), found.contacts, found.names, self._plants(seconds)
        )  # fmt: skip

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

    def _take_up(self, seconds: float) -> None:
        """Foresee all that was asked for, from now on, and far enough to be told of so many seconds."""
        if self._begun is not None:
            self._finish(0.0)
        self._begin(seconds)
        if self._begun is not None:
            self._finish(0.0)

    def _begin(self, seconds: float = 0.0) -> None:
        """Begin to foresee anew from now on, if something else is asked for, or more."""
        asked = bool(self._asked.any())
        if not asked and self._until - self.time >= max(seconds, _LEAST):
            return
        if asked:
            ends = np.where(self._asked, self._ends, np.nan)
            self._plan = changed_plan(self.model, self._plan, self.time, ends, self._wanted)
            self._asked[:] = False
        self._plan = self._plan.since(self.time - _PAST)
        self._until = self.time + max(_KNOWN if asked else _LONG, seconds + _LEAST)
        self._begun = begin(self.model, self._foreseen, self._plan, self._point(), self._until)

    def _finish(self, dt: float) -> None:
        """Foresee what was begun, and make the next frames, of so many seconds."""
        assert self._begun is not None
        times = self._next(dt)
        self._foreseen, led = finish(self.model, self._foreseen, self._begun, times, self._led())
        self._made, self._begun = (held(self.model, self._foreseen.feet, led), 0), None

    def _next(self, dt: float) -> Floats:
        """The times of some frames, the first of them now."""
        times = [self.time]
        while dt > 0.0 and len(times) < _BATCH and times[-1] + dt < self._until:
            times.append(times[-1] + dt)  # as they are going to be told, to the last bit
        return np.array(times)

    def _known(self) -> tuple[Postures, int] | None:
        """The frame now, if it was made."""
        if self._made is None:
            return None
        found, k = self._made
        return (found, k + 1) if k + 1 < len(found) and found.times[k + 1] == self.time else None

    def _point(self) -> Point:
        """Where the course is at the frame that was given last."""
        if self._made is None:
            return Point()
        found, k = self._made
        return Point(float(found.times[k]), *found.at[k].tolist())

    def _led(self) -> Floats | None:
        return None if self._made is None else self._made[0].led[self._made[1]]

    def _places(self, found: Postures) -> Floats:
        places = np.tile(self._at_rest, (len(found), 1, 1))
        places[:, self.rig.root] = found.place
        return frozen(places)

    def _plants(self, seconds: float) -> dict[str, tuple[tuple[float, float, tuple[float, float, float]], ...]]:
        out = {}
        for sole in self.rig.soles:
            own, part = [], int(sole.part == "toe")
            for stance in self._foreseen.feet.stances[sole.leg]:
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
        InputError: the file can't be read, or is none.
    """
    return _load_model(path)


def save_model(path: str | Path, model: CycleModel) -> None:
    """Write a model of cycles, whole or not at all."""
    write_whole(Path(path), encode_model(model))
