"""The curves of the evidence against their definitions, written down a second time for feet whose ways are parabolas.

Savitzky-Golay filters of degree two keep parabolas and their derivatives, so that what they give is known exactly.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from footfix.detect import evidence as curves
from footfix.detect.evidence import BODY, COLUMNS, OTHER, OWN, STEP, catmull_rom, evidence, mates, resample
from footfix.detect.tracks import FootTracks, Tracks
from footfix.motion.clip import Floats

LEG = 0.8  # [m]
T = np.arange(301) * STEP  # [s] a frame for each step of the grid
MIDDLE = slice(110, 190)  # as far from both ends as any window reaches
SCALES = OWN | {f"other {name}": OWN[name] for name in OTHER} | BODY

# Coefficients (3, 3) of x, y and z: a place [m], a speed [m/s], half an acceleration [m/s^2].
PELVIS = np.array([[0.0, 0.9, 0.1], [0.0, 0.05, 1.1], [0.02, -0.04, 0.06]])
FEET = {
    "left": {
        "hip": [[0.1, 0.85, 0.1], [0.0, 0.05, 1.1], [0.02, -0.04, 0.06]],
        "ankle": [[0.12, 0.3, -0.2], [0.03, -0.1, 1.3], [0.04, 0.05, 0.1]],
        "heel": [[0.12, 0.2, -0.25], [0.02, -0.2, 1.2], [0.05, 0.06, -0.1]],
        "toe": [[0.13, 0.25, 0.0], [0.01, -0.28, 1.4], [-0.02, 0.09, 0.12]],
    },
    "right": {
        "hip": [[-0.1, 0.85, 0.1], [0.0, 0.05, 1.1], [0.02, -0.04, 0.06]],
        "ankle": [[-0.12, 0.25, 0.3], [0.02, 0.1, 0.8], [-0.01, -0.05, -0.1]],
        "heel": [[-0.12, 0.15, 0.25], [0.03, 0.1, 0.7], [0.02, -0.03, 0.1]],
        "toe": [[-0.13, 0.12, 0.5], [-0.02, 0.15, 0.9], [0.03, -0.05, 0.1]],
    },
}


def way(coefficients: object, derivative: int = 0) -> Floats:
    """(F, 3) [m, m/s or m/s^2] a parabola, or its derivatives."""
    a, v, c = np.array(coefficients)
    return np.array([
        a + T[:, None] * v + T[:, None] ** 2 * c, v + 2.0 * T[:, None] * c, np.tile(2.0 * c, (len(T), 1)),
    ][derivative])  # fmt: skip


def tracks() -> Tracks:
    feet = (FootTracks(side, *(way(FEET[side][name]) for name in ("hip", "ankle", "heel", "toe"))) for side in FEET)
    return Tracks(way(PELVIS), tuple(feet), LEG, STEP)


def lowest(height: Floats, seconds: float, *, ahead: bool) -> Floats:
    """(n,) the lowest of what is within some time, by looking at each step."""
    n = round(seconds / STEP)
    return np.array([height[max(k - n * (not ahead), 0) : k + 1 + n * ahead].min() for k in range(len(height))])


@cache
def defined(side: str) -> dict[str, Floats]:
    """What the names of the curves of a foot mean, in leg lengths and seconds."""
    c, other = FEET[side], FEET["right" if side == "left" else "left"]
    heel, toe, ankle, hip = (way(c[name]) / LEG for name in ("heel", "toe", "ankle", "hip"))
    low = np.minimum(heel[:, 1], toe[:, 1])
    others = np.minimum(way(other["heel"])[:, 1], way(other["toe"])[:, 1]) / LEG
    found: dict[str, Floats] = {}
    for name, point in (("heel", heel), ("toe", toe)):
        fast, bent = way(c[name], 1) / LEG, way(c[name], 2) / LEG
        found[f"{name} over floor ahead"] = point[:, 1] - lowest(low, 0.5, ahead=True)
        found[f"{name} over floor behind"] = point[:, 1] - lowest(low, 0.5, ahead=False)
        own = np.maximum(*(lowest(point[:, 1], 1.0, ahead=ahead) for ahead in (True, False)))
        found[f"{name} over its own floor"] = point[:, 1] - own
        found[f"{name} rise"], found[f"{name} lift"] = fast[:, 1], bent[:, 1]
        found[f"{name} speed"] = np.hypot(fast[:, 0], fast[:, 2])
    outwards = 1.0 if side == "left" else -1.0  # the hips face along z, the left one lies at +x
    for when, suffix in ((0, ""), (1, " speed past")):
        past = (way(c["ankle"], when) - way(PELVIS, when)) / LEG
        found[f"forward{suffix or ' of'} pelvis"] = past[:, 2]
        found[f"outward{suffix or ' of'} pelvis"] = outwards * past[:, 0]
    found["forward push"] = (way(c["ankle"], 2) - way(PELVIS, 2))[:, 2] / LEG
    line, moves = ankle - hip, (way(c["ankle"], 1) - way(c["hip"], 1)) / LEG
    found["reach"] = 1.0 - np.linalg.norm(line, axis=1)
    found["reach speed"] = np.sum(line * moves, axis=1) / np.linalg.norm(line, axis=1)
    pair = np.minimum(low, others)
    found["over lower foot"] = low - np.minimum(*(lowest(pair, 0.8, ahead=ahead) for ahead in (True, False)))
    found["pelvis rise"], found["pelvis lift"] = way(PELVIS, 1)[:, 1] / LEG, way(PELVIS, 2)[:, 1] / LEG
    found["jitter"] = np.zeros(len(T))
    return found


@cache
def found_curves() -> tuple[Floats, ...]:
    """The curves of each foot."""
    return tuple(evidence(resample(tracks())))


@pytest.mark.parametrize("column", COLUMNS)
def test_a_curve_is_what_its_name_says(column: str) -> None:
    for k, (side, mate) in enumerate((("left", "right"), ("right", "left"))):
        curves = found_curves()[k]
        name = column.removeprefix("other ")
        expected = defined(mate if column.startswith("other ") else side)[name]
        found = SCALES[column] * np.sinh(curves[:, COLUMNS.index(column)])
        assert found[MIDDLE] == pytest.approx(expected[MIDDLE], abs=2e-3 if name == "reach speed" else 1e-9)


@pytest.mark.parametrize("noise", [0.001, 0.004])
def test_jitter_is_the_deviation_of_white_noise_of_the_ankles_in_thousandths_of_a_leg(noise: float) -> None:
    rng = np.random.default_rng(0)
    t = np.arange(2000) * STEP
    still = np.zeros((len(t), 3))
    feet = []
    for side in FEET:
        ankle = np.stack([t, noise * rng.normal(size=len(t)), 0.3 * t**2], axis=1)
        feet.append(FootTracks(side, still, ankle, still, still))
    assert resample(Tracks(still, tuple(feet), LEG, STEP)).jitter == pytest.approx(1000.0 * noise / LEG, rel=0.1)


def test_a_foots_mate_is_the_one_whose_hip_is_nearest() -> None:
    still = np.zeros((3, 3))
    hips = [(0.1, 0.8, 0.9), (0.12, 0.8, 0.0), (-0.1, 0.8, 0.9), (-0.12, 0.8, 0.0)]
    feet = tuple(FootTracks(str(k), still + hip, still, still, still) for k, hip in enumerate(hips))
    assert mates(feet) == (2, 3, 0, 1)
    assert mates(feet[:1]) == (0,)


def test_a_foot_without_a_mate_faces_where_its_toes_point() -> None:
    foot = FootTracks("left", *(way(FEET["left"]["hip"]) + [0.0, 0.0, z] for z in (0.0, 0.0, -0.1, 0.1)))
    (found,) = evidence(resample(Tracks(way(PELVIS) - [0.0, 0.0, 0.3], (foot,), LEG, STEP)))
    column = found[:, COLUMNS.index("forward of pelvis")]
    assert OWN["forward of pelvis"] * np.sinh(column[MIDDLE]) == pytest.approx(np.full(80, 0.3 / LEG))


def test_the_network_is_fitted_to_these_units_and_windows() -> None:
    """Who changes one of them has to fit it again."""
    units = {
        0.01: ["heel over its own floor", "toe over its own floor"],
        0.02: [f"{part} over floor {way}" for part in ("heel", "toe") for way in ("ahead", "behind")],
        0.05: ["over lower foot"],
        0.1: ["outward of pelvis", "reach"],
        0.3: [
            "heel rise", "toe rise", "heel speed", "toe speed", "forward of pelvis", "outward speed past pelvis",
            "pelvis rise",
        ],
        0.5: ["forward speed past pelvis", "reach speed"],
        2.0: ["jitter"],
        5.0: ["pelvis lift"],
        10.0: ["heel lift", "toe lift", "forward push"],
    }  # fmt: skip
    assert {name: unit for unit, names in units.items() for name in names} == OWN | BODY
    windows = (curves.STEP, curves.SMOOTH, curves.SPEED, curves.LIFT, curves.FLOOR, curves.OWN_FLOOR, curves.BOTH)
    assert (*windows, curves.FACING) == (0.01, 0.03, 0.05, 0.09, 0.5, 1.0, 0.8, 0.25)


def test_a_facing_is_seen_over_a_quarter_of_a_second() -> None:
    still = np.zeros((200, 3))
    swung = still.copy()
    swung[100, 0] = 1.0  # the hips are turned in one step of the grid
    feet = (FootTracks("left", still + [0.1, 0.8, 0.0] + 0.0 * swung, still, still, still + [0.0, 0.0, 0.2]),
            FootTracks("right", still + [-0.1, 0.8, 0.0] + 0.01 * swung[:, [1, 2, 0]], still, still,
                 still + [0.0, 0.0, 0.2]))  # fmt: skip
    (forward, _), _ = resample(Tracks(still, feet, LEG, STEP)).axes
    turned = np.flatnonzero(np.abs(forward[:, 0]) > 1e-9)
    assert turned[[0, -1]].tolist() == [100 - 13, 100 + 13] or turned[[0, -1]].tolist() == [100 - 12, 100 + 12]


@pytest.mark.parametrize(("fps", "smoothed"), [(30.0, False), (60.0, False), (240.0, True)])
def test_quick_clips_are_smoothed_before_they_are_sampled(fps: float, smoothed: bool) -> None:
    still = np.zeros((round(2 * fps), 3))
    spike = still.copy()
    spike[30, 1] = 1.0  # one frame
    foot = FootTracks("left", still, still, still, still)
    found = resample(Tracks(spike, (foot,), LEG, 1.0 / fps)).tracks.pelvis[:, 1]
    exact = catmull_rom(spike, STEP * fps)[:, 1] / LEG
    assert np.allclose(found, exact) is not smoothed


def test_one_frame_is_sampled_as_it_is() -> None:
    assert catmull_rom(np.array([[1.0, 2.0]]), 0.3).tolist() == [[1.0, 2.0]]


@pytest.mark.parametrize("heading", [0.0, 0.7, 2.0, -2.5])
def test_outward_of_a_foot_without_a_mate_is_at_right_angles_to_its_toes(heading: float) -> None:
    ahead = np.array([np.sin(heading), 0.0, np.cos(heading)])
    still = np.zeros((100, 3))
    foot = FootTracks("left", still, still, still - 0.1 * ahead, still + 0.1 * ahead)
    ((forward, outward),) = resample(Tracks(still, (foot,), LEG, STEP)).axes
    assert forward == pytest.approx(np.tile(ahead[::2], (100, 1)))
    assert np.abs(np.sum(forward * outward, axis=1)).max() < 1e-12
