"""The formats of motion that are read, by the ends of their names: the one table of them."""

# Suffix, in lower case -> the module that reads and writes it (see `footfix.formats.document`).
MOTION: dict[str, str] = {".bvh": "footfix.formats.bvh"}

# Formats that people may ask for by a name, and that are not written.
OTHERS = frozenset({".fbx", ".c3d", ".trc", ".glb", ".gltf", ".vrm", ".vrma", ".usd", ".usda", ".usdc"}) - set(MOTION)

# What standard input is taken for, since it has no name.
STDIN_NAME = "stdin.bvh"


def is_motion(name: str) -> bool:
    """Whether a file's name says that it holds motion."""
    return name.lower().endswith(tuple(MOTION))


def is_cleaned(name: str) -> bool:
    """Whether a file's name is one that an output has: walk.clean.bvh, walk.loop.bvh."""
    return name.lower().endswith(tuple(f"{ending}{suffix}" for suffix in MOTION for ending in (".clean", ".loop")))


def cleaned_name(name: str, ending: str = "clean") -> str:
    """The name of an output beside its input: walk.clean.bvh of walk.bvh."""
    stem, dot, suffix = name.rpartition(".")
    return f"{stem}.{ending}.{suffix.lower()}" if is_motion(name) else f"{stem if dot else name}.{ending}.bvh"
