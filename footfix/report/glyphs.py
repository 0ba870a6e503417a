"""A stroke font: each letter as lines on a grid 4 wide and 8 high, for pictures drawn without a font file.

A stroke is a polyline of points, two digits each: x, then y downwards. Capitals reach from 0 to 6, small letters from
2 to 6, descenders down to 8. A stroke of one point is a dot.
"""

from __future__ import annotations

_STROKES = {
    "A": "062046 1434", "B": "060030414233 033344453606", "C": "4130100105163645", "D": "00204244260600",
    "E": "40000646 0333", "F": "400006 0333", "G": "41301001051636454323", "H": "0006 4046 0343", "I": "1030 2026 1636",
    "J": "3035261605", "K": "0006 4004 2246", "L": "000646", "M": "0600234046", "N": "06004640",
    "O": "103041453616050110", "P": "06003041423303", "Q": "103041453616050110 2446", "R": "06003041423303 2346",
    "S": "413010010213334445361605", "T": "0040 2026", "U": "000516364540", "V": "002640", "W": "0016233640",
    "X": "0046 4006", "Y": "002340 2326", "Z": "00400646",
    "a": "4332120305163645 4246", "b": "0006 0312324345361605", "c": "4332120305163645", "d": "4046 4332120305163645",
    "e": "04444332120305163645", "f": "40302126 1242", "g": "4332120305163645 42473818", "h": "0006 0312324346",
    "i": "2226 20", "j": "22271808 20", "k": "0006 4205 2446", "l": "202536", "m": "0206 03122326 23324346",
    "n": "0206 0312324346", "o": "123243453616050312", "p": "0208 0312324345361605", "q": "4248 4332120305163645",
    "r": "0206 03123243", "s": "4212031434453606", "t": "20253646 1242", "u": "0205163645 4246", "v": "022642",
    "w": "0216233642", "x": "0246 4206", "y": "0226 4218", "z": "02420646",
    "0": "103041453616050110 1531", "1": "112026 1636", "2": "01103041420646", "3": "0110304142334445361605 1333",
    "4": "36300444", "5": "400002324345361605", "6": "413010010516364544331304", "7": "004016",
    "8": "103041423313020110 1304051636454433", "9": "423313020110304145361605",
    ".": "26", ",": "2617", ":": "23 26", ";": "23 2617", "!": "2024 26", "?": "011030413224 26", "'": "2021",
    '"': "1011 3031", "-": "1434", "–": "0444", "_": "0747", "/": "4006", "\\": "0046", "|": "2028", "+": "2226 0444",
    "=": "0343 0545", "<": "411443", ">": "013403", "(": "30212536", ")": "10212516", "[": "30101636",
    "]": "10303616", "{": "3020222324262636", "}": "1020222324261626", "%": "4006 01 45", "#": "1116 3136 0343 0545",
    "&": "46110020213103051636 44", "*": "2124 1232 1432", "@": "32121434304145", "~": "04133544", "^": "122032",
    "°": "10201121", "→": "0444 334435", " ": "",
}  # fmt: skip
_UNKNOWN = "0040460600"

Stroke = tuple[tuple[int, int], ...]


def glyph(char: str) -> tuple[Stroke, ...]:
    """Find the strokes of a character; a box where the font has none."""
    return tuple(
        tuple((int(x), int(y)) for x, y in zip(stroke[::2], stroke[1::2], strict=True))
        for stroke in _STROKES.get(char, _UNKNOWN).split()
    )


def advance(char: str) -> float:
    """Measure the distance from a character to the next, in units of the grid."""
    columns = [x for stroke in glyph(char) for x, _ in stroke]
    return max(columns) - min(columns) + 2.0 if columns else 3.0


def width(text: str) -> float:
    """Measure the width of a line of text, in units of the grid."""
    return sum(advance(char) for char in text)


def strokes(text: str) -> list[list[tuple[float, float]]]:
    """Lay out the strokes of a line of text, in units of the grid, from x = 0, the top of capitals at y = 0."""
    lines = []
    at = 0.0
    for char in text:
        shape = glyph(char)
        left = min((x for stroke in shape for x, _ in stroke), default=0)
        lines += [[(at + x - left, float(y)) for x, y in stroke] for stroke in shape]
        at += advance(char)
    return lines
