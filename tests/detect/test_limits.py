"""Where a detector must hold back: kneeling, feet high over their floor, and stretches that could be either."""

from __future__ import annotations

import numpy as np
import pytest

from footfix.detect import auto as detector
from footfix.detect.auto import AutoParams, auto, grounded
from footfix.detect.evidence import BODY, COLUMNS, OWN
from footfix.detect.kneeling import KneelingParams, carrying
from footfix.detect.network import FLAT, HEEL, SWING, TOE
from footfix.detect.tracks import FootTracks, Tracks
from footfix.detect.uncertainty import DoubtParams, unsure
from footfix.motion.clip import Floats


def _kneeler(knee_height: float, speed: float) -> tuple[Tracks, FootTracks]:
    """Two seconds at 50 fps; the toe goes along the floor at some speed [m/s]."""
    times = np.arange(100)[:, None] * 0.02

    def track(y: float, v: float = 0.0) -> Floats:
        return np.array([0.0, y, 0.0]) + times * [0.0, 0.0, v]

    foot = FootTracks("left", track(0.5), track(0.1), track(0.1), track(0.0, speed), knee=track(knee_height))
    return Tracks(track(0.55), (foot,), 0.9, 0.02), foot


@pytest.mark.parametrize(
    ("knee", "speed", "kept"), [(0.05, 0.5, False), (0.05, 0.0, True), (0.5, 0.5, True), (0.5, 0.0, True)]
)
def test_a_foot_that_is_dragged_behind_its_knee_carries_nothing(knee: float, speed: float, kept: bool) -> None:
    tracks, foot = _kneeler(knee, speed)
    mask = np.ones(100, dtype=np.bool_)
    assert carrying(mask, tracks, foot, foot.toe, KneelingParams()).all() == kept
    if not kept:
        assert not carrying(mask, tracks, foot, foot.toe, KneelingParams()).any()


def test_a_short_rest_while_kneeling_is_no_contact() -> None:
    tracks, foot = _kneeler(0.05, 0.0)
    for frames, kept in ((10, False), (20, True)):  # 0.2 s and 0.4 s
        mask = np.zeros(100, dtype=np.bool_)
        mask[40 : 40 + frames] = True
        assert carrying(mask, tracks, foot, foot.toe, KneelingParams()).any() == kept


@pytest.mark.parametrize("others", [0.0, 0.3])
def test_no_foot_stands_high_over_the_floor_ahead_and_behind(others: float) -> None:
    heights = np.array([0.0, 0.05, 0.065, 0.1, 0.3])
    curves = np.zeros((len(heights), len(COLUMNS)))
    for name in ("heel over floor ahead", "heel over floor behind"):
        curves[:, COLUMNS.index(name)] = np.arcsinh(heights / OWN[name])
    for name in ("toe over floor ahead", "toe over floor behind"):
        curves[:, COLUMNS.index(name)] = np.arcsinh((heights + others) / OWN[name])
    sure = np.log(np.tile([0.001, 0.333, 0.333, 0.333], (len(heights), 1)))
    said = np.exp(grounded(sure, curves, AutoParams()))
    assert said.sum(axis=1) == pytest.approx(1.0)
    planted = said[:, HEEL:].sum(axis=1)
    assert planted[0] == pytest.approx(0.999, abs=1e-3)
    assert planted[2] == pytest.approx(0.5)
    assert np.all(np.diff(planted) <= 0.0)
    assert planted[3] < 0.01
    # one step up ahead is enough for a foot to stand there
    curves[:, COLUMNS.index("heel over floor ahead")] = 0.0
    assert np.exp(grounded(sure, curves, AutoParams()))[:, SWING] == pytest.approx(0.001, abs=1e-3)


@pytest.mark.parametrize(("way", "sign"), [("behind", 1.0), ("ahead", -1.0)])
def test_a_foot_that_rises_has_left_and_one_that_falls_has_yet_to_land(way: str, sign: float) -> None:
    """A foot 0.2 legs over the floor on one side, and on the floor of the other, moves up or down."""

    def planted(own: tuple[float, float], mate: float = 0.0, pelvis: float = 0.0, height: float = 0.2) -> float:
        curves = np.zeros((1, len(COLUMNS)))
        for part, rise in zip(("heel", "toe"), own, strict=True):
            curves[:, COLUMNS.index(f"{part} over floor {way}")] = np.arcsinh(height / OWN[f"{part} over floor {way}"])
            curves[:, COLUMNS.index(f"{part} rise")] = np.arcsinh(sign * rise / OWN[f"{part} rise"])
            curves[:, COLUMNS.index(f"other {part} rise")] = np.arcsinh(sign * mate / OWN[f"{part} rise"])
        curves[:, COLUMNS.index("pelvis rise")] = np.arcsinh(sign * pelvis / BODY["pelvis rise"])
        sure = np.log(np.array([[0.001, 0.333, 0.333, 0.333]]))
        return float(np.exp(grounded(sure, curves, AutoParams()))[0, HEEL:].sum())

    assert planted((3.0, 3.0)) < 0.01
    assert planted((0.1, 0.1)) > 0.99  # on a stair
    assert planted((3.0, 0.1)) > 0.99 and planted((0.1, 3.0)) > 0.99  # rolls
    assert planted((-3.0, -3.0)) > 0.99  # has just climbed the stair
    assert planted((3.0, 3.0), height=0.04) > 0.99
    assert planted((3.0, 3.0), mate=3.0) > 0.99  # the root does not move, and the figure crouches
    assert planted((3.0, 3.0), mate=3.0, pelvis=3.0) < 0.01  # jumps
    assert np.all(np.diff([planted((rise, rise)) for rise in (0.3, 0.6, 1.0, 1.5)]) <= 0.0)


def test_long_stretches_that_could_be_either_are_told_the_longest_first_of_all() -> None:
    tracks, _ = _kneeler(0.5, 0.0)
    planted = np.full(100, 0.99)
    planted[10:20] = 0.5  # 0.2 s: too short to tell
    planted[30:50] = 0.5
    planted[60:90] = 0.6
    notes = unsure(planted, tracks, "left", DoubtParams(most=1))
    assert [(note.id, note.start, note.end) for note in notes] == [("contact-doubtful", 60, 90)]
    assert [note.start for note in unsure(planted, tracks, "left", DoubtParams(most=5))] == [30, 60]


def test_what_is_found_on_the_grid_is_told_in_frames(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whoever stands is unsure from 1.0 to 1.6 s, which are frames 50 to 80 of a clip at 50 fps."""
    tracks, _ = _kneeler(0.5, 0.0)
    heel = np.where((np.arange(199) >= 100) & (np.arange(199) <= 160), 0.5, 0.98)
    answer = np.log(np.stack([1.0 - heel, 0.5 * heel, 0.3 * heel, 0.2 * heel], axis=1))
    monkeypatch.setattr(detector, "log_probabilities", lambda *_: ((answer,), (answer,)))
    found = auto(tracks, AutoParams())
    assert [(note.start, note.end) for note in found.notes if note.id == "contact-doubtful"] == [(50, 81)]
    assert found.confidence is not None
    parts = {HEEL: 1, FLAT: 2, TOE: 3}
    share = np.array([0.5, 0.3, 0.2])
    for column, states in enumerate(((HEEL, FLAT), (FLAT, TOE))):
        expected = sum(share[parts[state] - 1] for state in states) * heel[::2][:100]
        assert found.confidence[:, column] == pytest.approx(expected)


@pytest.mark.parametrize(("rise", "left"), [(0.008, False), (0.012, True)])  # [leg lengths]
def test_a_heel_that_hardly_rises_while_the_toe_stands_never_left(
    monkeypatch: pytest.MonkeyPatch, rise: float, left: bool
) -> None:
    tracks, foot = _kneeler(0.5, 0.0)
    up = foot.heel.copy()
    up[40:60, 1] += rise * tracks.leg_length
    raised = Tracks(tracks.pelvis, (FootTracks("left", foot.hip, foot.ankle, up, foot.toe, foot.knee),), 0.9, 0.02)
    state = np.where((np.arange(199) >= 80) & (np.arange(199) < 120), TOE, FLAT)
    answer = np.log(np.full((199, 4), 0.001 / 3) + 0.999 * np.eye(4)[state])
    monkeypatch.setattr(detector, "log_probabilities", lambda *_: ((answer,), (answer,)))
    heel, toe = auto(raised, AutoParams()).mask.T
    assert toe.all()
    assert heel[45:55].any() != left and heel[:35].all() and heel[65:].all()


def test_a_foot_without_a_knee_kneels_never() -> None:
    tracks, foot = _kneeler(0.05, 0.5)
    mask = np.ones(100, dtype=np.bool_)
    bare = FootTracks("left", foot.hip, foot.ankle, foot.heel, foot.toe)
    assert not carrying(mask, tracks, foot, foot.toe, KneelingParams()).any()
    assert carrying(mask, tracks, bare, foot.toe, KneelingParams()) is mask
    nothing = ~mask
    assert carrying(nothing, tracks, foot, foot.toe, KneelingParams()) is nothing
