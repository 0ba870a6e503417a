"""A path on the floor: smoothed, with rounded kinks, as a function of arc length."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from footfix.errors import ArgumentError
from footfix.locomotion.follow.pure_pursuit import pursued
from footfix.motion.clip import Bools, Floats, frozen
from footfix.motion.spline import Cubic, spline
from footfix.notes import Note

_SPACING = 0.025  # [m] between points that are smoothed
_MOST = 400_000  # greatest number of points
_SAME = 1e-9  # of a path's length: points nearer than this are equal, lines with less deviation are straight
_CLOSED = 1e-3  # [m] from the last point to the first, where a path is closed
_TAPS = 7  # N_p of K sec. 4
_ROUND = 0.1  # [m] width of the Gaussian in one pass of rounding a kink
_PASSES = 300
_TOO_SHARP = 1.3  # rounding has failed if the curvature is still this multiple of the limit
_ENOUGH = 0.02  # [share] by which a rounded kink may be sharper than asked for
_NOTICED = 0.005  # [m] no note is made on points moved less than this


@dataclass(frozen=True, eq=False)
class Path:
    """A path on the floor as a function of arc length.

    Headings are angles about the vertical, 0 along z, and grow to the left.

    Args:
        points: (N, 2) [m] x and z, evenly spaced along it; of a closed path the last is the first.
        length: [m].
        closed: whether its end continues at its start.
        notes: what was rounded.
    """

    points: Floats
    length: float
    closed: bool
    notes: tuple[Note, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "points", frozen(self.points))

    @cached_property
    def straight(self) -> bool:
        """Tell whether it is a straight line."""
        return not self.closed and _is_straight(self.points)

    @cached_property
    def _spline(self) -> Cubic:
        return spline(np.linspace(0.0, self.length, len(self.points)), self.points, closed=self.closed)

    @cached_property
    def _headings(self) -> tuple[Floats, Floats]:
        """Compute continuous headings [rad] at the points."""
        at = np.linspace(0.0, self.length, len(self.points))
        return at, np.unwrap(np.arctan2(*self._spline(at, 1).T))

    def position(self, s: Floats) -> Floats:
        """Get x and z (..., 2) [m] at arc lengths (...) [m]; an open path continues straight beyond its ends."""
        s = np.asarray(s, dtype=np.float64)
        if self.straight:
            way = (self.points[-1] - self.points[0]) / self.length
            return np.asarray(self.points[0] + s[..., None] * way)
        on, beyond, _ = self._on(s)
        way = self._spline(on, 1)
        way /= np.linalg.norm(way, axis=-1, keepdims=True)
        return np.asarray(self._spline(on) + beyond[..., None] * way)

    def heading(self, s: Floats) -> Floats:
        """Get the heading (...) [rad] at arc lengths (...) [m]."""
        s = np.asarray(s, dtype=np.float64)
        if self.straight:
            return np.full(s.shape, np.arctan2(*(self.points[-1] - self.points[0])))
        on, _, laps = self._on(s)
        at, known = self._headings
        exact = np.arctan2(*np.moveaxis(self._spline(on, 1), -1, 0))
        near = np.interp(on, at, known)
        turns = laps * (known[-1] - known[0]) if self.closed else 0.0
        return np.asarray(exact - 2.0 * np.pi * np.round((exact - near) / (2.0 * np.pi)) + turns)

    def curvature(self, s: Floats) -> Floats:
        """Get the curvature (...) [rad/m], positive to the left, at arc lengths (...) [m]."""
        s = np.asarray(s, dtype=np.float64)
        if self.straight:
            return np.zeros(s.shape)
        on, beyond, _ = self._on(s)
        return np.where(beyond == 0.0, _bent(self._spline, on), 0.0)

    def _on(self, s: Floats) -> tuple[Floats, Floats, Floats]:
        """Split arc lengths into those within the path, the excess beyond its ends [m], and laps of a closed path."""
        if self.closed:
            laps = np.floor(s / self.length)
            return s - laps * self.length, np.zeros_like(s), laps
        on = np.clip(s, 0.0, self.length)
        return on, s - on, np.zeros_like(s)


def make_path(points: Floats, *, sharpest: float = np.inf, kink: float = 0.25 * np.pi) -> Path:
    """Make a path through points: smooth where they lie on a curve, with rounded corners where they turn sharply.

    Points are laid close together and smoothed by a Gaussian over N_p = 7 of them (K sec. 4).

    Args:
        points: (N, 2) [m] x and z.
        sharpest: [rad/m] greatest curvature.
        kink: [rad] turn at a point from which it is a corner.

    Raises:
        ArgumentError: the points do not make a path.
    """
    points = np.asarray(points, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] != 2 or not np.all(np.isfinite(points)):
        raise ArgumentError(f"a path is made of points (N, 2), x and z, all of them numbers, not {points.shape}")
    size = float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum()) if len(points) > 1 else 0.0
    if size < 0.01:
        raise ArgumentError(f"a path needs two different points at least; these lead {size:.3f} m far")
    points = points[np.append(True, np.linalg.norm(np.diff(points, axis=0), axis=1) > _SAME * size)]
    if size / _SPACING > _MOST:
        raise ArgumentError(f"a path of {size / 1000.0:.1f} km is longer than {_MOST * _SPACING / 1000.0:.0f} km")
    if _is_straight(points):
        return Path(points[[0, -1]], float(np.linalg.norm(points[-1] - points[0])), False)
    closed = len(points) > 3 and bool(np.linalg.norm(points[-1] - points[0]) <= _CLOSED)
    if closed:
        points = np.concatenate([points[:-1], points[:1]])
    dense, length = _even(_curve(points, closed, kink), closed)
    smooth = _smoothed(dense, closed, _kernel(1.0, _TAPS // 2))
    rounded = _rounded(smooth, length, closed, sharpest)
    if _sharpest(rounded) > _TOO_SHARP * sharpest:  # it turns back on itself
        rounded, closed = pursued(smooth, length / (len(smooth) - 1), sharpest), False
    even, length = _even(rounded, closed)
    even, length = _even(even, closed)
    return Path(even, length, closed, _told(smooth, rounded, sharpest))


def _sharpest(points: Floats) -> float:
    """Find the sharpest turn from one of points (N, 2) to the next [rad/m], cusps too."""
    ways = np.diff(points, axis=0)
    turn = np.diff(np.arctan2(*ways.T))
    turn = np.abs(turn - 2.0 * np.pi * np.round(turn / (2.0 * np.pi)))
    return float((turn / np.maximum(0.5 * np.linalg.norm(ways[1:] + ways[:-1], axis=1), 1e-3)).max(initial=0.0))


def _is_straight(points: Floats) -> bool:
    """Tell whether points (N, 2) lie on a line, one after the other."""
    whole = points[-1] - points[0]
    size = float(np.linalg.norm(whole))
    if size == 0.0:
        return False
    way = whole / size
    off = (points - points[0]) @ np.array([way[1], -way[0]])
    on = (points - points[0]) @ way
    return bool(np.abs(off).max() <= _SAME * size and np.all(np.diff(on) > 0.0))


def _bent(curve: Cubic, at: Floats) -> Floats:
    """Compute the curvature to the left of a spline of x and z, (...) [rad/m]."""
    (dx, dz), (ddx, ddz) = (np.moveaxis(curve(at, k), -1, 0) for k in (1, 2))
    return np.asarray((ddx * dz - dx * ddz) / np.maximum(np.hypot(dx, dz), 1e-12) ** 3)


def _curve(points: Floats, closed: bool, kink: float) -> Floats:
    """Lay points (M, 2) close together: on splines through those of a curve, on lines to and from corners."""
    ways = np.diff(points, axis=0)
    heading = np.arctan2(*ways.T)
    turn = np.diff(heading)
    corner = np.abs(turn - 2.0 * np.pi * np.round(turn / (2.0 * np.pi))) > kink
    cuts = [0, *(np.flatnonzero(corner) + 1).tolist(), len(points) - 1]
    if closed and len(cuts) == 2 and len(points) > 4:
        return _dense(points, True)
    pieces = [_dense(points[a : b + 1], False) for a, b in pairwise(cuts)]
    return np.concatenate([pieces[0], *(each[1:] for each in pieces[1:])])


def _dense(points: Floats, closed: bool) -> Floats:
    """Lay points (M, 2) a tenth of the spacing apart on a spline through points (N, 2), or on the line between two."""
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    at = np.append(0.0, np.cumsum(steps))
    many = max(int(np.ceil(10.0 * at[-1] / _SPACING)), 10) + 1
    wanted = np.linspace(0.0, at[-1], min(many, 4 * _MOST))
    if len(points) == 2:
        return np.asarray(points[0] + np.outer(wanted / at[-1], points[1] - points[0]))
    return spline(at, points, closed=closed)(wanted)


def _even(points: Floats, closed: bool) -> tuple[Floats, float]:
    """Lay points (M, 2) evenly by arc length on a spline through points (N, 2), and measure its length [m]."""
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    points, steps = points[np.append(True, steps > 0.0)], steps[steps > 0.0]
    knots = np.append(0.0, np.cumsum(steps))
    curve = spline(knots, points, closed=closed)
    part = np.linspace(0.0, 1.0, 5)[:-1]
    fine = np.append((knots[:-1, None] + part * np.diff(knots)[:, None]).ravel(), knots[-1])
    speed = np.linalg.norm(curve(fine, 1), axis=1)
    middle = np.linalg.norm(curve(0.5 * (fine[1:] + fine[:-1]), 1), axis=1)
    far = np.append(0.0, np.cumsum(np.diff(fine) * (speed[:-1] + 4.0 * middle + speed[1:]) / 6.0))  # Simpson
    length = float(far[-1])
    wanted = np.linspace(0.0, length, max(int(np.ceil(length / _SPACING)), 8) + 1)
    out = curve(np.interp(wanted, far, fine))
    if closed:
        out[-1] = out[0]
    return out, length


def _kernel(width: float, reach: int) -> Floats:
    """Compute a Gaussian of a width in points, (2 reach + 1,)."""
    weights = np.exp(-0.5 * (np.arange(-reach, reach + 1) / width) ** 2)
    return np.asarray(weights / weights.sum())


def _smoothed(points: Floats, closed: bool, kernel: Floats) -> Floats:
    """Smooth points (N, 2); the ends of an open path, and straight lines, stay where they are."""
    reach = min(len(kernel) // 2, len(points) - 2)
    kernel = kernel[len(kernel) // 2 - reach : len(kernel) // 2 + reach + 1]
    kernel = kernel / kernel.sum()
    if closed:
        around = np.concatenate([points[-1 - reach : -1], points, points[1 : reach + 1]])
    else:
        before = 2.0 * points[0] - points[reach:0:-1]
        after = 2.0 * points[-1] - points[-2 : -2 - reach : -1]
        around = np.concatenate([before, points, after])
    return np.stack([np.convolve(each, kernel, mode="valid") for each in around.T], axis=1)


def _rounded(points: Floats, length: float, closed: bool, sharpest: float) -> Floats:
    """Smooth points (N, 2) again and again around places that are bent more sharply than allowed."""
    step = length / (len(points) - 1)
    kernel = _kernel(_ROUND / step, int(np.ceil(3.0 * _ROUND / step)))
    touched = np.zeros(len(points), dtype=np.bool_)
    for turn in range(_PASSES):
        curve = spline(np.linspace(0.0, length, len(points)), points, closed=closed)
        sharp: Bools = np.asarray(np.abs(_bent(curve, curve.at)) > (1.0 + _ENOUGH) * sharpest)
        if not sharp.any():
            break
        touched |= sharp
        around = int(np.ceil(_ROUND * (3.0 + 2.0 * np.sqrt(turn + 1.0)) / step))
        mask = _spread(touched, around, closed)[:, None]
        points = points + mask * (_smoothed(points, closed, kernel) - points)
    return points


def _spread(mask: Bools, around: int, closed: bool) -> Floats:
    """Compute weights (N,) that are 1 at True and fall smoothly to 0 within `around` points."""
    around = max(1, min(around, (len(mask) - 1) // 2))
    window = np.hanning(2 * around + 3)[1:-1]
    where = np.flatnonzero(mask)
    out = np.zeros(len(mask))
    for k in np.unique(np.concatenate([where[:1], where[-1:], where[:: max(1, around // 4)]])):
        at = np.arange(k - around, k + around + 1)
        inside = np.ones(len(at), dtype=np.bool_) if closed else (at >= 0) & (at < len(mask))
        at = at % (len(mask) - 1) if closed else at
        np.maximum.at(out, at[inside], window[inside])
    if closed:
        out[-1] = out[0]
    return out


def _told(before: Floats, after: Floats, sharpest: float) -> tuple[Note, ...]:
    """Make a note on what rounding has moved."""
    if len(after) != len(before):
        text = f"the path turns back on itself; turns of {1.0 / sharpest:.2f} m of radius lead round there"
        return (Note("kinks-rounded", text),)
    off = np.linalg.norm(after - before, axis=1)
    if off.max() < _NOTICED:
        return ()
    moved: NDArray[np.bool_] = off >= _NOTICED
    places = int(np.count_nonzero(np.diff(np.append(False, moved).astype(int)) == 1))
    kinks = "a kink of the path is" if places == 1 else f"{places} kinks of the path are"
    text = f"{kinks} rounded to a radius of {1.0 / sharpest:.2f} m, which moves the path by up to {off.max():.2f} m"
    return (Note("kinks-rounded", text),)
