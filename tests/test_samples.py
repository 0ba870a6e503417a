"""The sample files: what the script makes is what lies there, and what is known of their contacts is so."""

from __future__ import annotations

import json

import numpy as np
import pytest
from conftest import SAMPLES
from make_samples import files, samples

from footfix.formats.bvh import decode
from footfix.formats.contacts import decode as decode_labels
from footfix.motion.kinematics import forward

CLEAN = ("walk", "run", "turn", "stairs")


def test_files_are_what_the_script_makes() -> None:
    for path, data in files().items():
        assert (SAMPLES / path).read_bytes() == data, f"{path} differs: run sample_data/make_samples.py"
        assert len(data) < 400_000


@pytest.mark.parametrize(
    "name", sorted(path.stem.removesuffix(".contacts") for path in (SAMPLES / "truth").glob("*.json"))
)
def test_known_contacts_are_read_as_labels(name: str) -> None:
    sample = samples()[name]
    labels = decode_labels((SAMPLES / "truth" / f"{name}.contacts.json").read_bytes())
    assert labels.frames == len(sample.clip)
    for effector in sample.contacts.effectors:
        found = [(each.start, each.end) for each in labels.effectors[effector.name]]
        assert found == [(each.start, each.end) for each in effector.contacts]


@pytest.mark.parametrize("name", CLEAN)
def test_planted_points_rest_in_the_file(name: str) -> None:
    clip = decode((SAMPLES / f"{name}.bvh").read_bytes()).placed(unit_m=0.01, up="y").clip
    truth = json.loads((SAMPLES / "truth" / f"{name}.contacts.json").read_bytes())
    toe = {"LeftToeBase": "left_toe", "RightToeBase": "right_toe"}
    pose = forward(clip)
    for effector in truth["effectors"]:
        if effector["joint"] in toe:
            track = pose.position(clip.skeleton.names.index(effector["joint"]))
            for contact in effector["contacts"]:
                assert np.ptp(track[contact["start"] : contact["end"]], axis=0).max() < 2e-5  # 4 decimals of a cm
                place = np.array(contact["position_m"])
                assert np.abs(track[contact["start"]] - place)[[0, 2]].max() < 2e-5


def test_the_skating_walk_skates() -> None:
    clip = decode((SAMPLES / "walk_skate.bvh").read_bytes()).placed(unit_m=0.01, up="y").clip
    contacts = samples()["walk_skate"].contacts["right_toe"].contacts
    track = forward(clip).position(clip.skeleton.names.index("RightToeBase"))
    slides = [float(np.linalg.norm(np.ptp(track[each.start : each.end, [0, 2]], axis=0))) for each in contacts]
    assert max(slides) > 0.042  # twice what viewers notice
