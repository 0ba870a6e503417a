"""One straight line: the same steps for the command and for Python, on the motion range, measured as written."""

from __future__ import annotations

from dataclasses import fields, replace
from functools import cache

import artefacts
import exports
import numpy as np
import pytest
from bvhmaker import side_by_side
from walker import Walk, make
from walker_plan import Gait

import footfix
from footfix import pipeline
from footfix.batch import gates
from footfix.batch.output_paths import Job
from footfix.batch.task import Task
from footfix.enforce.original_frames import uncropped
from footfix.formats.contacts import Labels
from footfix.jobs.clean import clean_file
from footfix.jobs.measure import measure_file
from footfix.jobs.source import read
from footfix.measure.plants import PlantMeasure
from footfix.motion import rotation, threads
from footfix.motion.clip import Clip, Floats
from footfix.motion.contacts import Contact
from footfix.motion.lead_in import motion_range
from footfix.motion.smoothing import SmoothParams
from footfix.notes import Note
from footfix.report import document
from footfix.rig.find import find_rig
from footfix.rig.motion_crop import Crop, crop
from footfix.settings import ReportParams, Settings

SETTINGS = Settings(report=ReportParams(kind="json"))
SMOOTHING = replace(SETTINGS, smooth=SmoothParams(seconds=0.15, channels=True))
UNITS = ("_mm", "_deg")  # that fields of measures end in
LED_IN = 3  # frames of T-pose before the motion


@cache
def walk(name: str = "walk", fps: float = 60.0, seed: int = 1) -> Walk:
    return make(Gait(name=name, duration=2.0, fps=fps, seed=seed))  # type: ignore[arg-type]


@cache
def skating(seed: int = 1) -> bytes:
    return exports.bvh(artefacts.shake(artefacts.wander(walk(seed=seed).clip, 0.04, seed=seed), 0.3))


def led_in(clip: Clip) -> Clip:
    return artefacts.t_pose_first(artefacts.turned(clip, 0.0, (4.0, 4.0)), LED_IN)


# ---- command and Python -----------------------------------------------------------------------------


@pytest.mark.parametrize(("settings", "t_pose"), [(SETTINGS, True), (SMOOTHING, False)])
def test_the_command_and_python_do_the_same(settings: Settings, t_pose: bool) -> None:
    data = exports.bvh(led_in(read(skating(), "a.bvh", SETTINGS).clip)) if t_pose else skating()
    outputs = clean_file(data, "a.bvh", settings)
    clip = read(data, "a.bvh", settings).clip
    result = footfix.clean(clip, settings)
    written = read(outputs.motion, "a.bvh", settings).clip
    assert np.allclose(written.positions, result.clip.positions, atol=1e-6)
    assert np.abs(np.einsum("fji,fji->fj", written.rotations, result.clip.rotations)).min() > 1.0 - 1e-9
    rows = outputs.report["plants"]
    assert [(row["effector"], row["start"], row["end"], row["outcome"]) for row in rows] == [
        (plant.name, plant.start, plant.end, plant.outcome) for plant in result.plants
    ]
    assert outputs.report["before"] == document.measures(result.before)


def test_a_clip_cleaned_again_in_one_process_gives_the_same_bytes() -> None:
    """Nothing is remembered from one clip to the next: neither of the same one nor of another between."""
    clip, other = (exports.bvh(read(skating(seed), "a.bvh", SETTINGS).clip.frames(slice(80))) for seed in (1, 2))
    one, _, again = (clean_file(data, "a.bvh", SETTINGS) for data in (clip, other, clip))
    assert one.status == "cleaned"
    assert (one.motion, one.contacts) == (again.motion, again.contacts)
    assert {**one.report, "seconds": 0} == {**again.report, "seconds": 0}


def test_a_clip_comes_out_the_same_on_one_processor_and_on_two(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(threads, "LONG", 1)  # so that a short clip, too, is worked on by several threads
    found = []
    for count in (1, 2):
        monkeypatch.setattr(threads.os, "sched_getaffinity", lambda of, n=count: set(range(n)), raising=False)
        assert threads.processors() == count
        found.append(clean_file(skating(), "a.bvh", Settings()))
    one, two = found
    assert one.status == "cleaned"
    assert (one.motion, one.contacts, one.pages, one.report) == (two.motion, two.contacts, two.pages, two.report)


def test_contacts_are_detected_on_the_motion_that_is_enforced() -> None:
    clip = read(skating(), "a.bvh", SETTINGS).clip
    rig = find_rig(clip)
    found = footfix.clean(clip, SMOOTHING, rig=rig).contacts
    smoothed = pipeline.prepare(clip, SMOOTHING, (rig,), motion_range(clip)).clip
    assert found.effectors == footfix.detect(smoothed, rig).effectors
    assert found.effectors != footfix.detect(clip, rig).effectors, "smoothing was to make a difference"


def test_after_is_measured_on_the_written_file_for_every_figure() -> None:
    other = exports.bvh(artefacts.wander(artefacts.turned(walk(seed=2).clip, 0.4, (2.0, 1.0)), 0.04, seed=3))
    outputs = clean_file(side_by_side(skating(), other), "two.bvh", SETTINGS)
    spans: dict[str, tuple[Contact, ...]] = {}
    for row in outputs.report["plants"]:
        spans[row["effector"]] = (*spans.get(row["effector"], ()), Contact(row["start"], row["end"]))
    measured = measure_file(outputs.motion, "two.bvh", SETTINGS, labels=Labels(spans))[1]
    after = outputs.report["after"]
    assert set(measured) == set(after)
    for key, value in after.items():
        # the rig of the written file is found anew: what hangs on its soles and floor differs a little
        assert measured[key] == pytest.approx(value, rel=0.02, abs=1.0), key
    for key in ("jitter_100m_s3", "slide_median_mm", "peak_knee_speed_deg_s", "coverage", "plants"):
        assert measured[key] == pytest.approx(after[key], rel=1e-4, abs=1e-3), key


def test_check_enforces_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    def never(*_: object, **__: object) -> None:
        raise AssertionError("check is to measure the clip as it is")

    monkeypatch.setattr(pipeline, "enforce", never)
    assert measure_file(skating(), "a.bvh", SETTINGS)[1]["plants"]


# ---- on a belt --------------------------------------------------------------------------------------


def test_on_a_belt_a_gate_on_the_world_is_skipped_and_says_so(
    monkeypatch: pytest.MonkeyPatch, tmp_path: object
) -> None:
    made = walk("treadmill")
    belt = np.arange(len(made.clip))[:, None] * made.clip.frame_time * np.array(made.belt)  # (F, 3) [m]
    data, wanted = exports.bvh(made.clip), {"skating_ratio": 0.0, "slide_mm": 30.0, "phys_skate_mm": 0.0}
    task = Task(Job("a.bvh", None, None), SETTINGS, folder=str(tmp_path), extra={"gates": wanted})

    def ground(*_: object) -> Floats:
        return belt

    def still(*_: object) -> Floats:
        return 0.0 * belt

    monkeypatch.setattr(pipeline, "ground_of", still)
    at_rest = gates.check(task, data)
    assert {each["measure"] for each in at_rest.report["over"]} == set(wanted)
    monkeypatch.setattr(pipeline, "ground_of", ground)
    on_belt = gates.check(task, data)
    assert on_belt.status == "done" and on_belt.report["measures"]["skating_ratio"] is None
    (note,) = (each for each in on_belt.report["notes"] if each["id"] == "not-measured")
    assert "skating_ratio, phys_skate_mm" in note["text"] and "belt" in note["text"]


def test_of_several_figures_the_one_on_the_ground_answers_for_the_world() -> None:
    one = {"plants": 2, "slide_mm": 3.0, "skating_ratio": None}
    other = {"plants": 1, "slide_mm": 4.0, "skating_ratio": 0.1}
    assert document.worst([one, other]) == {"plants": 3, "slide_mm": 4.0, "skating_ratio": 0.1}
    assert document.worst([one, one])["skating_ratio"] is None


# ---- cut out and put back ---------------------------------------------------------------------------


def test_what_is_cut_out_comes_back() -> None:
    made = walk()
    motion = Crop(5, 100, len(made.clip))
    inner = motion.contacts(made.contacts)
    assert inner.frames == 95 and motion.cut == (True, True)
    mask = made.contacts.mask()
    mask[:5] = mask[100:] = False
    assert np.array_equal(motion.contacts_back(inner).mask(), mask)
    assert np.array_equal(motion.clip(made.clip).positions, made.clip.positions[5:100])
    notes = (Note("a", "about frames", start=1, end=4), Note("b", "about all"))
    assert motion.notes_back(notes) == (replace(notes[0], start=6, end=9), notes[1])
    assert motion.contacts_back(replace(inner, notes=notes)).notes == motion.notes_back(notes)
    track = np.arange(95.0)[:, None]
    assert motion.track_back(track)[[0, 5, 99, -1], 0].tolist() == [0.0, 0.0, 94.0, 94.0]
    whole = Crop(0, len(made.clip), len(made.clip))
    assert whole.clip(made.clip) is made.clip and whole.contacts(made.contacts) is made.contacts


def test_a_t_pose_stays_and_everything_else_is_as_without_it() -> None:
    clip = read(skating(), "a.bvh", SETTINGS).clip
    longer = led_in(clip)
    rig = find_rig(longer)
    alone = footfix.clean(artefacts.turned(clip, 0.0, (4.0, 4.0)), rig=rig)
    found = footfix.clean(longer, rig=rig)
    assert np.array_equal(found.clip.positions[:LED_IN], longer.positions[:LED_IN])
    assert np.array_equal(found.clip.rotations[:LED_IN], longer.rotations[:LED_IN])
    shift = np.linalg.norm(found.correction.root_shift, axis=1)
    assert shift[LED_IN] < 0.1 * np.linalg.norm(alone.correction.root_shift[0])  # after a cut it starts small
    later = len(clip) // 2
    assert np.allclose(found.clip.positions[LED_IN + later :], alone.clip.positions[later:], atol=0.003)
    assert np.allclose(found.clip.rotations[LED_IN + later :], alone.clip.rotations[later:], atol=0.003)
    for later, plant in zip(found.plants, alone.plants, strict=True):
        assert (later.start, later.end) == (plant.start + LED_IN, plant.end + LED_IN)
        assert later.held == tuple((start + LED_IN, end + LED_IN) for start, end in plant.held)
    slides, others = ([each.slide_mm for each in result.plants_after] for result in (found, alone))
    assert slides == pytest.approx(others, abs=1.0)


def test_frames_that_lead_over_from_a_t_pose_lead_to_what_is_corrected() -> None:
    clip = led_in(walk().clip)
    rig = find_rig(clip)
    rotations, positions = clip.rotations.copy(), clip.positions.copy()
    for frame in (1, 2):
        share = frame / LED_IN
        rotations[frame] = rotation.slerp(rotations[0], rotations[LED_IN], np.array(share))
        positions[frame] = (1.0 - share) * positions[0] + share * positions[LED_IN]
    clip = replace(clip, rotations=rotations, positions=positions)
    motion = crop(clip, rig)
    assert motion.cut == (True, False) and motion.start == LED_IN
    made = footfix.clean(motion.clip(clip), rig=rig)
    rise = np.tile([0.0, 0.03, 0.0], (len(clip) - LED_IN, 1))  # (F, 3) [m]
    inner = pipeline.enforce(motion.clip(clip), rig, made.contacts, SETTINGS.enforce)
    inner = replace(inner, correction=replace(inner.correction, root_shift=rise))
    shift = uncropped(inner, clip, motion).correction.root_shift
    assert np.allclose(shift[:4, 1], [0.0, 0.01, 0.02, 0.03], atol=2e-3) and np.allclose(shift[3:], rise)


def test_legs_that_go_on_through_a_cut_are_not_cut() -> None:
    """Only the arms of the first frame are those of another pose: the legs are all motion."""
    clip = walk("stand").clip
    arms = [j for j, name in enumerate(clip.skeleton.names) if "Arm" in name or "Hand" in name or "Shoulder" in name]
    turned = rotation.from_axis_angle(np.array([[0.0, 0.0, 1.0]]), np.radians([80.0]))
    rotations = clip.rotations.copy()
    rotations[0, arms] = rotation.identity((len(arms),))
    rotations[1:, arms] = rotation.multiply(turned[:, None], clip.rotations[1:, arms])
    clip = replace(clip, rotations=rotations)
    assert motion_range(clip).start == 1
    assert crop(clip, find_rig(clip)) == Crop(0, len(clip), len(clip))


def test_labels_that_lie_in_a_t_pose_are_written_but_no_plants() -> None:
    data = exports.bvh(led_in(walk().clip))
    labels = Labels({"left_heel": (Contact(0, 2), Contact(10, 30)), "left_toe": (), "right_heel": (), "right_toe": ()})
    outputs = clean_file(data, "a.bvh", SETTINGS, labels=labels)
    assert [(row["id"], row["start"], row["end"]) for row in outputs.report["plants"]] == [(0, 10, 30)]
    assert b'"start": 0' in outputs.contacts and outputs.report["before"]["plants"] == 1


# ---- the report -------------------------------------------------------------------------------------


def test_a_row_of_the_report_holds_what_its_plant_did_before_and_after() -> None:
    result = footfix.clean(read(skating(), "a.bvh", SETTINGS).clip)
    figures = {each.name: 10.0 + k for k, each in enumerate(fields(PlantMeasure)) if each.name.endswith(UNITS)}
    was = [replace(each, **{key: value + 100.0 * k for key, value in figures.items()})
           for k, each in enumerate(result.plants_before)]  # fmt: skip
    now = [replace(each, **{key: getattr(each, key) + 0.5 for key in figures}) for each in was]
    rows = document.plants(result.plants[::-1], was, now)  # joined by their ids, in whatever order
    for plant, row in zip(result.plants[::-1], rows, strict=True):
        assert (row["id"], row["effector"], row["start"]) == (plant.id, was[plant.id].effector, was[plant.id].start)
        for key in figures:
            stem, unit = key.rsplit("_", 1)
            if f"{stem}_before_{unit}" in row:
                assert row[f"{stem}_before_{unit}"] == figures[key] + 100.0 * plant.id
                assert row[f"{stem}_after_{unit}"] == row[f"{stem}_before_{unit}"] + 0.5
    assert {key for key in rows[0] if "_after_" in key} >= {
        "slide_after_mm", "tip_slide_after_mm", "travel_after_mm", "yaw_after_deg", "penetration_after_mm",
    }  # fmt: skip
    assert [plant.id for plant in result.plants] == list(range(len(was)))


def test_the_largest_joint_change_is_named() -> None:
    clip = walk().clip
    rig = find_rig(clip)
    found = footfix.clean(clip, rig=rig).correction
    knees = [leg.knee for leg in rig.legs]
    turns = np.stack([clip.rotation(knee) for knee in knees], axis=1)
    bend = rotation.from_axis_angle(np.array([1.0, 0.0, 0.0]), np.radians(31.0))
    turns[75, 1] = rotation.multiply(turns[75, 1], bend)
    shift = np.zeros((len(clip), 3))
    shift[-1], shift[20] = (0.03, 0.01, 0.04), (0.0, 0.06, 0.0)  # [m]
    change = replace(found, root_shift=shift, joints=tuple(knees), rotations=turns)
    entry = document.corrections([change], clip)
    assert entry["largest_change_joint"] == clip.skeleton.names[knees[1]]
    assert entry["largest_change_frame"] == 75
    assert entry["largest_change_deg"] == entry["max_joint_rotation_deg"] == pytest.approx(31.0)
    assert (entry["max_root_shift_mm"], entry["root_path_drift_m"]) == (pytest.approx(60.0), pytest.approx(0.05))
    nothing = replace(found, root_shift=np.zeros((len(clip), 3)), joints=(), rotations=turns[:, :0])
    assert document.corrections([nothing], clip) == document.NO_CORRECTION
    both = document.corrections([nothing, change], clip)
    assert both == entry


@pytest.mark.parametrize("times", [2, 3])
def test_frames_that_are_repeated_are_cleaned_as_if_they_were_not(times: int) -> None:
    clip = artefacts.wander(make(Gait(fps=30.0, duration=3.0)).clip, 0.05)
    long = replace(clip.frames(np.repeat(np.arange(len(clip)), times)), frame_time=clip.frame_time / times)
    rig = find_rig(clip)
    one, other = (pipeline.clean_figures(each, rigs=(rig,))[0] for each in (clip, long))
    assert "frames-doubled" in {note.id for note in other.notes} - {note.id for note in one.notes}
    for effector, again in zip(one.contacts.effectors, other.contacts.effectors, strict=True):
        assert [(times * c.start, times * c.end) for c in effector.contacts] == [
            (c.start, c.end) for c in again.contacts
        ]
    for k in range(times):
        assert np.allclose(other.clip.rotations[k::times], one.clip.rotations, atol=1e-6)
        assert np.array_equal(other.clip.rotations[k::times], other.clip.rotations[::times])
    assert other.after.slide_mm == pytest.approx(one.after.slide_mm, abs=0.01)
