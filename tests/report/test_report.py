"""The report's words, numbers, markup, packing and pictures, without a browser."""

from __future__ import annotations

import dataclasses
import json
import re
import struct
import zlib
from html.parser import HTMLParser
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from report_sample import (
    HOSTILE,
    contacts_document,
    corrected,
    labelled,
    motion,
    report_document,
    rig,
    walker,
    without_toe_joints,
)

from footfix.enforce.footplant import Footplant
from footfix.measure.plants import PlantMeasure
from footfix.measure.skinned_joints import posed, seen_of
from footfix.motion.kinematics import forward
from footfix.report import glyphs
from footfix.report.document import plants as plant_rows
from footfix.report.offenders import worst_plants
from footfix.report.picture import picture
from footfix.report.text import released, summarize
from footfix.report.thumbnail import thumbnail
from footfix.report.verdict import judge, measure_rows
from footfix.report.web import markup
from footfix.report.web.bones import bones_of
from footfix.report.web.index import IndexRow, render_index
from footfix.report.web.motion import SHOWN_FRAMES, Lines, display_frames, film, packed, seen_tracks
from footfix.report.web.pack import pack, quantize, unpack
from footfix.report.web.page import PageData, asset, render

# ---- packing ----------------------------------------------------------------------------------------


@settings(max_examples=20, deadline=None)
@given(st.data())
def test_what_is_packed_comes_back(data: st.DataObject) -> None:
    shape = (data.draw(st.integers(1, 40)), data.draw(st.integers(1, 5)))
    numbers = st.integers(-(1 << 28), 1 << 28) | st.integers(-70, 70)
    steps = np.array(data.draw(st.lists(numbers, min_size=shape[0] * shape[1], max_size=shape[0] * shape[1])), np.int32)
    assert np.array_equal(unpack(pack(steps.reshape(shape)), shape), steps.reshape(shape))


def test_numbers_that_are_none_are_brought_in() -> None:
    steps = quantize(np.array([np.nan, np.inf, -np.inf, 1e30, 0.26]), 0.5)
    assert steps.tolist() == [0, 1 << 28, -(1 << 28), 1 << 28, 1]


def test_a_smooth_motion_needs_a_byte_a_number() -> None:
    t = np.linspace(0.0, 6.0, 720)[:, None]
    steps = quantize(0.5 * np.sin(t * np.arange(1.0, 6.0)), 5e-4)
    assert len(pack(steps)) <= 1.05 * 4 / 3 * steps.size


def test_a_minute_at_120_fps_stays_under_three_megabytes() -> None:
    clip = walker(7200)
    noise = np.random.default_rng(0).normal(0.0, 3e-4, clip.positions.shape)
    clip = dataclasses.replace(clip, positions=clip.positions + noise)
    shown = film(clip, corrected(clip), rig())
    assert shown.step == 1
    size = len(json.dumps(packed(shown, Lines())))
    joints = shown.joints_before.shape[1]
    assert size * 31 / joints < 2.6e6


@pytest.mark.parametrize("frames", [0, 1, 7, SHOWN_FRAMES, SHOWN_FRAMES + 1, 20_000, 432_000])
def test_long_clips_are_shown_evenly(frames: int) -> None:
    shown = display_frames(frames)
    assert len(shown) <= SHOWN_FRAMES
    assert len(np.unique(np.diff(shown))) <= 1
    assert frames < 2 or (shown[0] == 0 and shown[-1] > frames - 1 - (shown[1] - shown[0]))


def test_the_page_gets_the_motion_that_it_was_given() -> None:
    clip = walker(240)
    after = corrected(clip)
    shown = film(clip, after, rig())
    joints = len(clip.skeleton)
    assert np.allclose(shown.joints_after[:, :joints], forward(after).positions)
    data = packed(shown, Lines())
    quantum, total = data["quantum"]["joints"], len(data["parents"])
    rebuilt = quantum * unpack(data["joints"]["before"], (240, total, 3)).astype(float)
    rebuilt += quantum * unpack(data["joints"]["shift"], (240, 1, 3))
    moved = data["joints"]["moved"]
    rebuilt[:, moved] += quantum * unpack(data["joints"]["own"], (240, len(moved), 3))
    assert np.abs(rebuilt - shown.joints_after).max() <= 2.0 * quantum
    assert set(moved) == {3, 4, joints}  # below the knee that was bent: foot, toe and its End Site


def test_speeds_are_those_of_the_whole_clip() -> None:
    clip = walker(3 * SHOWN_FRAMES)
    shown = film(clip, clip, rig())
    for effector, joint in ((0, 3), (1, 4)):  # the ankle of a heel, the joint of a toe
        track = forward(clip).positions[:, joint]
        speed = np.hypot(*(np.gradient(track[:, k], clip.frame_time) for k in (0, 2)))
        assert np.allclose(shown.speeds_before[:, effector], speed[:: shown.step], atol=1e-9)


def test_on_a_belt_ways_and_speeds_are_over_the_belt() -> None:
    """A figure that is carried along by its ground shows the ways and speeds of one on a floor at rest."""
    clip, planted = walker(240), labelled(240)
    ground = np.outer(np.sin(0.02 * np.arange(240)), [0.8, 0.0, -1.5])  # (F, 3) [m]
    positions = clip.positions.copy()
    positions[:, 0] += ground
    carried = dataclasses.replace(clip, positions=positions)
    still, moving = film(clip, clip, rig(), planted), film(carried, carried, rig(), planted, ground)
    assert np.allclose(seen_tracks(moving)[1], seen_tracks(still)[1], atol=1e-9)
    assert np.allclose(moving.speeds_after, still.speeds_after, atol=1e-9)


# ---- words and numbers ------------------------------------------------------------------------------


def _report(slides: list[tuple[float, float]], status: str = "cleaned") -> dict[str, Any]:
    plants = [{"slide_before_mm": before, "slide_after_mm": after} for before, after in slides]
    return {"status": status, "plants": plants}


@pytest.mark.parametrize(
    ("report", "tone", "word", "text"),
    [
        ({"status": "failed"}, "bad", "failed", "could not be worked on"),
        (_report([]), "quiet", "no plants", "No footplants"),
        (_report([(3, 3), (20, 20)], "unchanged"), "good", "fine as it was", "All 2 footplants stand still"),
        (_report([(3, 3), (30, 30)], "unchanged"), "fair", "left alone", "1 of 2 footplants slides more"),
        (_report([(3, 0), (20, 1)]), "good", "tidied", "from 20 to 1 mm"),
        (_report([(40, 0), (20, 1), (50, 2)]), "good", "fixed", "2 of 3 footplants slid more than 21 mm; now none"),
        (_report([(40, 0), (50, 30)]), "fair", "better", "All 2 footplants slid more than 21 mm; 1 still does"),
        (_report([(40, 40), (50, 50)]), "bad", "not helped", "All 2 footplants still slide"),
        (_report([(40, 40), (50, 30)]), "fair", "partly better", "1 of 2 footplants slides less than before; 2 still"),
        (_report([(15, 0)] * 83 + [(40, 40)] * 8), "fair", "partly better", "83 of 91 footplants slide less"),
        (_report([(4, 40)]), "bad", "worse", "The one footplant slides more than 21 mm, none did before"),
        (_report([(4, 40)]), "bad", "worse", "; 1 slides farther than before"),
        (_report([(0.2, 0.1), (0, 0.3)]), "good", "tidied", "No footplant slid noticeably, before or after"),
        (_report([(40, 0), (3, 9), (0, 6)]), "fair", "mixed", "now none does; 2 slide farther than before"),
        (_report([(3, 8)]), "good", "tidied", "from 3 to 8 mm"),
        (_report([(40, 30), (3, 9), (50, 2)]), "fair", "better", "1 still does; 1 slides farther than before"),
    ],
)
def test_the_verdict_says_what_happened(report: dict[str, Any], tone: str, word: str, text: str) -> None:
    verdict = judge(report)
    assert (verdict.tone, verdict.word) == (tone, word)
    assert text in verdict.text


def test_a_measure_that_got_worse_is_marked() -> None:
    rows = {row.label: row for row in measure_rows(report_document(360))}
    assert rows["Jitter"].worse
    assert not rows["Median slide of the plants"].worse


def test_what_was_not_measured_is_a_dash() -> None:
    report = {"before": {"skating_ratio": None, "slide_mm": 3.0}, "after": {"skating_ratio": None, "slide_mm": None}}
    rows = {row.label: (row.before, row.after) for row in measure_rows(report)}
    assert rows == {"Longest slide of a plant": ("3.0", "–"), "Foot skating ratio (GMD, OmniControl)": ("–", "–")}


def test_the_first_screen_names_the_largest_joint_change_and_the_details_the_floor() -> None:
    change = {"largest_change_joint": "RightLeg", "largest_change_deg": 31.4, "largest_change_frame": 75}
    rig = {"floor_m": 0.0124, "origins": {"floor": "the file's zero plane"}}
    report = report_document(360, correction=change, rig=rig)
    lines = summarize(report).split("\n")
    assert "  largest joint change: RightLeg 31 degrees, frame 75" in lines
    assert "  floor at 0.012 m: the file's zero plane" in lines
    html = render(PageData(report))
    first, details = html[: html.index("<main>")], html[html.index("<details") :]
    tile = r"Largest joint change <small>°</small></dt><dd><b>31</b>.*?<bdi>RightLeg</bdi>, .*#f=75.*frame 75"
    assert re.search(tile, first)
    assert re.search(r">floor</th><td>0\.012 m: the file&#39;s zero plane<", details)
    nothing = dict.fromkeys(change)
    assert "joint change" not in summarize(report_document(360, correction=nothing))


def test_the_details_are_words_not_values_of_a_program() -> None:
    rig_entry = {
        "leg_length_m": 0.82,
        "legs": [{"name": "front_left", "toe": None, "chain": ["a", "b"]}],
        "soles": [{"name": "front_left_toe", "offset_m": [0.5, 0.0, -1.0]}],
    }
    enforce = {"speed_m_s": 2.0, "pins": {"on": True, "off": None}}
    report = report_document(360, rig=rig_entry, settings={"enforce": enforce})
    html = render(PageData(report))
    cells = re.findall(r"<th[^>]*>([^<]*)</th><td>([^<]*)</td>", html[html.index("<details") :])
    rows = dict(cells)
    assert rows["legs › front left › chain"] == "a, b"
    assert rows["soles › front left toe › offset"] == "0.5, 0, -1 m"
    assert rows["leg length"] == "0.82 m"
    assert rows["enforce › speed"] == "2 m&#47;s"
    assert rows["enforce › pins › on"] == "yes"
    assert "legs › front left › toe" not in rows and "enforce › pins › off" not in rows
    assert not [value for _, value in cells if re.search(r"[{}\[\]]|None|True|False", value)]


def test_nothing_goes_from_zero_to_zero() -> None:
    plants = [{"slide_before_mm": 0.2, "slide_after_mm": 0.3}]
    still = {"slide_median_mm": 0.0}
    report = {"status": "cleaned", "plants": plants, "before": still, "after": still,
              "correction": {"root_path_drift_m": 0.0}}  # fmt: skip
    html = render(PageData(report))
    first = re.sub(r"<[^>]+>", " ", html[html.index("<body>") : html.index("<main>")])
    assert "Footplants" in first and not re.search(r"\b0(\.0+)?\b", first)
    assert "0 mm" not in judge(report).text and "longest slide" not in summarize(report)


def test_plants_that_stay_though_they_slide_say_why() -> None:
    rows = [
        (40.0, "kept", "4 frames are too few to hold"),
        (3.0, "kept", "3 frames are too few to hold"),
        (30.0, "partly", "at rest in 8 of 9 frames, at frame 3"),
        (30.0, "partly", "at rest in 9 of 12 frames, at frame 8"),
    ]
    plants = [{"slide_after_mm": slide, "outcome": outcome, "reason": reason} for slide, outcome, reason in rows]
    assert released({"plants": plants}) == [
        "2 plants held only in part: at rest in 8-9 of 9-12 frames, at frames 3-8",
        "1 plant left alone: 4 frames are too few to hold",
    ]


def test_a_pinned_sole_whose_joint_slides_says_so() -> None:
    plant = Footplant(0, 0, "left_heel", 0, "heel", 3, 30, outcome="pinned", held=((3, 30),))
    for slide, reason in ((5.0, ""), (47.0, "the heel of the sole is held, the ankle over it moves")):
        now = PlantMeasure("left_heel", 3, 30, slide, None, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
        (row,) = plant_rows([plant], [now], [now])
        assert row["reason"] == reason
    late = dataclasses.replace(plant, residual=0.04)  # [m] in frames that no measure counts
    (row,) = plant_rows([late], [now], [dataclasses.replace(now, slide_mm=1.0)])
    assert row["residual_mm"] == 40.0 and row["reason"] == "off its place only while it lands or leaves"


def test_the_terminal_gets_no_control_characters_and_short_reasons() -> None:
    report = report_document(720, source="walk\x1b[31m\u202e.bvh")
    lines = summarize(report).split("\n")
    assert all(char.isprintable() for line in lines for char in line)
    assert "All 24 footplants slid more than 21 mm; now none does" in lines[0]
    assert "  20 plants held only in part: stays up to 1-5 mm away" in lines
    assert any("jitter 0.50 -> 0.90" in line for line in lines)


# ---- markup -----------------------------------------------------------------------------------------


# Any characters but halves of surrogate pairs, without the table of all characters, which takes a second to make.
TEXT = st.lists(
    st.integers(0, 127) | st.integers(0, 0xD7FF) | st.integers(0xE000, 0x10FFFF), max_size=12
).map(lambda codes: "".join(map(chr, codes)))  # fmt: skip


@settings(max_examples=20, deadline=None)
@given(TEXT | st.sampled_from(HOSTILE))
def test_text_stays_text(value: str) -> None:
    escaped = markup.text(value)
    assert not set(escaped) & set("<>\"'`/\x00")
    escaped.encode("utf-8")


_LEAVES = TEXT | st.integers() | st.booleans() | st.sampled_from(HOSTILE)


@settings(max_examples=15, deadline=None)
@given(st.recursive(_LEAVES, lambda each: st.lists(each) | st.dictionaries(TEXT, each), max_leaves=20))
def test_embedded_json_reads_back_and_ends_nothing(value: object) -> None:
    embedded = markup.embedded_json(value)
    assert json.loads(embedded) == value
    assert embedded.isascii()
    assert not set(embedded) & set("<>&")
    assert "//" not in embedded


class _Outline(HTMLParser):
    """Elements and attributes of a page."""

    def __init__(self) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.attributes: list[tuple[str, str | None]] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.attributes += attrs


def _outline(html: str) -> _Outline:
    outline = _Outline()
    outline.feed(html)
    return outline


def hostile_page(frames: int = 360) -> str:
    return render(PageData(report_document(frames), contacts_document(frames), motion(frames)))


def hostile_index() -> str:
    clip_motion = motion(360)
    offenders = worst_plants(clip_motion, report_document(360))
    rows = [IndexRow(name, name + ".report.html", report_document(360), offenders=offenders) for name in HOSTILE]
    return render_index([*rows, IndexRow("broken.bvh", report={"status": "failed"}, error=HOSTILE[0])])


@pytest.mark.parametrize("make", [hostile_page, hostile_index])
def test_nothing_of_a_stranger_becomes_markup_or_an_address(make: Any) -> None:
    html = make()
    outline = _outline(html)
    assert {"img", "iframe", "object", "link "} & set(outline.tags) == set()
    assert outline.tags.count("script") <= 2
    assert all(not key.startswith("on") and key not in ("style", "src") for key, _ in outline.attributes)
    addresses = [value or "" for key, value in outline.attributes if key in ("href", "action", "data")]
    assert all(value == "data:," or re.fullmatch(r"\./[^:]*|#f=\d+", value) for value in addresses)
    assert not re.search(r"(https?|ftp|wss?)://|//evil", html)
    html.encode("utf-8")


def test_the_policy_names_each_script_and_style() -> None:
    html = hostile_page()
    contents = [value or "" for key, value in _outline(html).attributes if key == "content"]
    policy = next(value for value in contents if "default-src" in value)
    assert policy.startswith("default-src 'none'; script-src 'sha256-")
    assert "unsafe" not in policy


def test_the_page_is_the_same_every_time() -> None:
    assert hostile_page() == hostile_page()


def test_a_page_without_a_figure_still_says_why() -> None:
    notes = [{"severity": "error", "text": "cut short"}]
    html = render(PageData({"status": "failed", "source": "x.bvh", "notes": notes}))
    assert "cut short" in html
    assert "canvas" not in _outline(html).tags


def test_the_still_picture_stands_in_where_no_script_runs() -> None:
    html = hostile_page()
    still = html[html.index("<noscript>") : html.index("</noscript>")]
    assert [line.count("M") for line in re.findall(r'class="bars \w+" d="([^"]+)"', still)] == [3, 3, 3, 3]


def test_the_index_puts_the_worst_first_and_what_failed_on_top() -> None:
    rows = [IndexRow(f"{after}.bvh", f"{after}.html", _report([(50, after)])) for after in (3, 45, 22)]
    html = render_index([*rows, IndexRow("broken.bvh", report={"status": "failed"}, error="no legs")])
    body = html[html.index("<tbody>") :]
    order = re.findall(r"<bdi>([^<]+)</bdi>", body)
    assert order == ["broken.bvh", "45.bvh", "22.bvh", "3.bvh"]


def test_what_failed_shows_no_zeros_and_its_error_no_path() -> None:
    row = IndexRow("b/broken.bvh", report={"status": "failed"}, error="/some/where/b/broken.bvh:3:1: no legs")
    html = render_index([row, IndexRow("a.bvh", "a.html", _report([(50, 45)]))])
    broken = next(each for each in re.findall(r"<tr>.*?</tr>", html, re.S) if "broken" in each)
    cells = re.findall(r"<td[^>]*>(.*?)</td>", broken, re.S)
    assert not [cell for cell in cells if re.fullmatch(r"0(\.0*)?", cell)]
    assert "<td>–</td>" in broken and "no legs" in broken and "where" not in broken


def test_the_index_names_the_largest_joint_change_and_counts_what_came_worse() -> None:
    def change(joint: str, degrees: float) -> dict[str, Any]:
        return {"correction": {"largest_change_joint": joint, "largest_change_deg": degrees, "largest_change_frame": 7}}

    rows = [
        IndexRow("a.bvh", "a.html", {**_report([(50, 1)]), **change("Knee", 40.0)}),
        IndexRow("b.bvh", "b.html", {**_report([(5, 15), (50, 1)]), **change("Hip", 12.0)}),
    ]
    html = render_index(rows)
    first = html[html.index("<body>") : html.index("<main")]
    assert re.search(r"Clips that got worse</dt><dd><b>1</b>", first)
    assert re.search(r'joint change <small>°</small></dt><dd><b>40</b>.*?a\.html#f=7".*?Knee.*?frame 7', first)


# ---- what is drawn of a figure ----------------------------------------------------------------------


def test_a_root_that_stays_behind_is_no_pole() -> None:
    """A root at the origin, a target that hangs on it, and a figure that walks away: only its bones are drawn."""
    parents = (-1, 0, 1, 1, 2, 0)  # root, hips, two thighs, a shank, a target
    places = np.zeros((50, 6, 3))
    places[:, 1:5] = [[0, 1, 0], [0.1, 1, 0], [-0.1, 1, 0], [0.1, 0.5, 0]]
    places[:, 1:, 2] += np.linspace(0.0, 4.0, 50)[:, None]
    assert bones_of((-1, 0, 1, 1, 2), 5, places[:, :5]) == ((1, 2), (1, 3), (2, 4))  # hips are all that hangs on it
    assert bones_of(parents, 6, places) == ((1, 2), (1, 3), (2, 4))  # the lines to hips and target grow
    still = places.copy()
    still[..., 2] = 0.0
    assert bones_of((-1, 0, 1, 1, 2), 5, still[:, :5]) == ((1, 2), (1, 3), (2, 4))  # a pole below hips that stay
    assert bones_of((-1, 0, 1), 3, places[:, :3]) == ((0, 1), (1, 2))[1:]  # a chain alone keeps what does not grow


@pytest.mark.parametrize("bare", [False, True])
def test_the_way_of_a_plant_is_that_of_its_joint(bare: bool) -> None:
    """What the small picture draws is what the measures look at, before and after."""
    clip, planted, known = walker(360), labelled(360), without_toe_joints() if bare else rig()
    after = corrected(clip)
    report = report_document(360)
    shown = film(clip, after, known, planted)
    assert len(shown.bones) == len(film(clip, after, rig(), planted).bones)
    for offender in worst_plants(shown, report, 12):
        k = shown.sole_names.index(offender.effector)
        seen = [seen_of(each, known, planted, posed(each, known), np.zeros((360, 3)))[k] for each in (clip, after)]
        for track, way in zip(seen, (offender.path_before, offender.path_after), strict=True):
            ends = track.track[[offender.start + 1, offender.end - 2]][:, [0, 2]]
            drawn = np.array([way[0], way[-1]])
            assert drawn[1] - drawn[0] == pytest.approx(1000.0 * (ends[1] - ends[0]), abs=0.2)
        assert offender.start <= offender.frame < offender.end


def test_a_small_figure_fills_its_drawing_and_knows_its_legs() -> None:
    shown = motion(120)
    layers = thumbnail(shown, 60)
    places = [np.array(re.findall(r"(-?\d+) (-?\d+)", layer), dtype=float) for layer in layers]
    assert [len(each) > 2 for each in places] == [True] * 4
    every = np.concatenate(places)
    assert every.min() >= 0 and every.max() <= 100 and np.ptp(every, axis=0).max() >= 85
    assert np.median(places[2][:, 1]) > np.median(places[1][:, 1])  # legs are below the rest: y points downwards


# ---- looks ------------------------------------------------------------------------------------------


def _variables(css: str) -> dict[str, str]:
    return dict(re.findall(r"--([\w-]+): (#[0-9a-f]{6})", css))


def _luminance(code: str) -> float:
    channels = np.array([int(code[k : k + 2], 16) for k in (1, 3, 5)]) / 255.0
    linear = np.where(channels <= 0.04045, channels / 12.92, ((channels + 0.055) / 1.055) ** 2.4)
    return float(linear @ (0.2126, 0.7152, 0.0722))


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_words_stand_out_from_their_ground(scheme: str) -> None:
    """WCAG 2.2, 1.4.3: text at least 4.5 to 1."""
    light, dark = asset("report.css").split("@media (prefers-color-scheme: dark)", 1)
    values = _variables(light) | (_variables(dark.split("}", 1)[0]) if scheme == "dark" else {})
    for ground in ("paper", "card", "stage"):
        for ink in ("ink", "muted", "left", "right", "good", "fair", "bad", "was"):
            bright, dim = sorted((_luminance(values[ground]), _luminance(values[ink])), reverse=True)
            assert (bright + 0.05) / (dim + 0.05) >= 4.5, (scheme, ground, ink)


# ---- the still picture as a PNG ---------------------------------------------------------------------


def _pixels(png: bytes) -> np.ndarray[Any, np.dtype[np.uint8]]:
    """A reader of our own for 8-bit RGB without filters: checks every chunk on the way."""
    assert png[:8] == b"\x89PNG\r\n\x1a\n"
    at, chunks = 8, {}
    while at < len(png):
        (length,) = struct.unpack(">I", png[at : at + 4])
        kind, data = png[at + 4 : at + 8], png[at + 8 : at + 8 + length]
        assert struct.unpack(">I", png[at + 8 + length : at + 12 + length]) == (zlib.crc32(kind + data),)
        chunks[kind] = data
        at += 12 + length
    width, height = struct.unpack(">II", chunks[b"IHDR"][:8])
    rows = np.frombuffer(zlib.decompress(chunks[b"IDAT"]), np.uint8).reshape(height, 1 + 3 * width)
    assert not rows[:, 0].any()
    return rows[:, 1:].reshape(height, width, 3)


def test_the_picture_is_a_png_with_something_on_it() -> None:
    pixels = _pixels(picture(motion(360), report_document(360)))
    ground = pixels[0, 0]
    drawn = np.any(pixels != ground, axis=2)
    assert 0.005 < drawn.mean() < 0.5
    for k in range(4):  # a panel for each of the worst plants, with both ways in it
        panel = pixels[97:315, 17 + k * 236 : 235 + k * 236].astype(int)
        purple = (panel[..., 2] > panel[..., 1] + 40) & (panel[..., 0] > panel[..., 1] + 20)
        assert purple.any()


def test_a_picture_without_a_figure_shows_the_verdict() -> None:
    assert _pixels(picture(None, {"status": "failed", "source": HOSTILE[3]})).shape[0] < 120


def test_every_character_of_ours_has_a_glyph() -> None:
    used = "".join(map(chr, range(33, 127))).replace("$", "").replace("`", "") + "–°→"
    assert all(glyphs.glyph(char) != glyphs.glyph("\0") for char in used)
    assert glyphs.width("mm") == pytest.approx(2 * glyphs.advance("m"))


# ---- reports of strangers ---------------------------------------------------------------------------

_JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | TEXT | st.sampled_from(HOSTILE),
    lambda each: st.lists(each, max_size=3) | st.dictionaries(TEXT, each, max_size=3),
    max_leaves=8,
)
_PLANT_KEYS = ("effector", "start", "end", "slide_before_mm", "slide_after_mm", "residual_mm", "outcome", "reason")
_CHANGE_KEYS = ("root_path_drift_m", "largest_change_joint", "largest_change_deg", "largest_change_frame")
_NOTE_KEYS = ("severity", "text", "joints", "start", "end", "line")


@settings(max_examples=8, deadline=None)
@given(st.data())
def test_a_report_of_any_shape_is_shown_as_far_as_it_goes(data: st.DataObject) -> None:
    report = data.draw(st.fixed_dictionaries({}, optional=dict.fromkeys(report_document(4), _JSON)))
    if data.draw(st.booleans()):
        rows = {"plants": _PLANT_KEYS, "notes": _NOTE_KEYS}
        report |= {
            key: data.draw(st.lists(st.fixed_dictionaries({}, optional=dict.fromkeys(names, _JSON)), max_size=3))
            for key, names in rows.items()
        }
        report["correction"] = data.draw(st.fixed_dictionaries({}, optional=dict.fromkeys(_CHANGE_KEYS, _JSON)))
    outline = _outline(render(PageData(report)))
    assert "script" not in outline.tags
    summarize(report, verbose=True)
    picture(None, report)
    render_index([IndexRow("x", report=report)])
