"""Makes the clips of this folder and their known contacts, the same to the byte each time: python make_samples.py."""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import artefacts
from exports import Spelling, bvh, renamed
from walker import Walk, make
from walker_plan import Gait

from footfix.formats.contacts import encode_json
from footfix.motion.clip import Clip
from footfix.motion.contacts import Contacts

HERE = Path(__file__).resolve().parent


@dataclass(frozen=True, eq=False)
class Sample:
    """One file: the clip as it is written, its spelling, the true contacts, and whether plants are where they were."""

    clip: Clip
    spelling: Spelling
    contacts: Contacts
    places: bool


def samples() -> dict[str, Sample]:
    """The clips by name."""
    walk = make(Gait(name="walk", duration=5.0, fps=60.0, seed=1, rest=(0.7, 0.9)))
    run = make(Gait(name="run", duration=3.0, fps=60.0, seed=2))
    turn = make(Gait(name="turn", duration=5.0, fps=60.0, seed=3))
    stairs = make(Gait(name="stairs", duration=5.0, fps=60.0, seed=4))
    found = {
        name: Sample(made.clip, Spelling(decimals=4), _placed(made), True)
        for name, made in (("walk", walk), ("run", run), ("turn", turn), ("stairs", stairs))
    }
    # a root that goes 8 % short of what the legs walk, and wanders: feet slide by twice what viewers notice
    skating = artefacts.wander(artefacts.scale_root(walk.clip, 0.92, height=False), 0.04, slowest=0.8, seed=1)
    found["walk_skate"] = Sample(skating, Spelling(decimals=4), walk.contacts, False)
    found["production"] = _production()
    return found


def _production() -> Sample:
    """As a studio's file would come: a game skeleton's names, metres, z up, a T-pose first, feet that wander."""
    made = make(Gait(name="turn", duration=4.0, fps=30.0, seed=5, turn=-1.2, leg=0.82))
    skating = artefacts.wander(artefacts.scale_root(made.clip, 0.95, height=False), 0.05, slowest=0.6, seed=5)
    skating = artefacts.t_pose_first(skating)
    clip = renamed(skating, "mixamo")
    joints = dict(zip(skating.skeleton.names, clip.skeleton.names, strict=True))
    effectors = tuple(
        replace(
            effector,
            joint=joints[effector.joint],
            contacts=tuple(replace(each, start=each.start + 1, end=each.end + 1) for each in effector.contacts),
        )
        for effector in made.contacts.effectors
    )
    contacts = replace(made.contacts, frames=len(clip), effectors=effectors)
    spelling = Spelling(unit_m=1.0, up="z", order="XYZ", decimals=6, newline="\r\n", indent="\t")
    return Sample(clip, spelling, contacts, False)


def _placed(made: Walk) -> Contacts:
    """The contacts with the places where the points stand."""
    effectors = []
    for effector, track in zip(made.contacts.effectors, made.tracks, strict=True):
        contacts = []
        for contact in effector.contacts:
            x, y, z = (float(each) for each in track[contact.start])
            contacts.append(replace(contact, position=(x, y, z)))
        effectors.append(replace(effector, contacts=tuple(contacts)))
    return replace(made.contacts, effectors=tuple(effectors))


def files() -> Mapping[str, bytes]:
    """Every file of the folder that is made here, by its path within it."""
    written: dict[str, bytes] = {}
    for name, sample in samples().items():
        data = bvh(sample.clip, sample.spelling)
        source = {
            "file": f"{name}.bvh",
            "sha256": hashlib.sha256(data).hexdigest(),
            "frames": len(sample.clip),
            "frame_time": sample.clip.frame_time,
        }
        written[f"{name}.bvh"] = data
        written[f"truth/{name}.contacts.json"] = encode_json(
            sample.contacts,
            source=source,
            rig={"unit_m": sample.spelling.unit_m, "up": sample.spelling.up},
            detector={"method": "known", "settings": {}},
        )
    return written


def main() -> None:
    """Writes them, or with --check says which differ."""
    differing = [path for path, data in files().items() if _stands(path) != data]
    if "--check" in sys.argv[1:]:
        sys.exit(f"differ: {', '.join(differing)}" if differing else 0)
    for path, data in files().items():
        (HERE / path).parent.mkdir(exist_ok=True)
        (HERE / path).write_bytes(data)


def _stands(path: str) -> bytes:
    return (HERE / path).read_bytes() if (HERE / path).exists() else b""


if __name__ == "__main__":
    main()
