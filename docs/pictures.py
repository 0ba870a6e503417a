"""Draw the pictures of the documentation, each from the sample clips, while it is built.

python docs/pictures.py FOLDER  writes them there, to look at.
"""

from __future__ import annotations

import io
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib import pyplot as plt
from matplotlib.figure import Figure

import footfix
from footfix.motion.clip import Clip, Floats
from footfix.motion.smoothing import savgol

matplotlib.use("svg")
matplotlib.rcParams.update({
    "svg.hashsalt": "footfix", "svg.fonttype": "none", "font.family": "sans-serif", "font.size": 9,
    "axes.spines.top": False, "axes.spines.right": False, "figure.facecolor": "white", "axes.facecolor": "white",
})  # fmt: skip

SAMPLES = Path(__file__).resolve().parent.parent / "sample_data"
BEFORE, AFTER, HEEL, TOE, PALE = "#d1495b", "#00798c", "#edae49", "#30638e", "#b8c4cc"


@cache
def walk() -> footfix.Document:
    """The sample walk, whose feet slide."""
    return footfix.load(SAMPLES / "walk_skate.bvh")


@cache
def cleaned() -> footfix.Result:
    """The same, cleaned."""
    return footfix.clean(walk().clip)


def tracks(clip: Clip) -> dict[str, Floats]:
    """(F, 3) [m] of each sole point, by name."""
    rig = cleaned().rig
    return {sole.name: track for sole, track in zip(rig.soles, rig.tracks(rig.pose(clip)), strict=True)}


def changed_numbers() -> Figure:
    """How many of each joint's frames have other numbers after cleaning."""
    before, after, names = walk().clip, cleaned().clip, walk().clip.skeleton.names
    turned = np.any(before.rotations != after.rotations, axis=2) | np.any(before.positions != after.positions, axis=2)
    share = 100.0 * turned.mean(axis=0)
    figure, axes = plt.subplots(figsize=(6.4, 3.8))
    axes.barh(range(len(names)), share, color=[AFTER if each else PALE for each in share])
    axes.barh(range(len(names)), 100.0 - share, left=share, color="#eef2f4")
    axes.set_yticks(range(len(names)), names, fontsize=7)
    axes.invert_yaxis()
    axes.set_xlabel("share of frames whose numbers are new [%]; all others are the bytes of the file")
    return figure


def legs_and_soles() -> Figure:
    """The skeleton in one frame with its legs, sole points and floor."""
    clip, rig, frame = walk().clip, cleaned().rig, 60
    at, parents = footfix.global_positions(clip)[frame], clip.skeleton.parents.tolist()
    figure, axes = plt.subplots(figsize=(3.6, 4.6))
    for joint, parent in enumerate(parents):
        if parent >= 0:
            axes.plot(at[[parent, joint], 2], at[[parent, joint], 1], color=PALE, lw=2)
    for leg, colour in zip(rig.legs, (TOE, AFTER), strict=True):
        chain = [*leg.chain, *([] if leg.toe is None else [leg.toe])]
        axes.plot(at[chain, 2], at[chain, 1], "o-", color=colour, lw=3, ms=4, label=f"{leg.name} leg")
    for k, track in enumerate(tracks(clip).values()):
        label = "sole points" if k == 0 else None
        axes.plot(track[frame, 2], track[frame, 1], "v", color=HEEL, ms=7, label=label, zorder=3)
    axes.axhline(rig.floor, color="#666", lw=1)
    axes.text(at[:, 2].max() + 0.05, rig.floor + 0.01, "floor", color="#666", fontsize=8)
    axes.set(aspect="equal", xlabel="z [m]", ylabel="y [m]")
    axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), fontsize=7, frameon=False)
    return figure


def smoothing() -> Figure:
    """Noise on a toe's height, and what the filter leaves of it."""
    rng = np.random.default_rng(4)
    track = tracks(walk().clip)["left_toe"][:, 1]
    noisy = track + rng.normal(0.0, 0.006, len(track))
    seconds = np.arange(len(track)) * walk().frame_time
    smooth = savgol(noisy, walk().frame_time, seconds=0.25, degree=2)
    figure, axes = plt.subplots(figsize=(6.4, 2.4))
    axes.plot(seconds, 100.0 * noisy, ".", color=PALE, ms=3, label="with noise of 6 mm")
    axes.plot(seconds, 100.0 * track, color="#666", lw=1, ls="--", label="without")
    axes.plot(seconds, 100.0 * smooth, color=AFTER, lw=1.5, label="window 0.25 s, degree 2")
    axes.set(xlim=(1.0, 3.0), xlabel="time [s]", ylabel="toe height [cm]")
    axes.legend(fontsize=7, frameon=False)
    return figure


def contacts() -> Figure:
    """Height and speed of heel and toe, and the contacts found."""
    seconds = np.arange(len(walk().clip)) * walk().frame_time
    found, mask = tracks(walk().clip), cleaned().contacts.mask()
    figure, (heights, speeds, bars) = plt.subplots(
        3, 1, figsize=(6.4, 4.0), sharex=True, height_ratios=(3, 3, 1.4), layout="constrained"
    )
    for name, colour in (("left_heel", HEEL), ("left_toe", TOE)):
        track = found[name]
        speed = np.linalg.norm(np.gradient(track, walk().frame_time, axis=0), axis=1)
        heights.plot(seconds, 100.0 * (track[:, 1] - cleaned().rig.floor), color=colour, label=name.replace("_", " "))
        speeds.plot(seconds, speed, color=colour)
    for k, (name, colour) in enumerate(zip(cleaned().contacts.names, (HEEL, TOE) * 2, strict=True)):
        bars.fill_between(seconds, k + 0.1, k + 0.9, where=mask[:, k].tolist(), color=colour, step="mid")
        bars.text(seconds[-1] + 0.05, k + 0.5, name.replace("_", " "), va="center", fontsize=7)
    heights.set_ylabel("over the floor [cm]")
    heights.legend(fontsize=7, frameon=False, loc="upper right")
    speeds.set_ylabel("speed [m/s]")
    bars.set(xlabel="time [s]", yticks=[])
    return figure


def toe_path() -> Figure:
    """Where the toe joint is along the walk, before and after, in its contacts."""
    rig, clip = cleaned().rig, walk().clip
    toe = rig.legs[0].toe
    assert toe is not None
    seconds = np.arange(len(clip)) * clip.frame_time
    mask = cleaned().contacts.mask()[:, cleaned().contacts.names.index("left_toe")]
    figure, axes = plt.subplots(figsize=(6.4, 2.8))
    for when, colour, label in ((clip, BEFORE, "as captured"), (cleaned().clip, AFTER, "cleaned")):
        place = footfix.global_positions(when)[:, toe]
        over = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(place[:, [0, 2]], axis=0).T))])
        axes.plot(seconds, over, color=colour, label=label, lw=1.4)
    axes.fill_between(seconds, *axes.get_ylim(), where=mask.tolist(), color=TOE, alpha=0.12, lw=0, label="in contact")
    axes.set(xlabel="time [s]", ylabel="way of the left toe joint [m]", xlim=(seconds[0], seconds[-1]))
    axes.legend(fontsize=7, frameon=False, loc="upper left")
    return figure


def price_of_sliding() -> Figure:
    """What a slide costs: a price per metre lets go in a few frames what a square would smear over all."""
    slip = np.linspace(-1.0, 1.0, 401)
    figure, (prices, plans) = plt.subplots(1, 2, figsize=(6.4, 2.4), layout="constrained")
    prices.plot(slip, np.abs(slip), color=AFTER, label="a price per metre")
    prices.plot(slip, slip**2, color=BEFORE, ls="--", label="its square")
    prices.set(xlabel="slip in a frame", ylabel="cost", xticks=[0], yticks=[])
    prices.legend(fontsize=7, frameon=False)
    frames = np.arange(24)
    plans.bar(frames - 0.2, np.where((frames > 9) & (frames < 13), 8.0, 0.0), 0.4, color=AFTER, label="per metre")
    plans.bar(frames + 0.2, np.full(24, 1.0), 0.4, color=BEFORE, label="square")
    plans.set(xlabel="frame of a contact that can't be held", ylabel="slip [mm]")
    plans.legend(fontsize=7, frameon=False)
    return figure


def knee_change() -> Figure:
    """How far the knees bend otherwise."""
    clip, rig = walk().clip, cleaned().rig
    seconds = np.arange(len(clip)) * clip.frame_time
    figure, axes = plt.subplots(figsize=(6.4, 2.2))
    for leg, colour in zip(rig.legs, (TOE, AFTER), strict=True):
        bends = []
        for each in (clip, cleaned().clip):
            at = footfix.global_positions(each)
            thigh, shank = at[:, leg.knee] - at[:, leg.hip], at[:, leg.ankle] - at[:, leg.knee]
            cosine = np.einsum("fi,fi->f", thigh, shank) / np.linalg.norm(thigh, axis=1) / np.linalg.norm(shank, axis=1)
            bends.append(np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0))))
        axes.plot(seconds, bends[1] - bends[0], color=colour, label=f"{leg.name} knee")
    axes.axhline(0.0, color="#666", lw=0.6)
    axes.set(xlabel="time [s]", ylabel="bent further by [°]", xlim=(seconds[0], seconds[-1]))
    axes.legend(fontsize=7, frameon=False)
    return figure


def slides() -> Figure:
    """How far every plant slides, before and after, and what viewers notice."""
    plants = list(zip(cleaned().plants_before, cleaned().plants_after, strict=True))
    at = np.arange(len(plants))
    figure, axes = plt.subplots(figsize=(6.4, 2.6))
    axes.bar(at - 0.2, [before.slide_mm for before, _ in plants], 0.4, color=BEFORE, label="as captured")
    after = [after.slide_mm for _, after in plants]
    axes.bar(at + 0.2, after, 0.4, color=AFTER, label=f"cleaned: up to {max(after):.2f} mm")
    axes.axhline(21.0, color="#666", lw=0.8, ls="--")
    axes.text(len(plants) - 0.4, 21.6, "21 mm: noticed", ha="left", fontsize=7, color="#666")
    names = [before.effector.replace("_", " ") for before, _ in plants]
    axes.set_xticks(at, names, rotation=60, ha="right", fontsize=7)
    axes.set_ylabel("slide [mm]")
    axes.legend(fontsize=7, frameon=False)
    return figure


DRAWN: dict[str, Callable[[], Figure]] = {
    "changed-numbers": changed_numbers,
    "legs-and-soles": legs_and_soles,
    "smoothing": smoothing,
    "contacts": contacts,
    "toe-path": toe_path,
    "price-of-sliding": price_of_sliding,
    "knee-change": knee_change,
    "slides": slides,
}


@cache
def all_pictures() -> dict[str, bytes]:
    """Every picture as SVG, by its path below docs/."""
    found = {}
    for name, draw in DRAWN.items():
        out = io.BytesIO()
        figure = draw()
        figure.savefig(out, format="svg", bbox_inches="tight", metadata={"Date": None})
        plt.close(figure)
        found[f"pictures/{name}.svg"] = out.getvalue()
    return found


def main() -> None:
    """Write all pictures into the folder that is named."""
    folder = Path(sys.argv[1])
    for name, data in all_pictures().items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)


if __name__ == "__main__":
    main()
