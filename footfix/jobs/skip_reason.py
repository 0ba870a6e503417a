"""Why a clip is left as it is: its file does not move its legs, or the feet that it shows can't go along with them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from footfix.formats.document import Document
from footfix.notes import Note
from footfix.rig.followers import find_followers, left_behind
from footfix.rig.rig import Rig


def why_left(document: Document, rigs: Sequence[Rig]) -> Note | None:
    """Say why nothing can be done with a clip's feet, or nothing should be; None where they are cleaned.

    A nod that is played over a walk has no say in the legs: given channels for them, it would stop the walk.

    Args:
        document: the file.
        rigs: its figures.
    """
    moved = np.flatnonzero(document.moved)
    legs = [j for rig in rigs for leg in rig.legs for j in (*leg.chain, leg.toe) if j is not None]
    if not np.isin(document.clip.skeleton.with_ancestors(legs), moved).any():
        return Note("legs-not-moved", "nothing in it moves the legs, or the figure as a whole: it is left as it is")
    names = tuple(name for rig in rigs for name in _stranded(document, rig))
    if not names:
        return None
    text = f"its feet hang from {', '.join(names)}, which can't go along with the legs: it is left as it is"
    return Note("feet-not-moved", text, "warning", joints=names)


def _stranded(document: Document, rig: Rig) -> tuple[str, ...]:
    """List the joints outside the legs that are where its feet are, can't go along, and carry their mesh."""
    skin = document.skin
    if skin is None or rig.meshes:
        return ()
    notes = left_behind(document.clip, rig, find_followers(document.clip, rig))
    named = {name for note in notes for name in note.joints}
    bearing = [k for k, name in enumerate(skin.names) if name in named and skin.moved_by(skin.below(k)).any()]
    return tuple(sorted({skin.names[k] for k in bearing}))
