"""Reading glTF: the animations of a file, and one of them as a document."""

from __future__ import annotations

from dataclasses import replace

from footfix.errors import InputError
from footfix.formats.bvh.text import Limits
from footfix.formats.gltf.container import Beside, Container, neighbours, open_container
from footfix.formats.gltf.document import Document
from footfix.formats.gltf.frame_times import grid_of
from footfix.formats.gltf.nodes import joints_of, read_nodes
from footfix.formats.gltf.tracks import WIDTHS, animation_names, morphs_only, read_tracks
from footfix.formats.suffixes import in_file
from footfix.notes import Note

_LIMITS = Limits()
_NAMED = 12  # animations that a message lists


def decode(data: bytes, *, name: str = "", limits: Limits = _LIMITS, beside: Beside | None = None) -> Document:
    """Read one animation of a glTF file.

    Args:
        data: the file.
        name: what it is called, with the animation after a "#": character.glb#Walk. It may be left out where the file
            has one animation.
        limits: beyond these it is refused.
        beside: reads a file that this one names, relative to its folder.

    Raises:
        InputError: it is no glTF, is damaged, packed, or has no such animation.
    """
    file, wanted = in_file(name)
    container = open_container(data, name=file, limits=limits, beside=beside)
    try:
        return _decoded(container, wanted, limits)
    except InputError as error:
        raise (error if error.file else error.within(name)) from None


def clips_of(data: bytes, *, name: str = "", limits: Limits = _LIMITS, beside: Beside | None = None) -> tuple[str, ...]:
    """List the animations of a glTF file by name, without those that change a mesh's shapes alone.

    Raises:
        InputError: it is no glTF, is damaged, packed, or has none.
    """
    container = open_container(data, name=name, limits=limits, beside=beside)
    names = animation_names(container)
    if not names:
        raise InputError("the file holds no animation", file=name, hint="there is no motion to work on")
    return tuple(each for k, each in enumerate(names) if not morphs_only(container, k)) or names


def neighbours_of(
    data: bytes, *, name: str = "", limits: Limits = _LIMITS, beside: Beside | None = None
) -> tuple[str, ...]:
    """List the files that a glTF file names, relative to its folder."""
    return neighbours(open_container(data, name=name, limits=limits, beside=beside).tree)


def glance(head: bytes, *, limits: Limits = _LIMITS) -> None:
    """Look at the first bytes of a large file, so that gigabytes of something else need not be read.

    Raises:
        InputError: it can't be a glTF file.
    """
    if head[:4] != b"glTF" and not head.lstrip(b"\xef\xbb\xbf \t\r\n").startswith(b"{"):
        raise InputError("this is no glTF: it begins neither as a GLB nor as JSON")


def repair(document: Document) -> tuple[bytes, tuple[Note, ...]]:
    """Return the file unchanged: a faulty glTF file is refused when it is read."""
    return document.container.data, ()


def _decoded(container: Container, wanted: str, limits: Limits) -> Document:
    names = animation_names(container)
    if not names:
        raise InputError("the file holds no animation", hint="there is no motion to work on")
    animation = _chosen(container, names, wanted)
    tracks = read_tracks(container, animation)
    moving = {key: track for key, track in tracks.items() if key[1] in WIDTHS}
    nodes = read_nodes(container, limits)
    joints = joints_of(container, nodes, {node for node, _ in moving})
    if not moving or not joints:
        raise InputError("the animation moves no joint")
    if len(joints) > limits.joints:
        raise InputError(f"{len(joints)} joints, more than {limits.joints}", hint="limits.joints allows more")
    grid = grid_of(moving.values(), limits)
    name = f"{container.name}#{names[animation]}" if wanted or len(names) > 1 else container.name
    document = Document(name, container, animation, nodes, joints, tracks, grid)
    return replace(document, notes=_doubts(document))


def _chosen(container: Container, names: tuple[str, ...], wanted: str) -> int:
    if wanted in names:
        return names.index(wanted)
    listed = ", ".join(names[:_NAMED]) + (f" and {len(names) - _NAMED} more" if len(names) > _NAMED else "")
    if wanted:
        same = [k for k, name in enumerate(names) if name.lower() == wanted.lower()]
        if len(same) == 1:
            return same[0]
        raise InputError(f"it has no animation {wanted!r}", hint=f"there are {listed}")
    bodies = [k for k in range(len(names)) if len(names) > 1 and not morphs_only(container, k)]
    if len(bodies) == 1:
        return bodies[0]
    if len(names) > 1:
        raise InputError(f"it holds {len(names)} animations: {listed}", hint=f"name one: FILE#{names[0]}")
    return 0


def _doubts(document: Document) -> tuple[Note, ...]:
    notes = []
    if not document.grid.even:
        step = 1000.0 * document.grid.step
        notes.append(Note(
            "uneven-keys",
            f"keys are at uneven times; the motion is sampled every {step:.1f} ms, and channels that change get keys "
            "at these times",
        ))  # fmt: skip
    if document.crooked:
        names = tuple(document.nodes.names[document.joints[j]] for j in document.crooked)
        said = ", ".join(names[:4]) + (f" and {len(names) - 4} more" if len(names) > 4 else "")
        text = (
            f"scale that changes, is uneven or mirrors, at {said}; what is below stands only roughly where it is shown"
        )
        notes.append(Note("scaled", text, joints=names))
    return tuple(notes)
