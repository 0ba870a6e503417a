"""The pages in a real browser: they draw, play, scrub, edit and hand out, and complain of nothing."""

from __future__ import annotations

import dataclasses
import json
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import exports
import numpy as np
import pytest
from chromium_driver import Browser, Page
from report_sample import HOSTILE, contacts_document, corrected, labelled, motion, report_document, rig, walker
from walker import make
from walker_gaits import Gait

from footfix.formats import contacts as labels_format
from footfix.jobs.loop import loop_file
from footfix.locomotion.loop.params import LoopParams
from footfix.measure.skinned_joints import posed, seen_of
from footfix.motion.contacts import Contact
from footfix.report.offenders import worst_plants
from footfix.report.web.index import IndexRow, render_index
from footfix.report.web.motion import film
from footfix.report.web.pack import pack, quantize
from footfix.report.web.page import PageData, asset, render
from footfix.settings import Settings

pytestmark = pytest.mark.browser

FRAMES = 720
SHIFT, CTRL = 8, 2


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    browser = Browser(tmp_path_factory.mktemp("profile"))
    yield browser
    browser.close()


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A report of a clip whose names come from a stranger, and an index that links it."""
    folder = tmp_path_factory.mktemp("pages")
    report, shown = report_document(FRAMES), motion(FRAMES)
    page = render(PageData(report, contacts_document(FRAMES), shown))
    assert len(page) < 3e6
    (folder / "clip #1.html").write_text(page, encoding="utf-8", newline="")
    rows = [
        IndexRow("a/walk.bvh", "clip #1.html", report, offenders=worst_plants(shown, report)),
        IndexRow(HOSTILE[0], "clip #1.html", report_document(FRAMES, status="unchanged")),
        IndexRow("b/broken.bvh", report={"status": "failed"}, error="no legs"),
    ]
    (folder / "index.html").write_text(render_index(rows), encoding="utf-8", newline="")
    return folder


@pytest.fixture
def page(browser: Browser, folder: Path) -> Iterator[Page]:
    """The report, freshly opened; at the end it must not have complained or asked for anything."""
    page = browser.open(folder / "clip #1.html")
    page.settle()
    yield page
    complains_of_nothing(page)


@pytest.fixture
def used(browser: Browser, folder: Path) -> Iterator[Page]:
    """The report as the test before left it, for what is true of it in any state; opening it takes longest of all."""
    page = browser.page
    if page is None or page.run("location.pathname.endsWith('/clip%20%231.html') && innerWidth") != 1366:
        page = browser.open(folder / "clip #1.html")
        page.settle()
    yield page
    complains_of_nothing(page)


def complains_of_nothing(page: Page) -> None:
    """Neither errors nor warnings, nothing asked for, and no script of a name was run."""
    assert page.complaints == []
    assert page.requests == []
    assert page.run("globalThis.pwned") is None


def frame(page: Page) -> int:
    return int(page.run("document.querySelector('#time').textContent.match(/frame (\\d+) of/)[1]"))


def inks(page: Page, canvas: str) -> int:
    """How many different colours a canvas shows."""
    return int(
        page.run(
            f"const c = document.querySelector('{canvas}');"
            "const d = new Uint32Array(c.getContext('2d').getImageData(0, 0, c.width, c.height).data.buffer);"
            "new Set(d).size"
        )
    )


def test_it_opens_within_the_worst_plant_all_drawn_and_nothing_injected(page: Page) -> None:
    for canvas in ("#stage", "#timeline", "#paths", "#drift"):
        assert inks(page, canvas) > 10, canvas
    assert page.run("document.querySelectorAll('img, iframe, object, noscript p').length") == 0
    assert page.run("document.title").startswith(HOSTILE[1][:20])
    assert HOSTILE[0] in page.run("document.querySelector('.notes').textContent")
    row = page.run("({...document.querySelector('#plants tbody tr').dataset})")
    assert page.run("document.querySelector('#plants tr.chosen') === document.querySelector('#plants tbody tr')")
    assert frame(page) == (int(row["start"]) + int(row["end"])) // 2
    assert page.run("document.querySelector('#loop').getAttribute('aria-pressed')") == "false"


def test_it_plays_pauses_and_steps(used: Page) -> None:
    used.key("Home")
    assert frame(used) == 0
    used.click("#play")
    used.wait("Number(document.querySelector('#scrub').value) > 3")
    used.click("#play")
    stopped = frame(used)
    time.sleep(0.1)
    assert frame(used) == stopped
    used.run("document.activeElement.blur()")
    used.key("ArrowRight")
    assert frame(used) == stopped + 1
    used.key("ArrowLeft", SHIFT)
    assert frame(used) == max(0, stopped - 9)
    used.key("End")
    assert frame(used) == FRAMES - 1
    used.run("const s = document.querySelector('#scrub'); s.value = 345; s.dispatchEvent(new Event('input'))")
    used.settle()
    assert frame(used) == 345


def test_the_view_turns_by_mouse_and_by_keys(used: Page) -> None:
    seen = [used.run("document.querySelector('#stage').toDataURL()")]

    def changed() -> bool:
        seen.append(used.run("document.querySelector('#stage').toDataURL()"))
        return bool(seen[-1] != seen[-2])

    left, top, width, height = used.box("#stage")
    middle = (left + width / 2, top + height / 2)
    for modifiers in (0, SHIFT):
        used.drag([middle, (middle[0] + 40, middle[1] + 15)], modifiers)
        assert changed()
    used.run("document.querySelector('#stage').focus()")
    at = frame(used)
    for key in ("ArrowLeft", "ArrowUp", "+", "-", "1", "2", "3", "b"):
        used.key(key)
        assert changed(), key
    assert frame(used) == at


def test_fingers_turn_zoom_and_scrub(browser: Browser, folder: Path) -> None:
    page = browser.open(folder / "clip #1.html", width=390, height=844, touch=True)
    left, top, width, height = page.box("#stage")
    x, y = left + width / 2, top + height / 2
    seen = [page.run("document.querySelector('#stage').toDataURL()")]
    one = [(x, y), (x + 60, y + 5)]
    two = [[(x, y), (x - 5, y), (x - 40, y)], [(x + 30, y), (x + 40, y), (x + 90, y)]]
    for fingers in ([one], two):
        page.touch(*fingers)
        seen.append(page.run("document.querySelector('#stage').toDataURL()"))
    assert len(set(seen)) == 3
    left, top, width, _ = page.box("#timeline")
    start, end = left + 78, left + width - 12
    page.touch([(start + 5, top + 60), (start + 20, top + 60), ((start + end) / 2, top + 60)])
    assert abs(frame(page) - FRAMES / 2) < 3
    assert page.complaints == []


def test_a_plant_of_the_table_is_shown_in_a_loop(page: Page) -> None:
    page.click("#plants thead th:nth-child(2) button")
    starts = page.run("[...document.querySelectorAll('#plants tbody tr')].map(row => Number(row.dataset.start))")
    assert starts == sorted(starts, reverse=True)
    page.click("#plants thead th:nth-child(2) button")
    page.click("#plants tbody tr:nth-child(5) th button")
    start, end = (int(page.run(f"document.querySelector('tr.chosen').dataset.{key}")) for key in ("start", "end"))
    assert (start, end) == (140, 190)
    assert page.run("document.querySelector('#loop').getAttribute('aria-pressed')") == "true"
    for _ in range(20):
        page.settle()
        assert start - 20 <= frame(page) <= end + 20
    page.key("Escape")
    assert page.run("document.querySelector('#loop').getAttribute('aria-pressed')") == "false"


def test_an_address_names_a_frame(page: Page) -> None:
    page.run("const s = document.querySelector('#scrub'); s.value = 345; s.dispatchEvent(new Event('input'))")
    page.settle()
    link = page.run("document.querySelector('#time').href")
    assert link.endswith("#f=345")
    page.key("Home")
    page.run(f"location.href = {json.dumps(link)}")
    page.settle()
    assert frame(page) == 345
    page.click(".tiles .where a")  # the largest change of a joint
    assert frame(page) == 75
    page.call("Page.navigate", {"url": link.replace("#f=345", "?again#f=290")})
    page.wait("location.search === '?again' && document.readyState === 'complete'")
    page.settle()
    assert frame(page) == 290
    assert page.run("document.querySelector('#plants tr.chosen').dataset.start") == "260"


def test_the_figure_is_shown_before_after_both_and_side_by_side(used: Page) -> None:
    seen = {}
    for which in ("before", "both", "after", "beside"):
        used.click(f'[data-figures="{which}"]')
        assert used.run("document.querySelectorAll('[data-figures][aria-pressed=true]').length") == 1
        seen[which] = used.run("document.querySelector('#stage').toDataURL()")
    assert len(set(seen.values())) == 4
    used.run("document.activeElement.blur()")
    for which in ("both", "after", "before", "beside"):
        used.key("b")
        assert used.run("document.querySelector('#stage').toDataURL()") == seen[which], which


_PARTS = ("codec.js", "canvas.js", "words.js", "player.js", "loop_playback.js", "camera.js", "figure.js",
          "measured_points.js", "floor.js", "stage.js", "contacts.js", "knees.js")  # fmt: skip
_LOADED = """
const data = JSON.parse(document.getElementById("data").textContent);
const motion = readMotion(data.motion);
const contacts = new Contacts(data.contacts, motion.frames, data.plants);
"""


def inside(page: Page, script: str) -> Any:
    """The value of a script that works on the page's own parts."""
    return page.run("{" + "\n".join(map(asset, _PARTS)) + _LOADED + script + "}")


def test_a_plant_that_is_looked_at_has_its_whole_leg_in_view(used: Page) -> None:
    found = inside(used, """
        const stage = new Stage(document.querySelector("#stage"), motion, new Player(motion), contacts);
        const outside = [];
        for (const [width, height] of [[780, 400], [360, 300], [700, 600]]) {
          contacts.lanes.forEach((lane, k) => lane.forEach(({ start, end }) => {
            stage.frame(stage.legBall(k, start, end));
            stage.camera.target = stage.closeUp.target;
            stage.camera.aim(width, height);
            const leg = motion.legs.find((each) => contacts.effectors[k].name.startsWith(each[3]));
            for (let i = start; i < end; i++) for (const joint of leg.slice(0, 3)) {
              const at = (i * motion.parents.length + joint) * 3;
              const [x, y] = stage.camera.project(...motion.joints.after.slice(at, at + 3));
              if (x < 0 || y < 0 || x > width || y > height) outside.push([width, k, i, joint, x, y]);
            }
          }));
        }
        outside.slice(0, 3)""")  # fmt: skip
    assert found == []


def test_what_is_looked_at_is_what_the_measures_look_at(browser: Browser, tmp_path: Path) -> None:
    """Heels and toes that stand at other times: the page finds the same frames and joints as the measures."""
    spans = {"left_heel": [(10, 60), (100, 104), (150, 170)], "left_toe": [(30, 90), (101, 140), (168, 200)],
             "right_heel": [(0, 40)], "right_toe": []}  # fmt: skip
    clip, blank = walker(240), rig().no_contacts(walker(240))
    contacts = {name: tuple(Contact(*span) for span in own) for name, own in spans.items()}
    effectors = tuple(dataclasses.replace(each, contacts=contacts[each.name]) for each in blank.effectors)
    planted = dataclasses.replace(blank, effectors=effectors)
    document = contacts_document(240)
    for each in document["effectors"]:
        each["contacts"] = [{"start": a, "end": b} for a, b in spans[each["name"]]]
    shown = film(clip, corrected(clip), rig(), planted)
    path = tmp_path / "page.html"
    path.write_text(render(PageData(report_document(240), document, shown)), encoding="utf-8", newline="")
    page = browser.open(path)
    got = inside(page, """
        const seen = new Seen(motion, contacts);
        contacts.lanes.map((lane, k) => lane.map((contact) => [
          seen.of(k, contact).spans.flatMap(([a, b]) => Array.from({ length: b - a }, (_, j) => a + j)),
          seen.way("after", k, contact).map(([x, , z]) => [x, z]),
        ]))""")  # fmt: skip
    after = corrected(clip)
    for k, want in enumerate(seen_of(after, rig(), planted, posed(after, rig()), np.zeros((240, 3)))):
        if not len(want.plants):
            assert got[k] == []
            continue
        for n, (frames, way) in enumerate(got[k]):
            own = want.parts.frames[want.parts.owner == n]
            assert frames == own.tolist()
            assert np.abs(np.array(way) - want.track[own][:, [0, 2]]).max() < 2e-3


def test_the_knees_change_by_what_they_were_bent(used: Page) -> None:
    """`corrected` bends the left knee by 0.1 + 0.1 sin t more than straight, and the right one not at all."""
    found = "kneeRows(motion).map(({ name, legs }) => ({ name, legs: legs.map((leg) => [...leg.change]) }))"
    (row,) = inside(used, found)
    t = np.arange(FRAMES) / 120.0
    left, right = np.array(row["legs"])
    assert row["name"] == "knees"
    assert np.abs(left - np.degrees(0.1 + 0.1 * np.sin(t))).max() < 0.4  # places are kept to half a millimetre
    assert np.abs(right).max() < 0.4


def test_the_timeline_tells_values_and_jumps(used: Page) -> None:
    left, top, width, _ = used.box("#timeline")
    x = left + 96 + (width - 108) * 45 / FRAMES
    used.hover(x, top + 24 + 30)
    readout = used.run("document.querySelector('#readout').textContent")
    assert readout.startswith("Frame 45, 0.38 s: left heel planted 20–70, forced, pinned, slides 30 → 0 mm. Height ")
    track = rig().tracks(rig().pose(walker(FRAMES)))[0]
    assert f"{100 * (track[45, 1] - 0.01):.1f} →" in readout
    used.drag([(x, top + 60), (x + (width - 108) * 100 / FRAMES, top + 60)])
    assert frame(used) == 145


def download(page: Page, browser: Browser, folder: Path) -> tuple[str, bytes]:
    browser.call("Browser.setDownloadBehavior", {"behavior": "allow", "downloadPath": str(folder)})
    page.click('[data-edit="download"]')
    deadline = time.monotonic() + 30.0
    while time.monotonic() < deadline:
        files = [path for path in folder.iterdir() if not path.name.endswith(".crdownload")]
        if files and files[0].stat().st_size:
            return files[0].name, files[0].read_bytes()
        time.sleep(0.02)
    raise TimeoutError("nothing was downloaded")


def test_contacts_are_handed_out_as_they_were_edited_and_undone(page: Page, browser: Browser, tmp_path: Path) -> None:
    page.key("e")
    _, untouched = download(page, browser, tmp_path)
    assert json.loads(untouched) == contacts_document(FRAMES)
    read = labels_format.decode(untouched)
    assert read.effectors == {each.name: each.contacts for each in labelled(FRAMES).effectors}
    for path in tmp_path.iterdir():
        path.unlink()
    left, top, width, _ = page.box("#timeline")
    lane = top + 24 + 8  # of the left heel

    def x(at: float) -> float:
        return float(left + 96 + (width - 108) * at / FRAMES)

    def act(name: str) -> None:
        page.click(f'[data-edit="{name}"]')
        page.box("#timeline")

    want = contacts_document(FRAMES)
    heel = want["effectors"][0]["contacts"]
    page.drag([(x(190), lane), (x(205), lane), (x(210), lane)])  # the end of the second contact
    heel[1] = {"start": 140, "end": 210, "confidence": 1}
    page.drag([(x(260), lane), (x(230), lane), (x(150), lane)])  # a start can't pass the neighbour
    heel[2] = {"start": 210, "end": 310, "confidence": 1}
    page.drag([(x(85), lane), (x(100), lane), (x(110), lane)])  # an empty stretch
    heel.insert(1, {"start": 85, "end": 110, "confidence": 1})
    act("delete")
    act("undo")
    assert page.run("document.querySelector('[data-edit=redo]').disabled") is False
    page.drag([(x(280), lane)])  # chooses a bar
    act("forbid")
    heel[3]["forbid"] = True
    act("next")
    act("delete")
    del heel[4]
    page.run(
        "const end = document.querySelector('[data-edit=end]'); document.querySelector('[data-edit=lane]').value = '3';"
        "document.querySelector('[data-edit=lane]').dispatchEvent(new Event('change'))"
    )
    act("previous")
    act("force")
    page.run("const e = document.querySelector('[data-edit=end]'); e.value = 75; e.dispatchEvent(new Event('change'))")
    name, data = download(page, browser, tmp_path)
    got = json.loads(data)
    assert got["effectors"][0]["contacts"] == heel
    changed = [each for each in got["effectors"][3]["contacts"] if each not in want["effectors"][3]["contacts"]]
    assert len(changed) == 1
    assert got["effectors"][1:3] == want["effectors"][1:3]
    assert {**got, "effectors": []} == {**want, "effectors": []}
    assert name.endswith(".contacts.json")
    fitted, _ = labels_format.fit(labels_format.decode(data), rig().no_contacts(walker(FRAMES)))
    assert fitted["left_heel"].contacts[3].wish == "forbid"
    page.run("document.activeElement.blur()")
    while not page.run("document.querySelector('[data-edit=undo]').disabled"):
        page.key("z", CTRL)
    for path in tmp_path.iterdir():
        path.unlink()
    assert json.loads(download(page, browser, tmp_path)[1]) == contacts_document(FRAMES)


_RANDOM_EDITS = """
let seed = 7;
const random = (below) => { seed = (seed * 1103515245 + 12345) % 2147483648; return seed % below; };
const start = { effectors: [{ name: "a", contacts: [{ start: 10, end: 20 }, { start: 40, end: 90 }] }, { name: "b" }] };
const contacts = new Contacts(start, 200, []);
const broken = [];
const states = [JSON.stringify(contacts.lanes)];
for (let k = 0; k < 2000; k++) {
  const lane = random(2);
  const list = contacts.lanes[lane];
  const before = contacts.done.length;
  if (random(3) === 0 || !list.length) contacts.add(lane, random(260) - 30, random(260) - 30);
  else {
    contacts.select(lane, list[random(list.length)]);
    const step = random(4);
    if (step === 0) contacts.remove();
    else if (step === 1) contacts.wish(["force", "forbid"][random(2)]);
    else contacts.resize(random(300) - 50, random(300) - 50);
  }
  if (contacts.done.length > before) states.push(JSON.stringify(contacts.lanes));
  for (const each of contacts.lanes) {
    each.forEach((c, i) => {
      if (!(c.start >= 0 && c.start < c.end && c.end <= 200)) broken.push([k, "range", c]);
      if (i && each[i - 1].end > c.start) broken.push([k, "overlap", each[i - 1], c]);
      if (c.force && c.forbid) broken.push([k, "both", c]);
    });
  }
}
const steps = states.length;
while (contacts.done.length) {
  if (JSON.stringify(contacts.lanes) !== states.pop()) broken.push(["undo"]);
  contacts.undo();
}
({ broken: broken.slice(0, 3), steps, end: JSON.stringify(contacts.lanes) === states[0] })
"""


def test_contacts_stay_in_order_whatever_is_done_and_every_step_is_undone(used: Page) -> None:
    found = used.run("{" + asset("contacts.js") + _RANDOM_EDITS + "}")
    assert found["broken"] == []
    assert found["steps"] > 500
    assert found["end"]


_OVERLAPS = """
const boxes = [];
const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
for (let node; (node = walker.nextNode());) {
  const parent = node.parentElement;
  if (!node.textContent.trim() || !parent.checkVisibility() || parent.closest('.unseen, select')) continue;
  const range = document.createRange();
  range.selectNodeContents(node);
  const clip = parent.closest('.scroll')?.getBoundingClientRect();
  for (const r of range.getClientRects()) {
    if (r.width < 1 || r.height < 1 || (clip && (r.bottom > clip.bottom || r.right > clip.right))) continue;
    boxes.push({ r, text: node.textContent.trim() });
  }
}
const found = [];
boxes.forEach((a, i) => boxes.slice(i + 1).forEach((b) => {
  const wide = Math.min(a.r.right, b.r.right) - Math.max(a.r.left, b.r.left);
  const tall = Math.min(a.r.bottom, b.r.bottom) - Math.max(a.r.top, b.r.top);
  if (wide > 1.5 && tall > 4) found.push([a.text.slice(0, 40), b.text.slice(0, 40)]);
}));
found
"""


@pytest.mark.parametrize(("name", "width", "height", "dark"), [
    ("clip #1.html", 1280, 768, False), ("clip #1.html", 390, 844, True),
    ("index.html", 1280, 768, True), ("index.html", 390, 844, False),
])  # fmt: skip
def test_it_fits_laptop_and_phone(
    browser: Browser, folder: Path, name: str, width: int, height: int, dark: bool
) -> None:
    page = browser.open(folder / name, width=width, height=height, dark=dark, touch=width < 500)
    if "clip" in name:
        page.click("#edit")
        page.run("for (const each of document.querySelectorAll('details')) each.open = true")
    page.settle()
    assert page.run("document.documentElement.scrollWidth") <= width
    assert page.run("const outer = document.body.getBoundingClientRect(); outer.width") <= width
    assert page.run(_OVERLAPS.strip()) == []
    ground = page.run("getComputedStyle(document.body).backgroundColor")
    assert (ground == "rgb(15, 18, 22)") == dark
    if width > 500:
        no_column_is_outside(page, "#plants" if "clip" in name else "#clips")
    elif "clip" in name:
        notes, plants = (
            page.run(f"document.querySelector('{part}').getBoundingClientRect().top") for part in (".notes", ".plants")
        )
        assert notes < plants  # what is to be known comes first where all is one column
    assert page.complaints == []


def no_column_is_outside(page: Page, table: str) -> None:
    """The last column of a table ends where its room ends, and none is left out that says what became of a plant."""
    last = page.run(f"document.querySelector('{table} thead th:last-child').getBoundingClientRect().right")
    room = page.run(f"document.querySelector('{table}').closest('.scroll').getBoundingClientRect().right")
    assert last <= room + 1
    shown = "filter(header => header.checkVisibility()).map(header => header.innerText)"
    headers = page.run(f"[...document.querySelectorAll('{table} thead th')].{shown}")
    if table == "#plants":
        assert {"Off target mm", "Outcome and reason"} <= {" ".join(header.split()) for header in headers}


def test_every_control_has_a_name(used: Page) -> None:
    used.click("#edit")
    tree = used.call("Accessibility.getFullAXTree")["nodes"]
    roles = ("button", "slider", "combobox", "spinbutton", "img", "application", "checkbox", "MenuListPopup")
    nameless = [
        node["role"]["value"]
        for node in tree
        if not node.get("ignored") and node["role"]["value"] in roles[:-1] and not node.get("name", {}).get("value")
    ]
    assert nameless == []
    assert len([node for node in tree if node.get("role", {}).get("value") == "button"]) > 30


def test_the_index_sorts_finds_and_links(browser: Browser, folder: Path) -> None:
    page = browser.open(folder / "index.html")
    rows = "[...document.querySelectorAll('#clips tbody tr:not([hidden]) th')].map(cell => cell.textContent)"
    assert page.run(rows)[0] == "b/broken.bvh"
    page.click("#clips thead th:nth-child(2) button")
    assert page.run(rows) == sorted(page.run(rows), key=str.lower)
    page.run("const f = document.querySelector('#filter'); f.value = 'WALK'; f.dispatchEvent(new Event('input'))")
    assert page.run(rows) == ["a/walk.bvh"]
    page.click("#clips tbody tr:not([hidden]) a")
    page.wait("document.querySelector('#stage') && document.readyState === 'complete'")
    page.settle()
    assert inks(page, "#stage") > 10
    assert page.complaints == []
    assert [each for each in page.requests if not each.startswith("file:")] == []


def test_the_page_unpacks_what_was_packed(used: Page) -> None:
    steps = quantize(np.random.default_rng(3).normal(0.0, 1e4, (50, 7)), 0.5)
    steps[3, 2], steps[4, 2] = 1 << 28, -(1 << 28)
    script = asset("codec.js") + f"; [...unpack({json.dumps(pack(steps))}, 50, 7, 0.5)]"
    got = np.array(used.run("{" + script + "}")).reshape(50, 7)
    assert np.array_equal(got, (steps * 0.5).astype(np.float32))


def test_a_clip_of_nothing_and_a_long_one_open_too(browser: Browser, tmp_path: Path) -> None:
    """The last of them is a long one, whose timeline shows slides before as areas, and near by as a dashed curve."""
    cases: dict[str, Any] = {
        "failed": PageData({"status": "failed", "source": "x.bvh"}),
        "bare": PageData(report_document(4, plants=[]), {**contacts_document(4), "effectors": []}, motion(4)),
        "long": PageData(report_document(20_000), contacts_document(20_000), motion(20_000)),
    }
    for name, data in cases.items():
        (tmp_path / f"{name}.html").write_text(render(data), encoding="utf-8", newline="")
        page = browser.open(tmp_path / f"{name}.html", width=1280)
        page.settle()
        assert page.complaints == [], name
    assert "one frame in 3 is shown" in page.run("document.querySelector('.file').textContent")
    page.key("Home")
    page.key("ArrowRight")
    assert frame(page) == 3
    page.key("End")
    count = """
        const c = document.querySelector("#timeline");
        const d = c.getContext("2d").getImageData(0, 0, c.width, c.height).data;
        let n = 0;
        for (let i = 0; i < d.length; i += 4) n += d[i] > d[i + 1] + 20 && d[i + 2] > d[i + 1] + 20;
        n"""
    over_all = page.run(count.strip())
    for _ in range(5):
        page.click("#zoom-in")
    near = page.run(count.strip())
    assert over_all > 3 * near > 0, (over_all, near)  # purple


@pytest.mark.parametrize("asked", [{}, {"in_place": True, "open": True}], ids=["closed", "open, in place"])
def test_a_loop_plays_round_after_round_and_complains_of_nothing(
    browser: Browser, tmp_path: Path, asked: dict[str, bool]
) -> None:
    clip = exports.bvh(make(Gait(name="curve", duration=3.2, fps=30.0)).clip)
    made = loop_file(clip, "walk.bvh", Settings(loop=LoopParams(**asked)))  # type: ignore[arg-type]
    (tmp_path / "loop.html").write_bytes(made.pages[".report.html"])
    page = browser.open(tmp_path / "loop.html")
    page.settle()
    assert "a loop of" in page.run("document.body.textContent")
    page.run("document.activeElement.blur()")
    page.key("End")
    assert frame(page) == made.report["loop"]["frames"] - 1
    page.click("#play")
    for which in ("both", "beside"):  # the end of a round is followed by the next one's first frames
        page.click(f"[data-figures={which}]")
        for _ in range(2):
            page.key("End")
            page.wait("Number(document.querySelector('#scrub').value) < 10")
    page.click("#play")
    assert inks(page, "#stage") > 10
    assert (page.complaints, page.requests) == ([], [])
