"""The skin that the settings name, read once a process for all clips that use it."""

from __future__ import annotations

import os
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

from footfix.batch.file_io import read_whole
from footfix.errors import InputError
from footfix.rig.params import NO_SKIN

if TYPE_CHECKING:
    from footfix.rig.skin import Skin
    from footfix.settings import Settings


def skin_for(settings: Settings, folder: str | os.PathLike[str] = "") -> Skin | None:
    """Read the character that `rig.skin` names; None where it names none, or says that there is none.

    Args:
        settings: the parameters of all steps.
        folder: of relative paths.

    Raises:
        InputError: it can't be read, or shows no mesh.
    """
    if settings.rig.skin in (None, NO_SKIN):
        return None
    path = Path(folder, str(settings.rig.skin))
    try:
        stamp = path.stat()
    except OSError as error:
        raise InputError(f"the skin can't be read: {error.strerror}", file=settings.rig.skin) from None
    return _read(path, stamp.st_mtime_ns, stamp.st_size, settings.limits.bytes)


@lru_cache(maxsize=4)
def _read(path: Path, changed: int, size: int, most: int) -> Skin:
    from footfix.formats.gltf.mesh import read_skin

    def beside(name: str) -> bytes:
        return read_whole(path.parent / name, most)

    return read_skin(read_whole(path, most), name=path.name, beside=beside)
