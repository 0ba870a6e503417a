"""Pins: what is to stand when, how surely, and how high, worked out from contacts by hand."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from legmaker import Figure, figure, figure_of
from walks import rig_of
from walks import short_walk as walk

from footfix.enforce.footing import Footing
from footfix.enforce.footplant import Footplant, footplants, given, stands
from footfix.enforce.leg import ANKLE, HEEL, TIP, TOE
from footfix.enforce.pins import PinParams, Pins, pins
from footfix.enforce.plant_faults import kept
from footfix.enforce.standing_heights import floors, lacks, nominal
from footfix.motion.clip import Clip, Floats
from footfix.motion.contacts import Contact, Contacts

PARAMS = PinParams()
FRAMES = 121


def still() -> Figure:
    """A walker that stands as if frozen."""
    made = walk("stand", 60.0, 2.0)
    clip = made.clip.frames(np.zeros(FRAMES, dtype=int))
    return figure_of(clip, rig_of(made), replace(made.contacts, frames=FRAMES))


def moved(made: Figure, shift: Floats) -> Figure:
    """The figure with its root shifted by (F, 3) [m]."""
    positions = made.clip.positions.copy()
    positions[:, 0] += shift
    clip = Clip(made.clip.skeleton, positions, made.clip.rotations, made.clip.frame_time)
    return figure_of(clip, made.rig, made.contacts)


def contacts_of(made: Figure, method: str = "auto", **spans: Sequence[Contact]) -> Contacts:
    effectors = tuple(replace(e, contacts=tuple(spans.get(e.name, ()))) for e in made.contacts.effectors)
    return replace(made.contacts, effectors=effectors, method=method)


def laid_out(
    made: Figure, contacts: Contacts, *, leg: int = 0, keep: bool = False, heights: bool = True,
    ground: Floats | None = None,
) -> tuple[tuple[Pins, ...], tuple[Footplant, ...]]:  # fmt: skip
    """The pins of a leg, none or all of its plants kept."""
    plants, _ = footplants(contacts, made.rig, made.legs, PARAMS.asked)
    level = floors(plants, made.legs, made.rig, PARAMS.near * made.rig.leg_length)
    by_hand = tuple(given(contacts, plant) for plant in plants)
    moves = np.zeros((len(made.clip), 3)) if ground is None else ground
    footing = Footing(plants, level, moves, (keep,) * len(plants), by_hand)
    found = pins(footing, made.legs[leg], leg, made.rig, made.clip.frame_time, heights=heights, params=PARAMS)
    return found, plants


# ---- footplants -------------------------------------------------------------------------------------


def test_each_contact_is_a_footplant_and_what_is_forbidden_is_none() -> None:
    made = still()
    contacts = contacts_of(
        made,
        left_heel=[Contact(0, 10, 0.5), Contact(20, 30, wish="forbid"), Contact(40, 50, wish="force")],
        right_toe=[Contact(5, 6, 0.9)],
    )
    found, notes = footplants(contacts, made.rig, made.legs, PARAMS.asked)
    assert notes == ()
    told = [(p.id, p.effector, p.name, p.leg, p.part, p.start, p.end, p.confidence, p.force) for p in found]
    assert told == [
        (0, 0, "left_heel", 0, "heel", 0, 10, 0.5, False),
        (1, 0, "left_heel", 0, "heel", 40, 50, 1.0, True),
        (2, 3, "right_toe", 1, "toe", 5, 6, 0.9, False),
    ]
    on = stands(found, FRAMES, 2)
    assert np.flatnonzero(on[0, 0]).tolist() == [*range(10), *range(40, 50)]
    assert np.flatnonzero(on[1, 1]).tolist() == [5] and not on[0, 1].any() and not on[1, 0].any()


def test_places_far_from_the_motion_are_not_taken_unless_forced() -> None:
    made = still()
    own = made.legs[0].place(HEEL)[:, 0]
    near, far = own + [0.05, 0.4, 0.05], own + [0.3, 0.0, 0.0]  # heights don't count
    asked = [tuple(each.tolist()) for each in (near, far, far)]
    spans = [Contact(0, 10, 1.0, asked[0]), Contact(20, 30, 1.0, asked[1]), Contact(40, 50, 1.0, asked[2], "force")]
    contacts = contacts_of(made, left_heel=spans)
    found, notes = footplants(contacts, made.rig, made.legs, PARAMS.asked)
    assert [plant.asked for plant in found] == [asked[0], None, asked[2]]
    assert [note.id for note in notes] == ["places-not-taken"] and notes[0].text.startswith("1 of 2 positions")


def test_ends_are_certain_where_somebody_gave_them() -> None:
    made = still()
    for method, confidence, wish, certain in (
        ("labels", 1.0, None, True), ("labels", 0.9, None, False), ("auto", 1.0, None, False),
        ("auto", 0.9, "force", True),
    ):  # fmt: skip
        contacts = contacts_of(made, method, left_toe=[Contact(3, 9, confidence, wish=wish)])  # type: ignore[arg-type]
        (plant,), _ = footplants(contacts, made.rig, made.legs, PARAMS.asked)
        assert given(contacts, plant) is certain


# ---- holding ----------------------------------------------------------------------------------------


def test_a_given_contact_holds_from_its_first_frame_to_its_last() -> None:
    made = still()
    contacts = contacts_of(made, "labels", left_toe=[Contact(30, 60)], left_heel=[Contact(40, 70)])
    found, _ = laid_out(made, contacts)
    assert len(found) == 4
    for point, (start, end), weight in (
        (HEEL, (40, 70), 1.0), (TOE, (30, 60), 1.0), (ANKLE, (40, 60), PARAMS.ankle), (TIP, (30, 60), PARAMS.tip)
    ):  # fmt: skip
        hold = np.zeros(FRAMES - 1)
        hold[start : end - 1] = weight  # the step from its last frame to the next is free
        assert np.allclose(found[point].hold, hold), point
        assert np.flatnonzero(found[point].stands).tolist() == list(range(start, end))
        assert not found[point].slip.any() and not found[point].placed.any()
    other, _ = laid_out(made, contacts, leg=1)
    assert not any(pin.hold.any() or pin.stands.any() for pin in other)


def test_a_detected_contact_holds_as_surely_as_it_is_and_softly_at_its_edges() -> None:
    made = figure("plain", "stand", 240.0, 2.0)
    contacts = contacts_of(made, left_toe=[Contact(100, 200, 0.8)])
    found, _ = laid_out(made, contacts)
    hold = found[TOE].hold[100:199]
    soft = round(PARAMS.edge * 240.0)
    assert soft == 4
    rise = np.minimum(((np.arange(soft) + 0.5) / soft) ** 2 + PARAMS.edge_weight, 1.0)
    assert np.allclose(hold[:soft], 0.8 * rise) and np.allclose(hold[-soft:], 0.8 * rise[::-1])
    assert np.allclose(hold[soft:-soft], 0.8)
    assert np.allclose(found[TIP].hold, PARAMS.tip * found[TOE].hold)
    assert not found[TOE].hold[:100].any() and not found[TOE].hold[199:].any()


def test_at_a_clips_own_ends_a_contact_has_no_edges() -> None:
    made = figure("plain", "stand", 240.0, 2.0)
    frames = len(made.clip)
    for start, end in ((0, 100), (frames - 100, frames), (0, frames)):
        hold = laid_out(made, contacts_of(made, left_toe=[Contact(start, end, 0.9)]))[0][TOE].hold[start : end - 1]
        assert bool(hold[0] == 0.9) is (start == 0) and bool(hold[-1] == 0.9) is (end == frames)
        assert hold[50] == 0.9


@pytest.mark.parametrize("length", [1, 2, 3, 4, 5])
def test_short_contacts_have_edges_that_fit(length: int) -> None:
    made = figure("plain", "stand", 240.0, 2.0)
    hold = laid_out(made, contacts_of(made, left_toe=[Contact(50, 50 + length, 1.0)]))[0][TOE].hold
    own = hold[50 : 49 + length]
    assert np.count_nonzero(hold) == np.count_nonzero(own) == length - 1
    assert np.allclose(own, own[::-1])
    assert length == 1 or own.max() == 1.0


@pytest.mark.parametrize("length", [3, 4, 5, 6])
def test_the_stance_of_a_run_at_30_fps_is_held_in_full(length: int) -> None:
    made = figure("plain", "stand", 30.0, 2.0)
    own = laid_out(made, contacts_of(made, left_toe=[Contact(20, 20 + length, 1.0)]))[0][TOE].hold[20 : 19 + length]
    soft = np.zeros(length - 1, dtype=np.bool_)
    soft[[0, -1]] = length > 3  # two steps are all there is of a short stance
    assert np.array_equal(own < 1.0, soft)


def test_what_is_forced_counts_a_hundredfold() -> None:
    made = still()
    contacts = contacts_of(made, left_toe=[Contact(30, 60, 0.3, wish="force")], left_heel=[Contact(30, 60, 0.4)])
    found, _ = laid_out(made, contacts)
    assert np.allclose(found[TOE].hold[30:59], 100.0)
    assert found[HEEL].hold.max() == 0.4
    assert np.allclose(found[ANKLE].hold, PARAMS.ankle * found[HEEL].hold)  # as surely as the less sure of them


def test_what_is_kept_is_held_to_its_own_slip_and_what_is_not_to_the_ground() -> None:
    made = moved(still(), 0.001 * np.arange(FRAMES)[:, None] * [1.0, 0.0, 0.5])
    belt = np.arange(FRAMES)[:, None] * np.array([0.002, 0.0, 0.0])
    contacts = contacts_of(made, "labels", left_toe=[Contact(30, 60)], left_heel=[Contact(30, 60)])
    loose, _ = laid_out(made, contacts, ground=belt)
    tight, _ = laid_out(made, contacts, ground=belt, keep=True)
    for point in (HEEL, TOE, ANKLE, TIP):
        assert np.allclose(loose[point].slip[:, 30:59], [[0.002], [0.0], [0.0]])
        assert np.allclose(tight[point].slip[:, 30:59], [[0.001], [0.0], [0.0005]])
        assert np.allclose(tight[point].hold, loose[point].hold)


def test_a_leg_that_cannot_turn_is_not_held() -> None:
    made = still()
    made = replace(made, legs=tuple(replace(leg, turns=False) for leg in made.legs))
    contacts = contacts_of(made, "labels", left_toe=[Contact(30, 60, 1.0, (0.1, 0.0, 0.1), "force")])
    for pin in laid_out(made, contacts)[0]:
        assert not pin.hold.any() and not pin.draw.any() and not pin.placed.any()


# ---- heights ----------------------------------------------------------------------------------------


def test_a_toe_joint_stands_as_high_over_the_floor_as_over_its_sole() -> None:
    made = still()
    rig = replace(made.rig, floor=0.25)
    for e, sole in enumerate(rig.soles):
        over = float(np.linalg.norm(sole.offset)) if sole.part == "toe" else 0.0
        assert nominal(rig, e) == pytest.approx(0.25 + over)
    bare = figure("no toes")
    for e in range(4):
        assert nominal(bare.rig, e) == bare.rig.floor


def test_plants_lack_what_the_figure_is_sunk() -> None:
    made = moved(still(), np.tile([0.0, -0.03, 0.0], (FRAMES, 1)))
    contacts = contacts_of(made, **{name: [Contact(0, FRAMES)] for name in made.contacts.names})
    plants, _ = footplants(contacts, made.rig, made.legs, PARAMS.asked)
    assert np.allclose(lacks(plants, made.legs, made.rig), 0.03, atol=1e-3)


def test_feet_on_the_floor_share_its_usual_height_and_those_on_a_step_have_their_own() -> None:
    made = still()
    up = np.zeros((FRAMES, 3))
    up[:40, 1], up[40:80, 1], up[80:, 1] = 0.004, 0.010, 0.20  # [m]
    made = moved(made, up)
    spans = [Contact(0, 30), Contact(40, 80), Contact(90, 110)]
    contacts = contacts_of(made, left_toe=spans, right_toe=[Contact(0, 30)])
    plants, _ = footplants(contacts, made.rig, made.legs, PARAMS.asked)
    found = floors(plants, made.legs, made.rig, PARAMS.near * made.rig.leg_length)
    base = float(made.legs[0].place(TOE)[1, 0]) - 0.004
    assert found.rest[1] == pytest.approx(base + 0.010)  # 40 frames against 30
    assert found.plants[:3] == pytest.approx((base + 0.010, base + 0.010, base + 0.20))
    assert found.plants[3] == pytest.approx(found.rest[3]) == pytest.approx(base + 0.004, abs=1e-6)
    assert found.rest[0] == nominal(made.rig, 0)  # no plant: what is known of the sole

    left, _ = laid_out(made, contacts)
    toe = left[TOE]
    own = made.legs[0].place(TOE)[1]
    assert np.allclose(toe.level[:30], base + 0.010) and np.allclose(toe.level[90:110], base + 0.20)
    assert np.allclose(toe.level[30:40], own[30:40])
    # the floor: below the step it is the step's, between plants the lower of the two
    sink = PARAMS.sink * made.rig.leg_length
    step = np.zeros(FRAMES)
    step[90:] = 0.19
    assert np.allclose(toe.lowest, np.minimum(own, base + 0.010 + step - sink))
    assert np.allclose(left[HEEL].lowest, np.minimum(made.legs[0].place(HEEL)[1], found.rest[0] + step - sink))


def test_nothing_has_to_be_higher_than_it_was_captured() -> None:
    made = moved(still(), np.tile([0.0, -0.02, 0.0], (FRAMES, 1)))
    contacts = contacts_of(made, left_toe=[Contact(50, 60)])
    found, _ = laid_out(made, contacts)
    for point in (HEEL, TOE, TIP):
        assert np.all(found[point].lowest <= made.legs[0].place(point)[1])
    assert np.all(found[ANKLE].lowest == -np.inf)


def test_longer_contacts_are_drawn_to_their_floor_as_much_on_the_whole() -> None:
    made = still()
    contacts = contacts_of(made, left_toe=[Contact(0, 6), Contact(10, 16), Contact(30, 90)])
    draw = laid_out(made, contacts)[0][TOE].draw
    dt = made.clip.frame_time
    for start, end in ((0, 6), (30, 90)):
        assert np.allclose(draw[start:end], 1.0 / max(1.0, 10.0 * (end - start) * dt))
        assert draw[start:end].sum() * dt == pytest.approx(0.1)  # [s]
    assert not draw[6:10].any() and not draw[90:].any()
    held, _ = laid_out(made, contacts, heights=False)
    assert not any(pin.draw.any() for pin in held)
    found, _ = laid_out(made, contacts)
    assert not found[TIP].draw.any() and not found[ANKLE].draw.any()


@pytest.mark.parametrize("up", [-0.03, 0.0, 0.03])
def test_toes_that_stand_may_rise_as_far_as_captured_or_as_in_a_flat_foot(up: float) -> None:
    """Toes bent up or down in a plant of the toes alone, by `up` [m] at their tip, after one of the whole foot."""
    made = still()
    leg = made.legs[0]
    usual, bent = leg.points[2], leg.points[2].copy()
    bent[1, 60:90] += up
    made = replace(made, legs=(replace(leg, points=(*leg.points[:2], bent)), *made.legs[1:]))
    whole, toes = Contact(10, 50), Contact(60, 90)
    rise = laid_out(made, contacts_of(made, left_heel=[whole], left_toe=[whole, toes]))[0][TIP].rise
    assert rise is not None
    assert np.allclose(rise[10:50], usual[1, 10:50]) and np.allclose(rise[60:90], usual[1, 60:90] + max(up, 0.0))
    assert np.isinf(rise[50:60]).all() and np.isinf(rise[90:]).all()
    stiff = replace(made, legs=tuple(replace(each, bends=False) for each in made.legs))
    assert laid_out(stiff, contacts_of(stiff, left_toe=[toes]))[0][TIP].rise is None


def test_a_place_that_is_asked_for_is_where_the_joint_goes() -> None:
    made = still()
    sole = np.array(made.legs[0].place(TOE)[:, 0]) + [0.03, 0.0, -0.02]
    sole[1] = made.rig.floor
    contacts = contacts_of(made, left_toe=[Contact(30, 60, 1.0, tuple(sole.tolist())), Contact(70, 80)])
    toe = laid_out(made, contacts)[0][TOE]
    rest = float(made.legs[0].place(TOE)[1, 0])
    assert np.allclose(toe.place[:, 30:60].T, [sole[0], rest, sole[2]])
    assert np.flatnonzero(toe.placed).tolist() == list(range(30, 60)) and toe.placed[30] == 1.0
    assert not toe.draw[30:60].any() and toe.draw[75] > 0.0
    forced = contacts_of(made, left_toe=[Contact(30, 60, 1.0, tuple(sole.tolist()), "force")])
    assert laid_out(made, forced)[0][TOE].placed[40] == 100.0


# ---- what stands well enough ------------------------------------------------------------------------


def kept_of(made: Figure, contacts: Contacts, *, heights: bool = True, ground: Floats | None = None) -> list[bool]:
    rig = made.rig
    plants, _ = footplants(contacts, rig, made.legs, PARAMS.asked)
    level = floors(plants, made.legs, rig, PARAMS.near * rig.leg_length)
    moves = np.zeros((len(made.clip), 3)) if ground is None else ground
    return list(kept(
        plants, made.legs, moves, level, made.clip.frame_time, rig.leg_length, heights=heights, params=PARAMS
    ))  # fmt: skip


def swayed(made: Figure, size: float) -> Figure:
    """The figure goes to and fro, `size` [m] to either side of where it mostly is, never at rest."""
    t = np.arange(FRAMES) * made.clip.frame_time
    return moved(made, size * np.sin(2.0 * np.pi * 2.1 * t)[:, None] * [0.6, 0.0, 0.8])


def test_what_slides_within_the_tolerance_is_kept() -> None:
    contact = [Contact(0, FRAMES, 0.9)]
    tolerance = PARAMS.keep_slide * still().rig.leg_length
    for share, keep in ((0.8, True), (1.3, False)):
        made = swayed(still(), share * tolerance)
        assert kept_of(made, contacts_of(made, left_heel=contact, right_toe=contact)) == [keep, keep]


def test_what_is_off_its_floor_is_not_kept_unless_heights_are() -> None:
    made = swayed(still(), 0.0005)
    tolerance = PARAMS.keep_height * made.rig.leg_length
    for off, keep in ((0.8 * tolerance, True), (1.3 * tolerance, False)):
        up = np.zeros((FRAMES, 3))
        up[:30, 1] = off
        lifted = moved(made, up)
        contacts = contacts_of(lifted, left_toe=[Contact(0, 30, 0.9), Contact(30, FRAMES, 0.9)])
        assert kept_of(lifted, contacts) == [keep, True]
        assert kept_of(lifted, contacts, heights=False) == [True, True]


def test_what_a_program_has_put_to_rest_is_kept_whatever_the_rest_of_it_does() -> None:
    """A third of its frames at rest to the digit, as no captured foot is; the others slide by 3 cm."""
    for still_frames, keep in ((60, True), (10, False)):
        shift = np.zeros((FRAMES, 3))
        shift[still_frames:, 0] = np.linspace(0.0, 0.03, FRAMES - still_frames)
        made = moved(still(), shift)
        contacts = contacts_of(made, left_toe=[Contact(0, FRAMES, 0.9)])
        assert kept_of(made, contacts) == [keep]


def test_what_hardly_strays_over_a_whole_plant_was_put_to_rest_at_whatever_height() -> None:
    up = np.zeros((FRAMES, 3))
    up[:30, 1] = 1.6 * PARAMS.keep_height * still().rig.leg_length
    for size, keep in ((0.2, True), (0.8, False)):  # [mm]
        made = moved(swayed(still(), 0.001 * size), up)
        contacts = contacts_of(made, left_toe=[Contact(0, 30, 0.9), Contact(30, FRAMES, 0.9)])
        assert kept_of(made, contacts) == [keep, True]


def test_frames_written_twice_are_not_rest() -> None:
    """60 Hz motion written at 120: every second step is none."""
    t = np.arange(FRAMES) // 2
    made = moved(still(), 0.03 * (t / t.max())[:, None] * [1.0, 0.0, 0.0])
    assert kept_of(made, contacts_of(made, left_toe=[Contact(0, FRAMES, 0.9)])) == [False]


def test_on_a_belt_what_goes_along_is_kept() -> None:
    belt = np.arange(FRAMES)[:, None] * np.array([0.01, 0.0, 0.0])
    made = moved(still(), belt)
    contacts = contacts_of(made, left_toe=[Contact(10, 90, 0.9)])
    assert kept_of(made, contacts) == [False]
    assert kept_of(made, contacts, ground=belt) == [True]


def test_where_a_foot_lands_and_leaves_is_not_looked_at() -> None:
    """A plant whose outermost frames slide by a centimetre and whose others stand stands."""
    for slides, keep in ((1, True), (20, False)):
        shift = np.zeros((FRAMES, 3))
        shift[30 : 30 + slides, 0] = 0.01
        shift[:30, 0] = 0.02
        t = np.arange(FRAMES) * 2.0
        made = moved(still(), shift + 0.0006 * np.sin(t)[:, None] * [1.0, 0.0, 0.0])
        assert kept_of(made, contacts_of(made, left_toe=[Contact(30, 70, 0.9)])) == [keep]


def test_contacts_of_a_few_frames_are_left_as_they_are_unless_forced() -> None:
    shift = np.zeros((FRAMES, 3))
    shift[:, 0] = 0.02 * np.arange(FRAMES)
    made = moved(still(), shift)
    spans = [Contact(5, 7, 0.9), Contact(20, 22, 0.9, wish="force"), Contact(40, 60, 0.9)]
    assert kept_of(made, contacts_of(made, left_toe=spans)) == [True, False, False]


def test_what_is_let_slide_is_not_drawn_and_has_kinetic_friction_only() -> None:
    made = swayed(still(), 0.02)
    spans = [Contact(10, 40, 0.9), Contact(60, 90, 0.9), Contact(95, 110, 0.9, wish="force")]
    toe = laid_out(made, contacts_of(made, left_toe=spans))[0][TOE]
    assert toe.spans == ((10, 40), (60, 90))  # not what is forced
    less = toe.let_slide([(10, 40)])
    assert np.array_equal(less.hold, toe.hold) and less.spans == ((60, 90),) and less.sliding == ((10, 40),)
    assert not less.draw[:60].any() and np.array_equal(less.draw[60:], toe.draw[60:])
    assert not less.sticking()[:59].any() and np.array_equal(less.sticking()[59:], toe.hold[59:])
    assert np.array_equal(toe.sticking(), toe.hold) and less.let_slide([(60, 90)]).sliding == ((10, 40), (60, 90))
    assert toe.hold[20] > 0.0 and np.array_equal(less.stands, toe.stands)
    assert not laid_out(made, contacts_of(made, left_toe=spans), keep=True)[0][TOE].spans
    by_hand = contacts_of(made, "labels", left_toe=[Contact(10, 40)])
    assert not laid_out(made, by_hand)[0][TOE].spans


def test_where_feet_usually_are_below_the_floor_none_is_drawn_there_that_came_in_higher() -> None:
    made = still()
    leg = made.rig.leg_length
    down = np.zeros((FRAMES, 3))
    down[30:, 1] = -0.03 * leg  # most of the time
    lowered = moved(made, down)
    rig = made.rig
    contacts = contacts_of(lowered, left_heel=[Contact(0, 30, 0.9), Contact(30, FRAMES, 0.9)])
    plants, _ = footplants(contacts, rig, lowered.legs, PARAMS.asked)
    found = floors(plants, lowered.legs, rig, PARAMS.near * rig.leg_length)
    heel = next(e for e, sole in enumerate(rig.soles) if sole.name == "left_heel")
    own = [float(np.median(lowered.legs[0].place(HEEL)[1, p.frames])) for p in plants]
    assert found.rest[heel] == pytest.approx(own[1]) and own[1] < nominal(rig, heel) - 0.02 * leg
    assert found.plants == pytest.approx((min(own[0], nominal(rig, heel)), own[1]))
    pin = laid_out(lowered, contacts)[0][HEEL]
    sink = PARAMS.sink * leg
    assert np.all(pin.lowest[:30] >= min(own[0], nominal(rig, heel)) - sink - 1e-9)
    assert np.all(pin.lowest[30:] <= lowered.legs[0].place(HEEL)[1, 30:] + 1e-12)


def test_what_a_plant_lacks_is_told_by_its_median_height() -> None:
    up = np.zeros((FRAMES, 3))
    up[:30, 1], up[30:40, 1] = -0.03, 0.5  # [m] while it leaves
    made = moved(still(), up)
    plants, _ = footplants(contacts_of(made, left_toe=[Contact(0, 40)]), made.rig, made.legs, PARAMS.asked)
    still_lacks = lacks(plants, still().legs, made.rig)
    assert lacks(plants, made.legs, made.rig) == pytest.approx(still_lacks + 0.03)


def test_the_tips_of_toes_rest_at_their_median_height_while_the_foot_is_flat() -> None:
    up = np.zeros((FRAMES, 3))
    up[:30, 1], up[30:40, 1], up[40:, 1] = -0.03, 0.5, 0.2  # [m]
    made, tip = moved(still(), up), float(still().legs[0].place(TIP)[1, 0])
    for spans in ({"left_heel": [Contact(0, 40)], "left_toe": [Contact(0, 60)]}, {"left_toe": [Contact(0, 40)]}):
        plants, _ = footplants(contacts_of(made, **spans), made.rig, made.legs, PARAMS.asked)
        level = floors(plants, made.legs, made.rig, PARAMS.near * made.rig.leg_length)
        assert level.tips[0] == pytest.approx(tip - 0.03)
        assert level.tips[1] == pytest.approx(float(np.median(made.legs[1].place(TIP)[1])))


def test_the_ankle_of_a_foot_without_toe_joint_counts_more_than_its_guessed_sole() -> None:
    made = figure("no toes")
    found, _ = laid_out(made, made.contacts)
    assert made.rig.legs[0].toe is None
    assert found[ANKLE].hold.any() and PARAMS.bare_ankle > 1.0
    assert np.allclose(found[ANKLE].hold, PARAMS.bare_ankle * np.minimum(found[HEEL].hold, found[TOE].hold))


@pytest.mark.parametrize("kind", ["plain", "bare toes"])
def test_as_much_weight_holds_the_toes_as_the_heel_while_both_stand(kind: str) -> None:
    """So a foot that turns is not made to turn about another place than it was captured turning about."""
    made = figure(kind)
    found, _ = laid_out(made, replace(made.contacts, method="auto"))
    heel, toe, ankle, *tips = (pin.hold for pin in found)
    both = (heel > 0.0) & (ankle > 0.0)
    assert both.any() and bool(tips) == (kind == "plain")
    assert np.allclose((toe + sum(tips))[both], (heel + ankle)[both])
