"""The formats of motion that are read, by the ends of their names: the one table of them."""

# Suffix, in lower case -> the module that reads and writes it (see `footfix.formats.document`).
MOTION: dict[str, str] = {".bvh": "footfix.formats.bvh"}

# What standard input is taken for, since it has no name.
STDIN_NAME = "stdin.bvh"


def is_motion(name: str) -> bool:
    """Whether a file's name says that it holds motion."""
    return name.lower().endswith(tuple(MOTION))


def is_cleaned(name: str) -> bool:
    """Whether a file's name is one that a cleaned copy has: walk.clean.bvh."""
    return name.lower().endswith(tuple(f".clean{suffix}" for suffix in MOTION))


def cleaned_name(name: str) -> str:
    """The name of a cleaned copy beside its input: walk.clean.bvh of walk.bvh."""
    stem, dot, suffix = name.rpartition(".")
    return f"{stem}.clean.{suffix.lower()}" if is_motion(name) else f"{stem if dot else name}.clean.bvh"
