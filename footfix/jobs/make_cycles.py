"""From a model of cycles and a plan to the bytes of a clip, its contacts, report and page."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import PurePath
from typing import Any

import numpy as np

from footfix import version
from footfix.enforce.correction import Correction
from footfix.enforce.footplant import Footplant
from footfix.errors import UsageError
from footfix.formats.bvh.compose import compose
from footfix.formats.document import open_document
from footfix.formats.locomotion_plans import PlanRow
from footfix.jobs.contacts import contacts_json
from footfix.jobs.outputs import Outputs
from footfix.locomotion.cycles.engine import Prediction, postures, predict
from footfix.locomotion.cycles.model import CycleModel
from footfix.locomotion.cycles.plan import Line, Plan, Point
from footfix.locomotion.cycles.postures import Postures, cycle_postures
from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats
from footfix.motion.contacts import Contacts
from footfix.motion.duplicate_frames import DuplicateFrames
from footfix.pipeline import Figure, measure_figures
from footfix.report import document as report_format
from footfix.report.pages import draw
from footfix.settings import Settings, plain, suggest

_RUNS = 0.5  # Froude number v^2 / (g l) above which people prefer to run (R. McN. Alexander 1989)
_UNIT = 0.01  # [m] of the file


@dataclass(frozen=True, eq=False)
class Made:
    """Locomotion that was made.

    Args:
        clip: F frames.
        free: the same before the feet were held in place.
        contacts: which sole points are planted.
        prediction: course and plants.
        postures: the sampled postures of its frames.
    """

    clip: Clip
    free: Clip
    contacts: Contacts
    prediction: Prediction
    postures: Postures


def plan_of(rows: Sequence[PlanRow], model: CycleModel) -> Plan:
    """Make a plan from its rows.

    Values that no row gives have defaults: the middle speed of the model's first gait, and no turn. Walk or run is
    chosen by the speed where no row says.

    Raises:
        UsageError: a style is not one of the model's.
    """
    times = np.array([row.time for row in rows])

    def line(values: Sequence[float | None], usual: float) -> Floats:
        known = [(row.time, v) for row, v in zip(rows, values, strict=True) if v is not None]
        return np.interp(times, *np.array(known).T) if known else np.full(len(times), usual)

    first = model.spaces[0].ramp
    speed = line([row.speed for row in rows], 0.5 * (first.low + first.high) * model.froude)
    runs = [float((v / model.froude) ** 2 > _RUNS) for v in speed]
    run = line([row.run for row in rows], 0.0) if any(row.run is not None for row in rows) else np.array(runs)
    turn = np.radians(line([row.turn for row in rows], 0.0))
    style = np.zeros((len(rows), len(model.styles)))
    for name in {name for row in rows for name in row.style or ()}:
        if name not in model.styles:
            known = f"{suggest(name, model.styles)}" if model.styles else "; it knows no styles"
            raise UsageError(f"the model has no style {name!r}{known}")
    for k, name in enumerate(model.styles):
        style[:, k] = line([None if row.style is None else row.style.get(name, 0.0) for row in rows], 0.0)
    return Plan(times, speed, run, turn, style)


def make(model: CycleModel, plan: Plan, *, seconds: float, fps: float, line: Line | None = None) -> Made:
    """Make locomotion from a model.

    Args:
        model: of the figure.
        plan: speed, turn, gait and style over time.
        seconds: [s] how long.
        fps: frames a second.
        line: the path to go along; `plan.turn` is then ignored.
    """
    times = np.arange(round(seconds * fps) + 1) / fps
    prediction = predict(model, plan, line, Point(), float(times[-1]))
    found = postures(model, prediction, times)
    as_cycles = cycle_postures(model, prediction.course, times)
    clip = found.clip(model, 1.0 / fps)
    contacts = model.rig.no_contacts(clip).with_mask(found.contacts)
    free = replace(found, place=as_cycles.place, turns=as_cycles.turns).clip(model, 1.0 / fps)
    return Made(clip, free, replace(contacts, method="cycles"), prediction, found)


def make_file(
    model: CycleModel, plan: Plan, settings: Settings, *, seconds: float, fps: float, source: Mapping[str, Any],
    line: Line | None = None, output: str | None = None,
) -> Outputs:  # fmt: skip
    """Make locomotion as a BVH file, with its contacts, report and page.

    Args:
        model: of the figure.
        plan: speed, turn, gait and style over time.
        settings: which report files are written.
        seconds: [s] how long.
        fps: frames a second.
        source: the report's entry on the model's file.
        line: the path to go along.
        output: the name of the file.
    """
    made = make(model, plan, seconds=seconds, fps=fps, line=line)
    written = compose(made.clip, unit_m=_UNIT)
    again = open_document(written, name="made.bvh", limits=settings.limits).placed(unit_m=_UNIT, up="y").clip
    clip = Clip(again.skeleton, again.positions, again.rotations, made.clip.frame_time)
    plants = _plants(made, model)
    source = {**source, "frames": len(clip), "frame_time": clip.frame_time}
    legs = model.legs.turned
    turned = np.stack([made.clip.rotation(joint) for joint in legs], axis=1)
    still = np.zeros((len(clip), 3))
    correction = Correction(model.rig.root, still, legs, turned)
    every = DuplicateFrames(np.arange(len(clip)), len(clip))
    figure = Figure(model.rig, made.contacts, made.contacts, plants, correction, still, every, ())
    (result,) = measure_figures(made.free, clip, (figure,))
    report = {
        **report_format.frame(source, version.__version__, status="cleaned", output=output),
        "method": "cycles",
        "rig": report_format.rig(model.rig, clip, unit_m=_UNIT, up="y"),
        "settings": plain(settings),
        "cycles": cycles_entry(made, model, plan, line),
        "before": report_format.measures(result.before),
        "after": report_format.measures(result.after),
        "plants": report_format.plants(result.plants, result.plants_before, result.plants_after),
        "correction": report_format.corrections([correction], made.free),
        "notes": [],
        "seconds": {
            "clip": report_format.rounded(len(clip) * clip.frame_time),
            "in_contact": report_format.rounded(float(made.contacts.mask().any(axis=1).sum()) * clip.frame_time),
        },
    }
    of = {**source, "sha256": hashlib.sha256(written).hexdigest()}
    of["file"] = PurePath(output).name if output else source["file"]
    contacts_file = contacts_json(made.contacts, of, report["rig"], settings)
    pages, offenders = draw(made.free, clip, model.rig, report, contacts_file, settings.report, None, still)
    return Outputs("cleaned", written, contacts_file, report, pages, offenders)


def _plants(made: Made, model: CycleModel) -> tuple[Footplant, ...]:
    """Describe every contact and its position, as rows of the report."""
    place, turns = made.postures.place, made.postures.turns
    frames = rotation.to_matrix(turns[:, model.leg_joints])
    poses = model.legs.poses(place, frames[:, 0], frames[:, 1:])
    found = list[Footplant]()
    for e, (sole, effector) in enumerate(zip(model.rig.soles, made.contacts.effectors, strict=True)):
        track = (poses.heel if sole.part == "heel" else poses.toe)[:, sole.leg]
        for c in effector.contacts:
            own = track[c.start : c.end]
            x, y, z = np.median(own, axis=0).tolist()
            residual = float(np.hypot(own[:, 0] - x, own[:, 2] - z).max())
            found.append(Footplant(
                len(found), e, sole.name, sole.leg, sole.part, c.start, c.end, target=(x, y, z), outcome="pinned",
                residual=residual, held=((c.start, c.end),),
            ))  # fmt: skip
    return tuple(found)


def cycles_entry(made: Made, model: CycleModel, plan: Plan, line: Line | None) -> dict[str, Any]:
    """Describe locomotion made from cycles as the report's entry; each key carries its unit."""
    number, course = report_format.rounded, made.prediction.course
    times = made.postures.times
    phase = course.phases(times)
    gone = course.lengths(times)
    return {
        "plan": [
            {"time_s": number(t), "speed_m_s": number(v), "run": number(r), "turn_deg_s": number(np.degrees(w)),
             "style": {name: number(s) for name, s in zip(model.styles, style, strict=True) if s}}
            for t, v, r, w, style in zip(plan.times, plan.speed, plan.run, plan.turn, plan.style, strict=True)
        ],
        "path": line is not None,
        "cycles": number(float(phase[-1] - phase[0])),
        "distance_m": number(float(gone[-1] - gone[0])),
        "speed_m_s": number(float(gone[-1] - gone[0]) / float(times[-1] - times[0])) if len(times) > 1 else None,
        "turned_deg": number(float(np.degrees(np.diff(course.where(times[[0, -1]])[1])[0]))),
        "gaits": list(model.gaits),
        "styles": list(model.styles),
    }  # fmt: skip
