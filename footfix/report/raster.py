"""Lines and text drawn on pixels, and pixels as a PNG file: all that a small still picture needs."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from footfix.motion.clip import Floats
from footfix.report import glyphs

Color = tuple[float, float, float]


def color(code: str) -> Color:
    """Convert a colour from its hexadecimal code, "#0069a8"."""
    return tuple(int(code[k : k + 2], 16) / 255.0 for k in (1, 3, 5))  # type: ignore[return-value]


class Raster:
    """Pixels to draw antialiased lines on; coordinates begin at the top left corner.

    Args:
        width, height: in pixels.
        ground: the colour it starts with.
    """

    def __init__(self, width: int, height: int, ground: Color) -> None:
        self.pixels: Floats = np.empty((height, width, 3))
        self.pixels[...] = ground

    def line(
        self, places: Sequence[tuple[float, float]] | Floats, thick: float, ink: Color, alpha: float = 1.0
    ) -> None:
        """Draw a line through places (n, 2) with round ends; a single place gives a dot."""
        points = np.asarray(places, dtype=np.float64).reshape(-1, 2)
        if len(points) == 1:
            points = points.repeat(2, axis=0)
        reach = thick / 2.0 + 1.0
        low = np.floor(points.min(axis=0) - reach).astype(int).clip(0)
        high = np.ceil(points.max(axis=0) + reach).astype(int) + 1
        window = self.pixels[low[1] : high[1], low[0] : high[0]]
        if not window.size:
            return
        cover = np.zeros(window.shape[:2])
        for a, b in pairwise(points):
            self._segment(cover, a - low, b - low, thick)
        window += (alpha * cover)[..., None] * (np.asarray(ink) - window)

    @staticmethod
    def _segment(cover: Floats, a: Floats, b: Floats, thick: float) -> None:
        """Raise the coverage of pixels near a segment: 1 within it, falling to 0 over one pixel."""
        reach = thick / 2.0 + 1.0
        x0, y0 = np.floor(np.minimum(a, b) - reach).astype(int).clip(0)
        x1, y1 = np.ceil(np.maximum(a, b) + reach).astype(int) + 1
        part = cover[y0:y1, x0:x1]
        y, x = np.mgrid[y0 : y0 + part.shape[0], x0 : x0 + part.shape[1]] + 0.5
        along = b - a
        length = float(along @ along)
        u = np.clip(((x - a[0]) * along[0] + (y - a[1]) * along[1]) / length, 0.0, 1.0) if length else np.zeros_like(x)
        distance = np.hypot(x - a[0] - u * along[0], y - a[1] - u * along[1])
        np.maximum(part, np.clip(thick / 2.0 + 0.5 - distance, 0.0, 1.0), out=part)

    def circle(self, x: float, y: float, radius: float, thick: float, ink: Color, dashes: int = 0) -> None:
        """Draw a circle, solid or with a number of dashes."""
        turns = np.linspace(0.0, 2.0 * np.pi, 4 * max(dashes, 16) + 1)
        around = np.stack([x + radius * np.cos(turns), y + radius * np.sin(turns)], axis=1)
        if not dashes:
            self.line(around, thick, ink)
        for k in range(dashes):
            self.line(around[4 * k : 4 * k + 3], thick, ink)

    def write(self, text: str, x: float, y: float, size: float, ink: Color, *, bold: bool = False) -> None:
        """Write a line of text; its capitals are `size` pixels high, their top at `y`."""
        unit = size / 6.0
        for stroke in glyphs.strokes(text):
            places = np.asarray(stroke) * unit + (x, y)
            self.line(places, unit * (1.15 if bold else 0.8) + 0.25, ink)

    def png(self) -> bytes:
        """Encode the picture as a PNG file."""
        height, width, _ = self.pixels.shape
        levels = np.rint(np.clip(self.pixels, 0.0, 1.0) * 255.0).astype(np.uint8).reshape(height, 3 * width)
        rows = np.concatenate([np.zeros((height, 1), np.uint8), levels], axis=1)  # no filter in any row
        header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)  # 8 bits, red green blue
        chunks = ((b"IHDR", header), (b"IDAT", zlib.compress(rows.tobytes(), 9)), (b"IEND", b""))
        return b"\x89PNG\r\n\x1a\n" + b"".join(
            struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
            for kind, data in chunks
        )


def fitted(text: str, size: float, width: float) -> str:
    """Cut the text with dots where it would be wider than `width` pixels at this size."""
    room = width * 6.0 / size
    if glyphs.width(text) <= room:
        return text
    while text and glyphs.width(text + "...") > room:
        text = text[:-1]
    return text + "..."
