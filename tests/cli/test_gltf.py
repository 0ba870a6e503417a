"""The commands on glTF files: every animation is a clip of its own, and one file holds what changed in any."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from importlib import resources
from pathlib import Path

import artefacts
import jsonschema
import numpy as np
import pytest
from conftest import SHARED
from glbmaker import binary_of, character, tree_of, with_tree, world
from walks import walk

import footfix
from footfix import cli
from footfix.jobs.shared_legs import with_shared_legs
from footfix.rig.find import find_rig
from footfix.settings import Settings

Run = Callable[..., tuple[int, str, str]]
QUICK = ("--report", "json", "-j1")
SETTINGS = Settings()


@cache
def glb() -> bytes:
    """A character as Mixamo's are: in centimetres, z up, its rest pose in mid-step; a walk that skates, and another."""
    skating = artefacts.wander(artefacts.drift(walk("walk", 30.0, 2.0).clip, 0.05), 0.03)
    on_the_spot = artefacts.retarget(walk("treadmill", 30.0, 1.4).clip, 1.05)
    return character({"Walk": skating, "On the/spot": on_the_spot}, scale=0.01, z_up=True, mid_step=True).glb()


@pytest.fixture
def figure(tmp_path: Path) -> Path:
    path = tmp_path / "in" / "figure.glb"
    path.parent.mkdir()
    path.write_bytes(glb())
    return path


@pytest.fixture(scope="module")
def done(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """The figure, and the folder it was cleaned into."""
    folder = tmp_path_factory.mktemp("done")
    (folder / "figure.glb").write_bytes(glb())
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys, "argv", ["footfix", "clean", str(folder / "figure.glb"), "-o", str(folder / "out"), *QUICK])
        assert cli.run() == 0
    return folder / "figure.glb", folder / "out"


def names(folder: Path) -> list[str]:
    return sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file())


def test_every_animation_is_cleaned_and_only_they_change(done: tuple[Path, Path]) -> None:
    figure, out = done
    assert names(out) == [
        "figure.On the_spot.contacts.json", "figure.On the_spot.report.json", "figure.Walk.contacts.json",
        "figure.Walk.report.json", "figure.glb",
    ]  # fmt: skip
    report = json.loads((out / "figure.Walk.report.json").read_text())
    assert report["source"]["file"] == "figure.glb#Walk" and report["output"] == "figure.glb"
    assert report["before"]["slide_mm"] > 21.0 and report["after"]["slide_mm"] < 3.0
    old, new = tree_of(figure.read_bytes()), tree_of((out / "figure.glb").read_bytes())
    assert all(new[key] == old[key] for key in ("meshes", "materials", "images", "skins", "nodes"))
    assert binary_of((out / "figure.glb").read_bytes()).startswith(binary_of(figure.read_bytes()))


def test_planted_toes_stand_in_the_file_as_another_reader_sees_it(done: tuple[Path, Path]) -> None:
    figure, out = done
    labels = json.loads((out / "figure.Walk.contacts.json").read_text())
    slides = {}
    for path in (figure, out / "figure.glb"):
        seen = world(path.read_bytes(), 0, np.arange(labels["source"]["frames"]) * labels["source"]["frame_time"])
        slides[path] = [
            1000.0 * float(np.linalg.norm(track - np.median(track, axis=0), axis=1).max())
            for effector in labels["effectors"] if effector["part"] == "toe"
            for contact in effector["contacts"]
            if len(track := seen[effector["joint"]][contact["start"] + 1 : contact["end"] - 1][:, [0, 2]])
        ]  # fmt: skip
    before, after = slides.values()
    assert max(before) > 21.0 and max(after) < 3.0


def test_one_animation_alone(run: Run, figure: Path, tmp_path: Path) -> None:
    named, chosen = tmp_path / "named", tmp_path / "chosen"
    assert run("clean", f"{figure}#Walk", "-o", named / "mine.glb", *QUICK)[0] == 0
    assert run("clean", figure, "--animation", "walk", "-o", chosen, *QUICK)[0] == 0
    assert names(named) == ["mine.Walk.contacts.json", "mine.Walk.report.json", "mine.glb"]
    assert (named / "mine.glb").read_bytes() == (chosen / "figure.glb").read_bytes()
    old, new = tree_of(figure.read_bytes()), tree_of((named / "mine.glb").read_bytes())
    assert new["animations"][1] == old["animations"][1] and new["animations"][0] != old["animations"][0]
    code, _, said = run("clean", figure, "--animation", "Nope", "-o", tmp_path / "no", *QUICK)
    assert code == 3 and "Walk" in said and not (tmp_path / "no" / "figure.glb").exists()


def test_cleaned_again_it_stays_the_same_file(run: Run, figure: Path, tmp_path: Path) -> None:
    code, _, said = run("clean", figure, *QUICK)
    assert code == 0 and "figure.glb#Walk" in said
    clean = figure.with_name("figure.clean.glb")
    assert run("clean", clean, "-o", tmp_path / "again", *QUICK)[0] == 0
    assert (tmp_path / "again" / clean.name).read_bytes() == clean.read_bytes()


@pytest.mark.usefixtures("forking")
def test_processes_and_resume_make_the_same(run: Run, figure: Path, tmp_path: Path) -> None:
    figure.with_name("more.vrma").write_bytes(character({"Walk": walk("walk", 30.0, 1.0).clip}).glb())
    one, two = tmp_path / "one", tmp_path / "two"
    assert run("clean", figure.parent, "-o", one, *QUICK)[0] == 0
    assert run("clean", figure.parent, "-o", two, "--report", "json", "-j2")[0] == 0
    assert names(one) == names(two)
    assert all((one / name).read_bytes() == (two / name).read_bytes() for name in names(one))
    summary = json.loads((one / "summary.json").read_text())
    assert summary["clips"]["total"] == 3 and summary["files"][0]["source"] == "figure.glb#Walk"
    code, _, said = run("clean", figure.parent, "-o", one, "--resume", *QUICK)
    assert code == 0 and "done before" in said
    assert json.loads((one / "summary.json").read_text()) == summary


def test_labels_come_from_a_folder(run: Run, figure: Path, tmp_path: Path) -> None:
    labels = tmp_path / "labels"
    assert run("detect", figure, "-o", labels)[0] == 0
    assert names(labels) == ["figure.On the_spot.contacts.json", "figure.Walk.contacts.json"]
    assert run("clean", figure, "--labels", labels, "-o", tmp_path / "out", *QUICK)[0] == 0
    one = labels / "figure.Walk.contacts.json"
    assert run("clean", figure, "--labels", one, "--animation", "Walk", "-o", tmp_path / "alone", *QUICK)[0] == 0
    code, _, said = run("clean", figure, "--labels", one, "-o", tmp_path / "no", *QUICK)
    assert code == 3 and "--animation" in said


def test_events_stand_beside_it_and_in_a_copy(run: Run, figure: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    assert run("detect", figure, "--events", "-o", out)[0] == 0
    told = json.loads((out / "figure.Walk.events.json").read_text())
    contacts = json.loads((out / "figure.Walk.contacts.json").read_text())
    starts = sorted(each["start"] for effector in contacts["effectors"] for each in effector["contacts"])
    assert [each["frame"] for each in told["events"] if each["event"] == "strike"] == starts
    jsonschema.validate(
        told, json.loads((resources.files("footfix.report") / "schemas" / "events.v1.json").read_text())
    )
    copy = tree_of((out / "figure.events.glb").read_bytes())
    assert copy["animations"][0]["extras"]["footfix_events"] == told["events"]
    assert binary_of((out / "figure.events.glb").read_bytes()) == binary_of(figure.read_bytes())


def test_check_inspect_and_loop_take_them(run: Run, figure: Path, tmp_path: Path) -> None:
    assert run("check", figure)[0] == 1
    code, said, _ = run("inspect", figure)
    assert code == 0 and "figure.glb#Walk: 61 frames" in said and "figure.glb#On the/spot" in said
    assert run("loop", f"{figure}#Walk", "--in-place", "-o", tmp_path / "loop", *QUICK)[0] == 0
    data = (tmp_path / "loop" / "figure.glb").read_bytes()
    length = json.loads((tmp_path / "loop" / "figure.Walk.report.json").read_text())["loop"]["frames"]
    ends = {tree_of(data)["accessors"][s["input"]]["max"][0] for s in tree_of(data)["animations"][0]["samplers"]}
    assert max(ends) == pytest.approx((length - 1) / 30.0, abs=1e-5)
    seen = world(data, 0, [0.0, (length - 1) / 30.0])
    pose = np.stack([track for name, track in seen.items() if name != "Armature" and "Body" not in name])
    np.testing.assert_allclose(pose[:, 0], pose[:, 1], atol=1e-5)


def test_a_text_file_goes_with_the_files_it_names(run: Run, tmp_path: Path) -> None:
    made = character({"Walk": artefacts.drift(walk("walk", 30.0, 1.5).clip, 0.05)})
    source = tmp_path / "in" / "figure.gltf"
    (source.parent / "data").mkdir(parents=True)
    source.write_bytes(made.gltf("data/numbers.bin"))
    (source.parent / "data" / "numbers.bin").write_bytes(bytes(made.data))
    assert run("clean", source, "-o", tmp_path / "out", *QUICK)[0] == 0
    assert (tmp_path / "out" / "data" / "numbers.bin").read_bytes() == bytes(made.data)
    assert footfix.load(tmp_path / "out" / "figure.gltf").frames == 46
    (source.parent / "data" / "numbers.bin").unlink()
    code, _, said = run("clean", source, "-o", tmp_path / "no", *QUICK)
    assert code == 3 and "numbers.bin" in said


def with_few(name: str, kept: tuple[str, ...], folder: Path) -> Path:
    """A shared character with a few of its animations; skips the test, saying so, where it is absent."""
    path = SHARED / "glb" / name
    if not path.exists():
        pytest.skip(f"no character: {path} is absent")
    tree = tree_of(path.read_bytes())
    tree["animations"] = [each for each in tree["animations"] if each["name"] in kept]
    assert len(tree["animations"]) == len(kept)
    (folder / name).write_bytes(with_tree(path.read_bytes(), tree))
    return folder / name


def with_more(data: bytes, name: str, channels: list[tuple[str, str]]) -> bytes:
    """A GLB with one more animation, which has some of the channels of the first: (name of the node, path)."""
    tree = tree_of(data)
    first = tree["animations"][0]
    nodes = [node["name"] for node in tree["nodes"]]
    wanted = {(nodes.index(node), path) for node, path in channels}
    own = [c for c in first["channels"] if (c["target"]["node"], c["target"]["path"]) in wanted]
    samplers = [first["samplers"][c["sampler"]] for c in own]
    channels_ = [{"sampler": k, "target": c["target"]} for k, c in enumerate(own)]
    tree["animations"].append({"name": name, "samplers": samplers, "channels": channels_})
    return with_tree(data, tree)


def test_what_does_not_move_the_legs_gets_no_channels_for_them(run: Run, figure: Path, tmp_path: Path) -> None:
    """A nod is played over a walk: with channels for the legs, in whatever pose they rest, it would stop the walk."""
    figure.write_bytes(with_more(glb(), "Nod", [("Spine", "rotation")]))
    assert run("clean", str(figure), "--animation", "Nod", "-o", str(tmp_path / "out"), *QUICK)[0] == 0
    assert (tmp_path / "out" / "figure.glb").read_bytes() == figure.read_bytes()
    report = json.loads((tmp_path / "out" / "figure.Nod.report.json").read_text())
    assert report["status"] == "unchanged"
    assert "legs-not-moved" in {note["id"] for note in report["notes"]}


def test_no_loop_is_cut_out_of_what_does_not_move_the_legs(run: Run, figure: Path, tmp_path: Path) -> None:
    figure.write_bytes(with_more(glb(), "Nod", [("Spine", "rotation")]))
    code, _, said = run("loop", str(figure), "--animation", "Nod", "-o", str(tmp_path / "out"), *QUICK)
    assert (code, "nothing in it moves the legs" in said) == (3, True)
    assert not (tmp_path / "out" / "figure.glb").exists()


def test_legs_that_no_animation_shows_are_those_of_the_pose_of_binding(run: Run, tmp_path: Path) -> None:
    """A fox that runs and sits is not seen to stand on four in either."""
    code, said, _ = run("inspect", with_few("fox-animations.glb", ("Run", "Sit"), tmp_path))
    assert (code, said.count("4 legs")) == (0, 2)


def test_a_pose_among_animations_is_no_failure_unless_asked_for(run: Run, figure: Path, tmp_path: Path) -> None:
    tree = tree_of(glb())
    two = next(s for s in tree["animations"][0]["samplers"] if tree["accessors"][s["input"]]["count"] == 2)
    keys = next(s["input"] for s in tree["animations"][0]["samplers"] if s["interpolation"] == "LINEAR")
    tree["accessors"].append({**tree["accessors"][keys], "count": 2})
    pose = {"input": len(tree["accessors"]) - 1, "output": two["output"]}
    target = next(c["target"] for c in tree["animations"][0]["channels"] if c["target"]["path"] == "translation")
    tree["animations"].append({"name": "Pose", "samplers": [pose], "channels": [{"sampler": 0, "target": target}]})
    figure.write_bytes(with_tree(glb(), tree))
    assert run("detect", str(figure), "-o", str(tmp_path / "all"), "-j1")[0] == 0
    assert not [name for name in names(tmp_path / "all") if "Pose" in name]
    code, _, said = run("detect", str(figure), "--animation", "Pose", "-o", str(tmp_path / "one"), "-j1")
    assert (code, "no motion" in said) == (3, True)


def test_an_animation_of_the_face_alone_is_none_of_the_clips(run: Run, figure: Path, tmp_path: Path) -> None:
    tree = tree_of(glb())
    body = next(k for k, node in enumerate(tree["nodes"]) if "mesh" in node)
    sampler = {**tree["animations"][0]["samplers"][0]}
    channel = {"sampler": 0, "target": {"node": body, "path": "weights"}}
    tree["animations"] = [{"name": "Smile", "samplers": [sampler], "channels": [channel]}, tree["animations"][0]]
    figure.write_bytes(with_tree(glb(), tree))
    assert footfix.animations(figure) == ("Walk",)
    assert run("clean", str(figure), "-o", str(tmp_path / "out"), *QUICK)[0] == 0
    after = tree_of((tmp_path / "out" / "figure.glb").read_bytes())
    assert after["animations"][0] == tree["animations"][0]
    assert after["animations"][1] != tree["animations"][1]


@pytest.mark.parametrize(("animation", "left"), [("Idle", True), ("Walking", False)])
def test_legs_whose_feet_cannot_go_along_are_left(run: Run, tmp_path: Path, animation: str, left: bool) -> None:
    """The robot's feet hang from its root; where they have no channels, its legs must not walk away from them."""
    path, out = with_few("RobotExpressive.glb", ("Idle", "Walking"), tmp_path), tmp_path / "out"
    assert run("clean", path, "--animation", animation, "-o", out, *QUICK)[0] == 0
    assert ((out / path.name).read_bytes() == path.read_bytes()) is left
    report = json.loads((out / f"RobotExpressive.{animation}.report.json").read_text())
    assert ("feet-not-moved" in {note["id"] for note in report["notes"]}) is left


def test_from_python(figure: Path, tmp_path: Path) -> None:
    assert footfix.animations(figure) == ("Walk", "On the/spot")
    document = footfix.load(figure, animation="Walk")
    result = footfix.clean(document.clip)
    footfix.save(tmp_path / "out.glb", result.clip, like=document)
    again = footfix.load(f"{tmp_path / 'out.glb'}#Walk")
    np.testing.assert_allclose(again.clip.rotations, result.clip.rotations, atol=1e-6)
    with pytest.raises(footfix.InputError, match="2 animations"):
        footfix.load(figure)
    with pytest.raises(footfix.ArgumentError, match="like"):
        footfix.save(tmp_path / "no.glb", result.clip)
    assert footfix.clean_file(f"{figure}#Walk").status == "cleaned"


def test_damaged_files_leave_nothing_half_written(run: Run, tmp_path: Path) -> None:
    random, data, folder = np.random.default_rng(0), glb(), tmp_path / "in"
    folder.mkdir()
    for k in range(20):
        at = int(random.integers(len(data)))
        torn = data[:at] if k % 2 else data[:at] + data[at + 13 :]
        (folder / f"{k:02d}.glb").write_bytes(torn)
    code, _, said = run("clean", folder, "-o", tmp_path / "out", *QUICK)
    assert code == 3 and "Traceback" not in said and "bug" not in said
    assert names(tmp_path / "out") == [".footfix/run.jsonl", "summary.json"]


def test_animals_of_games_stand_where_they_are_planted(run: Run, tmp_path: Path) -> None:
    path, reports = with_few("horse-animations.glb", ("Walk",), tmp_path), []
    for folder, how in (("none", ("--skin", "none")), ("own", ())):
        assert run("clean", path, "-o", tmp_path / folder, *how, *QUICK)[0] == 0
        reports.append(json.loads((tmp_path / folder / "horse-animations.report.json").read_text()))
    for report in reports:
        assert {note["id"] for note in report["notes"]} >= {"cycle", "in-place"}
        assert max(plant["slide_before_mm"] for plant in report["plants"]) > 21.0
    slides = [[plant["slide_after_mm"] for plant in report["plants"]] for report in reports]
    # Without its skin a front hoof is found planted for a frame or two in which it leaves the floor already.
    assert sum(slide > 21.0 for slide in slides[0]) <= 1
    # On its own hooves the horse stands lower, and one leg is a millimetre too short for the end of its stance.
    assert sum(slide > 21.0 for slide in slides[1]) <= 1 and max(slides[1]) < 40.0
    assert reports[1]["before"]["penetration_mm"] > 20.0 and reports[1]["after"]["penetration_mm"] < 3.0


def test_an_uneven_gait_in_place_stands_on_a_ground_that_passes_evenly(run: Run, tmp_path: Path) -> None:
    """Of the written file alone, read the plain way: toe joints less one even speed stay where they are."""
    settings = replace(SETTINGS, loop=replace(SETTINGS.loop, in_place=True))
    looped = footfix.loop(walk("run", 30.0, 2.6).clip, settings).clip
    phase = np.linspace(0.0, 2.0 * np.pi, len(looped))[:, None]
    uneven = looped.with_joints({0: looped.position(0) + 0.035 * np.sin(phase) * [0.3, 0.0, 1.0]}, {})
    path, out = tmp_path / "figure.glb", tmp_path / "out"
    path.write_bytes(character({"Go": uneven}, scale=0.01, z_up=True, mid_step=True, skins=2).glb())
    assert run("clean", path, "-o", out, *QUICK)[0] == 0
    effectors = json.loads((out / "figure.contacts.json").read_text(encoding="utf-8"))["effectors"]
    times = looped.frame_time * np.arange(len(looped))

    def slides(data: bytes) -> list[float]:
        places = world(data, 0, times)
        feet = [
            places[own["joint"]][c["start"] : c["end"]][:, [0, 2]]
            for own in effectors if own["part"] == "toe" for c in own["contacts"] if c["end"] - c["start"] > 4
        ]  # fmt: skip
        speed = np.median(np.concatenate([np.diff(foot, axis=0) for foot in feet]), axis=0)
        over = [foot - speed * np.arange(len(foot))[:, None] for foot in feet]
        return [1000.0 * float(np.linalg.norm(each - np.median(each, axis=0), axis=1).max()) for each in over]

    before, after = slides(path.read_bytes()), slides((out / "figure.glb").read_bytes())
    assert len(after) > 1 and max(before) > 15.0 and max(after) < 1.0
    ends = world((out / "figure.glb").read_bytes(), 0, times[[0, -1]])
    assert max(np.abs(track[1] - track[0]).max() for track in ends.values()) < 1e-5  # the seam stays closed


@pytest.mark.parametrize(
    ("animal", "agree", "lost"),
    [("fox", ("Fetch", "Jump"), ("Walk", "Sit", "Run")), ("horse", ("Idle", "Kick"), ("Death", "Sleep"))],
    ids=["fox", "horse"],
)
def test_all_animations_of_an_animal_have_its_four_legs(
    animal: str, agree: tuple[str, ...], lost: tuple[str, ...], tmp_path: Path
) -> None:
    """Those that alone show fewer legs or others (`lost`) have the legs of those that agree."""
    path = with_few(f"{animal}-animations.glb", agree + lost, tmp_path)
    data, found = path.read_bytes(), []
    for name in (agree[0], *lost):
        settings = with_shared_legs(data, f"{path.name}#{name}", SETTINGS)
        clip = footfix.load(str(path), animation=name).clip
        found.append([(leg.name, *leg.chain, leg.toe) for leg in find_rig(clip, settings.rig).legs])
    assert [leg[0] for leg in found[0]] == ["front_left", "front_right", "hind_left", "hind_right"]
    assert all(each == found[0] for each in found)


def test_a_file_of_one_animation_or_of_legs_that_agree_is_left_to_itself(figure: Path) -> None:
    data = glb()
    assert with_shared_legs(data, "figure.glb#Walk", SETTINGS) is SETTINGS
    assert with_shared_legs(data, "figure.glb", SETTINGS) is SETTINGS
    assert with_shared_legs(b"no glb", "figure.glb#Walk", SETTINGS) is SETTINGS
