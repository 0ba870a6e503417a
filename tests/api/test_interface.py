"""The Python interface: the same as the commands, and every public name is there."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import cache
from pathlib import Path

import exports
import jsonschema
import numpy as np
import pytest
from bvhmaker import side_by_side
from conftest import ROOT, SAMPLES
from walks import walk

import footfix
from footfix.jobs import source

SETTINGS = footfix.Settings()
SAMPLE = SAMPLES / "walk_skate.bvh"


@cache
def sample() -> footfix.Document:
    return footfix.load(SAMPLE)


@cache
def result() -> footfix.Result:
    return footfix.clean(sample().clip)


@pytest.mark.parametrize("name", footfix.__all__)
def test_every_public_name_is_there_and_explained(name: str) -> None:
    found = getattr(footfix, name)
    assert name in dir(footfix)
    assert name == "__version__" or found.__doc__


def test_packages_of_the_same_name_do_not_hide_functions() -> None:
    from footfix.detect import auto
    from footfix.measure import plants

    assert footfix.detect(sample().clip) == result().contacts
    assert footfix.measure(sample().clip, result().rig, result().contacts) == result().before
    assert auto.auto is footfix.detect.auto.auto  # type: ignore[attr-defined]
    assert plants is footfix.measure.plants  # type: ignore[attr-defined]


def test_a_correction_applied_is_the_corrected_clip() -> None:
    again = footfix.apply(sample().clip, result().correction)
    assert np.array_equal(again.positions, result().clip.positions)
    assert np.array_equal(again.rotations, result().clip.rotations)


@pytest.mark.parametrize("suffix", [".json", ".csv", ".npz"])
def test_contacts_come_back_as_they_were_written(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"walk{suffix}"
    footfix.save_contacts(path, result().contacts, clip=sample().clip, rig=result().rig, like=sample())
    back = footfix.load_contacts(path, sample().clip, result().rig)
    assert np.array_equal(back.mask(), result().contacts.mask())


def test_labels_say_how_they_can_be_written(tmp_path: Path) -> None:
    with pytest.raises(footfix.ArgumentError, match=r"\.json, \.csv, \.npz or \.npy"):
        footfix.save_contacts(tmp_path / "walk.txt", result().contacts)
    with pytest.raises(footfix.ArgumentError, match="clip= and rig="):
        footfix.save_contacts(tmp_path / "walk.json", result().contacts)


def test_a_report_is_that_of_the_command_but_for_the_digits_of_the_file() -> None:
    made = footfix.make_report(result(), sample().clip, like=sample())
    schema = json.loads((ROOT / "footfix/report/schemas/report.v1.json").read_text(encoding="utf-8"))
    jsonschema.validate(made, schema)
    told = footfix.clean_file(SAMPLE).report
    assert made["source"] == told["source"]
    assert made["before"] == told["before"]
    assert [plant["outcome"] for plant in made["plants"]] == [plant["outcome"] for plant in told["plants"]]
    assert footfix.summarize(made).startswith("walk_skate.bvh: ")


def test_a_page_stands_alone() -> None:
    page = footfix.make_page(result(), sample().clip)
    assert page.startswith(b"<!")
    assert b"clip.bvh" in page


def named_otherwise() -> footfix.Clip:
    skeleton = sample().clip.skeleton
    return replace(sample().clip, skeleton=replace(skeleton, names=tuple(name + "_" for name in skeleton.names)))


def test_a_file_of_joints_of_another_clip_is_not_written(tmp_path: Path) -> None:
    with pytest.raises(footfix.ArgumentError, match="not those of"):
        footfix.save(tmp_path / "out.bvh", named_otherwise(), like=sample())
    with pytest.raises(footfix.ArgumentError, match="100 frames"):
        footfix.save(tmp_path / "out.bvh", sample().clip.frames(slice(0, 100)), like=sample())


def test_every_figure_of_a_clip_is_cleaned() -> None:
    both = source.read(side_by_side(exports.bvh(walk().clip), exports.bvh(walk("run").clip)), "both.bvh", SETTINGS).clip
    one, other = footfix.clean_figures(both)
    assert one.clip is other.clip
    assert other.contacts.names[0] == "figure2_left_heel"
    alone = footfix.clean(both)
    assert alone.contacts == one.contacts


def test_settings_are_made_of_a_preset_and_values() -> None:
    made = footfix.make_settings("video", {"detect": {"method": "lyard"}, "smooth.seconds": 0.2})
    assert (made.detect.method, made.smooth.seconds) == ("lyard", 0.2)
    assert footfix.make_settings() == footfix.Settings()
    assert "video" in footfix.presets()
    assert replace(made, gates={}).enforce == footfix.make_settings("video").enforce
