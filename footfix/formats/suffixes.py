"""The table of motion formats by file name suffix."""

from __future__ import annotations

from pathlib import PurePath

# Suffix, in lower case -> the module that reads and writes it (see `footfix.formats.document`).
MOTION: dict[str, str] = {
    ".bvh": "footfix.formats.bvh",
    ".glb": "footfix.formats.gltf",
    ".gltf": "footfix.formats.gltf",
    ".vrm": "footfix.formats.gltf",
    ".vrma": "footfix.formats.gltf",
}

# Infixes of output names: walk.clean.bvh.
_OWN = (".clean", ".loop", ".events")

# Formats that an output name may ask for but that are not written.
OTHERS = frozenset({".fbx", ".c3d", ".trc", ".glb", ".gltf", ".vrm", ".vrma", ".usd", ".usda", ".usdc"}) - set(MOTION)

# The name used for standard input.
STDIN_NAME = "stdin.bvh"


def is_motion(name: str) -> bool:
    """Tell whether a file's name says that it holds motion."""
    return name.lower().endswith(tuple(MOTION))


def in_file(name: str) -> tuple[str, str]:
    """Split the name of a clip into file name and clip name, as in character.glb#Walk.

    Returns:
        The file, and the clip in it; "" where the name is that of a file.
    """
    file, mark, clip = name.partition("#")
    while mark and not is_motion(file):  # a folder's or a file's own name may have one, too
        more, mark, clip = clip.partition("#")
        file = f"{file}#{more}"
    return (file, clip) if mark else (name, "")


def bare(name: str) -> str:
    """Give a clip's name without the folders of its file."""
    file, clip = in_file(name)
    return PurePath(file).name + (f"#{clip}" if clip else "")


def is_cleaned(name: str) -> bool:
    """Tell whether a file's name is one that an output has: walk.clean.bvh, walk.loop.bvh."""
    return name.lower().endswith(tuple(f"{ending}{suffix}" for suffix in MOTION for ending in _OWN))


def cleaned_name(name: str, ending: str = "clean") -> str:
    """Name an output beside its input: walk.clean.bvh of walk.bvh."""
    stem, dot, suffix = name.rpartition(".")
    return f"{stem}.{ending}.{suffix.lower()}" if is_motion(name) else f"{stem if dot else name}.{ending}.bvh"
