"""BVH files: read without loss; on writing, only the numbers that changed are replaced."""

from footfix.formats.bvh.compose import compose
from footfix.formats.bvh.document import Document
from footfix.formats.bvh.new_motion import with_motion
from footfix.formats.bvh.read import decode, glance
from footfix.formats.bvh.repair import repair
from footfix.formats.bvh.select_frames import select_frames
from footfix.formats.bvh.text import Limits
from footfix.formats.bvh.unseparated_numbers import separate_numbers
from footfix.formats.bvh.write import encode, rewrite

__all__ = [
    "Document", "Limits", "compose", "decode", "encode", "glance", "repair", "rewrite", "select_frames",
    "separate_numbers", "with_motion",
]  # fmt: skip
