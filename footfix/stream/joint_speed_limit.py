"""Limit how much faster than captured joints turn in output frames.

Two rounds of least squares may leave fast steps, and a strike detected late may demand more than a leg can do. The
joints then follow at the greatest allowed speed, and the foot counts as planted only once they have arrived.
"""

from __future__ import annotations

import numpy as np

from footfix.motion import rotation
from footfix.motion.clip import Bools, Floats

FASTEST = 225.0  # [degrees/s] greatest increase of a joint's speed over the captured one


def limited(wanted: Floats, last: Floats, most: float) -> tuple[Floats, Bools]:
    """Limit the speed at which corrections follow the wanted ones.

    From frame to frame a corrected rotation D R turns no farther than D and R do together: so a bound on the steps of D
    bounds how much farther than captured a joint turns.

    Args:
        wanted: (4, L, n, 4) corrections of hip, knee, ankle and toe of each leg.
        last: (4, L, 4) those of the frame before.
        most: [rad] that a correction may turn in a frame.

    Returns:
        (4, L, n, 4) the corrections, and (L, n) in which frames a leg is behind.
    """
    late = np.zeros(wanted.shape[1:3], dtype=np.bool_)
    before = np.concatenate([last[:, :, None], wanted[:, :, :-1]], axis=2)
    # the scalar product of two rotations is the cosine of half the angle between them
    if np.all(np.abs(np.add.reduce(before * wanted, axis=-1)) >= np.cos(0.5 * most)):
        return wanted, late
    out, now = wanted.copy(), last
    for t in range(wanted.shape[2]):
        far = rotation.apart(now, wanted[:, :, t]).max(axis=0)  # (L,)
        late[:, t] = far > most
        reached = rotation.slerp(now, wanted[:, :, t], most / np.maximum(far, most))
        now = np.where(late[:, t, None], reached, wanted[:, :, t])
        out[:, :, t] = now
    return out, late
