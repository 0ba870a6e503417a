"""When heel and toe of each foot are planted.

The package can be called: `footfix.detect(clip, rig)` is `footfix.detect.run.detect(clip, rig)`.
"""

from __future__ import annotations

import sys
from types import ModuleType
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from footfix.detect.run import DetectParams
    from footfix.motion.clip import Clip
    from footfix.motion.contacts import Contacts
    from footfix.rig.rig import Rig


class _Detect(ModuleType):
    """This package as a function of the API."""

    def __call__(self, clip: Clip, rig: Rig, params: DetectParams | None = None) -> Contacts:
        from footfix.detect import run

        return run.detect(clip, rig, run.DetectParams() if params is None else params)


# Importing any module in here sets `footfix.detect` to this package, in the place of the function of that
# name: the package answers for both.
sys.modules[__name__].__class__ = _Detect
