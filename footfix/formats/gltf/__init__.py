"""glTF: GLB, .gltf, VRM and VRM animation, read strictly and written with only those channels new that changed."""

from footfix.formats.gltf.document import Document
from footfix.formats.gltf.read import clips_of, decode, glance, neighbours_of, repair
from footfix.formats.gltf.select_frames import annotated, joined, select_frames
from footfix.formats.gltf.write import rewrite

__all__ = [
    "Document", "annotated", "clips_of", "decode", "glance", "joined", "neighbours_of", "repair", "rewrite",
    "select_frames",
]  # fmt: skip
