"""What each departure from the capture costs: the standard deviations of the objective's terms (`terms`)."""

from __future__ import annotations

from dataclasses import dataclass

# r of the objective: the standard deviations below are those of independent frames, so many a second
RATE = 60.0
UPRIGHT = 0.05  # weight of slip up and down against slip over the floor: a foot rolls
NOISY = 3.0  # times a cost's acceleration that noise may add to it, if it may be quick motion, too
STATIC = 0.03  # [leg lengths/s] of slip up to which static friction holds
GROWN = 0.9  # [m] leg length of the figure whose accelerations the defaults are

# Bounds, as standard deviations of what is beyond them.
FLOOR, PLACE, FAR_ROOT = 0.0033, 0.0011, 0.003  # [leg lengths]
KNEE, SPEED, FAR_TURN = 0.3, 0.15, 0.5  # [degrees]
TOES = 1.15  # times as far as other joints toes bend for what is not noticed,
TOES_FREE = 1.3  # and up to so many times as much; then more and more, as far as they may for twice as much
CUT, CUT_ROOT = 0.3, 0.001  # [degrees], [leg lengths] in 1/120 s


@dataclass(frozen=True, kw_only=True)
class CostParams:
    """What each departure from the capture costs: standard deviations, each of which costs as much as another.

    Args:
        slide: cost of slide; more holds more, at the price of the joints' speed [1/leg length].
        root: of the root over the floor [leg lengths].
        root_height: of the root up and down [leg lengths].
        root_acceleration: of the root's acceleration [leg lengths/s^2].
        root_farthest: beyond this the root hardly goes [leg lengths].
        line: of the line from hip to ankle [degrees].
        knee: of the knee's flexion [degrees].
        foot: of the foot in the world [degrees].
        toes: of the toes' bend [degrees].
        line_acceleration: of that line's acceleration [degrees/s^2].
        knee_acceleration: of that of the knee's flexion [degrees/s^2].
        foot_acceleration: of that of the foot [degrees/s^2].
        toes_acceleration: of that of the toes' bend [degrees/s^2].
        line_farthest: beyond this the line from hip to ankle hardly turns [degrees].
        ankle_farthest: beyond this the foot hardly turns against the shank, and the knee hardly bends [degrees].
        toes_farthest: beyond this the toes hardly bend [degrees].
        noticed: a fault that viewers notice: 21 mm of a grown-up (Prazak & O'Sullivan 2011) [leg lengths].
        unnoticed_turn: farther than this a joint hardly turns for a smaller fault; for more, in proportion; toes as far
            as they may for twice as much [degrees].
        speed: by which a joint may turn faster than captured [degrees/s].
        level: of a plant from its floor, in a tenth of a second [leg lengths].
    """

    slide: float = 11000.0
    root: float = 0.09
    root_height: float = 0.055
    root_acceleration: float = 1.1
    root_farthest: float = 0.06
    line: float = 5.0
    knee: float = 3.0
    foot: float = 4.5
    toes: float = 15.0
    line_acceleration: float = 200.0
    knee_acceleration: float = 200.0
    foot_acceleration: float = 300.0
    toes_acceleration: float = 1000.0
    line_farthest: float = 12.0
    ankle_farthest: float = 25.0
    toes_farthest: float = 40.0
    noticed: float = 0.023
    unnoticed_turn: float = 2.0
    speed: float = 130.0
    level: float = 0.0045
