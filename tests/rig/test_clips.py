"""The rig of real files against what a person sees in them, one row a file in `rig_expectations.tsv`.

The rows were written from the hierarchies and from plots of the motion, by hand. `unit_m` is `?` where a person
could not tell, `cmu` for the 17.7 units to the metre of the CMU library; a toe of `-` says there is no joint at
the ball of the foot.
"""

from __future__ import annotations

import csv
import json
import os
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from conftest import SHARED
from rigmaker import legs, mirrored, nameless, shuffled, with_up

from footfix.errors import NoLegsError
from footfix.formats.bvh import Document, decode
from footfix.motion.clip import Clip
from footfix.rig.find import find_rig
from footfix.rig.frame_sample import sample
from footfix.rig.leg_assignment import figures
from footfix.rig.params import RigParams
from footfix.rig.rig import Rig
from footfix.rig.units import AXES, FileUnits, infer_units

pytestmark = pytest.mark.clips

CMU = 1.0 / 17.7
EVERY_CLIP = bool(os.environ.get("FOOTFIX_EVERY_CLIP"))
with (Path(__file__).parents[1] / "rig_expectations.tsv").open(encoding="utf-8", newline="") as file:
    ROWS = list(csv.DictReader(file, delimiter="\t"))


def _read(name: str) -> Document:
    path = SHARED / name
    if not path.exists():
        pytest.skip(f"no clip: {path} is absent")
    return decode(path.read_bytes(), name=name)


def _told(rig: Rig, clip: Clip) -> str:
    names = clip.skeleton.names
    told = []
    for leg in rig.legs:
        joints = (leg.hip, leg.knee, leg.ankle, leg.toe)
        told.append(f"{leg.name}:" + ",".join("-" if j is None else names[j] for j in joints))
    return ";".join(told)


@cache
def _found(name: str) -> tuple[Clip, FileUnits, Rig]:
    document = _read(name)
    found = infer_units(document.clip)
    placed = document.placed(unit_m=found.unit_m, up=found.up).clip
    return placed, found, find_rig(placed)


def _some(rows: list[dict[str, str]], most: int = 1) -> list[dict[str, str]]:
    """Of the files of one origin of which a person says the same, the smallest: they differ in length mostly."""
    size = {row["file"]: path.stat().st_size if (path := SHARED / row["file"]).exists() else 0 for row in rows}
    alike: dict[tuple[str, ...], list[dict[str, str]]] = {}
    for row in sorted(rows, key=lambda row: size[row["file"]]):
        alike.setdefault((str(Path(row["file"]).parent), *list(row.values())[1:]), []).append(row)
    return [row for each in alike.values() for row in (each if EVERY_CLIP else each[:most])]


@pytest.mark.parametrize("row", _some(ROWS), ids=lambda row: row["file"])
def test_a_person_agrees(row: dict[str, str]) -> None:
    if row["legs"] == "no legs":
        clip = _read(row["file"]).clip
        for function in (infer_units, find_rig):
            with pytest.raises(NoLegsError, match="no legs"):
                function(clip)
        return
    clip, found, rig = _found(row["file"])
    assert _told(rig, clip) == row["legs"]
    assert clip.skeleton.names[rig.root] == row["root"]
    assert found.up == row["up"]
    if row["unit_m"] != "?":
        assert found.unit_m == pytest.approx(CMU if row["unit_m"] == "cmu" else float(row["unit_m"]))


# One of each kind of skeleton, in motion plain enough to tell left, right and up without a name.
PLAIN = (
    "clips/accad/Male1_B15_WalkTurnAround.bvh", "clips/acrnn_cmudaz/05.bvh",
    "clips/anim_utils/custom_skeleton_walk_example.bvh",
    "clips/animdraw/dab.bvh", "clips/axisneuron/test.bvh", "clips/bandai/dataset-1_walk-back_normal_001.bvh",
    "clips/bvh_compress/out.bvh", "clips/bvh_toolbox/walk01.bvh", "clips/cheo/Bay.bvh", "clips/comcon2/loco.bvh",
    "clips/emre/Cartwheel.bvh", "clips/games105/run_forward.bvh", "clips/geno/Geno_stance.bvh",
    "clips/lafan_karstm/fight1_subject2_backward_filtered.bvh", "clips/makehuman/walk1.bvh",
    "clips/marcojr_cmu/running.bvh", "clips/pfe_openpose/cmu003108_480x480.bvh", "clips/pku_sfu/Obstacle.bvh",
    "clips/pymo/AV_8Walk_Meredith_HVHA_Rep1.bvh", "clips/t2m/dot.bvh", "clips/video2bvh/cxk.bvh",
    "clips/vrm_idle/idle.bvh", "clips/wham/sample.bvh", "clips/wojtek/test_anim_sword_attack.bvh",
)  # fmt: skip


@pytest.mark.parametrize("name", PLAIN[::2])
def test_names_only_confirm_what_shape_says(name: str) -> None:
    clip, _, rig = _found(name)
    other, order = shuffled(nameless(clip), seed=1)
    assert legs(find_rig(other), order) == legs(rig)


@pytest.mark.parametrize("name", PLAIN[::6])
def test_any_axis_can_be_up(name: str) -> None:
    clip, _, _ = _found(name)
    for up in AXES:
        assert infer_units(with_up(clip, up)).up == up


@pytest.mark.parametrize(
    ("name", "seconds"),
    [
        ("clips/accad/Male1_A11_CrawlForward.bvh", (0.0, 2.0)),
        ("clips/comcon2/Motion_AI_01_01-001.bvh", (12.0, 14.0)),
        ("clips/imersive/motion.bvh", (0.0, 2.0)),
    ],
)
def test_the_rest_pose_says_what_is_up_where_two_seconds_of_crawling_and_lying_do_not(
    name: str, seconds: tuple[float, float]
) -> None:
    clip = _read(name).clip
    start, stop = (round(second / clip.frame_time) for second in seconds)
    assert infer_units(clip.frames(slice(start, stop))).up == "y"


@pytest.mark.parametrize("name", PLAIN[1::2])
def test_a_mirror_swaps_sides(name: str) -> None:
    clip, _, _ = _found(name)
    one, two = find_rig(nameless(clip)), find_rig(mirrored(nameless(clip)))
    assert {(leg.side, leg.ankle) for leg in one.legs} == {
        ("left" if leg.side == "right" else "right", leg.ankle) for leg in two.legs
    }


def test_somebody_who_crawls_has_two_legs_and_a_dog_four() -> None:
    crawl, _, _ = _found("clips/accad/Male1_A11_CrawlForward.bvh")
    dog, _, rig = _found("clips/mann_dog/D1_025_KAN01_001.bvh")
    assert len(find_rig(nameless(crawl)).legs) == 2
    assert [leg.name for leg in rig.legs] == ["front_left", "front_right", "hind_left", "hind_right"]
    assert legs(find_rig(nameless(dog))) == legs(rig)
    (figure,) = figures(sample(dog), RigParams(), y_up=False)
    assert len(figure.limbs) == 2  # that four stand can only be seen where up is known


@pytest.mark.parametrize(
    ("name", "on_zero"),
    [
        ("clips/accad/Male1_A1_Stand.bvh", True),
        ("clips/bandai/dataset-2_run_elderly_001.bvh", True),
        ("clips/lafan_karstm/aiming1_subject1_walk_filtered.bvh", True),  # its toe joints lie on the plane
        ("clips/dme/demo_3d_1_fixed.bvh", True),  # so do these
        ("clips/dme/demo_3d_1_raw.bvh", False),  # sunk by 5 to 8 cm
        ("clips/makehuman/walk1.bvh", False),  # the hips are held at the origin
        ("clips/t2m/dot.bvh", False),  # floats 0.75 m above it
        ("clips/assimp/01_01.bvh", False),  # its toe joints rest 7 cm above it
        ("clips/mann_dog/D1_025_KAN01_001.bvh", False),  # paws are left as they are
    ],
)
def test_the_zero_plane_is_the_floor_where_feet_are_seen_to_rest_on_it(name: str, on_zero: bool) -> None:
    clip, _, rig = _found(name)
    assert ("zero plane" in rig.origins["floor"], rig.floor == 0.0) == (on_zero, on_zero)
    if on_zero:  # what stands is at the plane, whatever was measured
        lowest = np.min([track[:, 1] for track in rig.tracks(rig.pose(clip))], axis=0)
        assert abs(float(np.median(lowest))) < 0.015 * rig.leg_length


TRUTH = sorted(row["file"] for row in ROWS if row["file"].startswith("truth/"))


def test_soles_are_at_the_floor_while_force_plates_feel_them() -> None:
    heights, behind = [], []
    for name in TRUTH:
        clip, _, rig = _found(name)
        truth = json.loads((SHARED / name).with_suffix(".truth.json").read_text())
        tracks = rig.tracks(rig.pose(clip))
        for side, k in (("left", 0), ("right", 2)):
            middle = np.zeros(len(clip), dtype=bool)
            for start, end in truth.get(side, {}).get("contact", []):
                middle[start + (end - start) // 4 : end - (end - start) // 3] = True
            if middle.any():
                heights.append([np.median(tracks[k + i][middle, 1]) - rig.floor for i in (0, 1)])
            marker = truth["heel_local_cm"].get(side)
            if marker is not None:  # at the back of the heel, some 3.5 cm above the floor
                behind.append(np.array(rig.soles[k].offset) - np.array(marker) / 100.0)
    heel, toe = np.abs(heights).T
    assert np.median(heel) < 0.006 and np.quantile(heel, 0.9) < 0.015
    assert np.median(toe) < 0.004 and np.quantile(toe, 0.9) < 0.010
    level = np.linalg.norm(np.array(behind)[:, [0, 2]], axis=1)
    assert np.median(level) < 0.02
    assert -0.045 < np.median(np.array(behind)[:, 1]) < -0.02
