"""Costs of changes to the capture, as standard deviations of the objective's terms (see `terms`)."""

from __future__ import annotations

from dataclasses import dataclass

# r of the objective [Hz]: the standard deviations below are for frames at this rate
RATE = 60.0
UPRIGHT = 0.05  # weight of vertical slip relative to horizontal slip; low, since a foot rolls
NOISY = 3.0  # greatest acceleration allowed for noise, as a multiple of the default, if it may be quick motion
STATIC = 0.03  # [leg lengths/s] of slip up to which static friction holds
LIFTED = 0.01  # [leg lengths] over its floor, above which a planted point is drawn down no harder
GROWN = 0.9  # [m] leg length at which the acceleration defaults hold

# Soft bounds, as standard deviations of the excess.
FLOOR, PLACE, FAR_ROOT, RISE = 0.0022, 0.0011, 0.003, 0.007  # [leg lengths]
KNEE, SPEED, FAR_TURN = 0.3, 0.15, 0.5  # [degrees]
UNNOTICED = 1.3  # faults up to this multiple of `noticed` are hardly noticed
FIRM_TURN = 0.15  # [degrees] as `FAR_TURN`, for faults below `noticed`; it grows to that for hardly noticed ones
TOES = 1.15  # toes may bend this many times as far as other joints for faults below `noticed`, and for hardly
# noticed ones; then more, up to their limit at twice `noticed`
CUT, CUT_ROOT = 0.3, 0.001  # [degrees], [leg lengths] in 1/120 s


@dataclass(frozen=True, kw_only=True)
class CostParams:
    """Costs of changes to the capture, as standard deviations: a change of one costs the same in every term.

    Args:
        slide: cost of slide; a higher cost holds more plants, but the joints turn faster [1/leg length].
        root: of the root's horizontal shift [leg lengths].
        root_height: of the root's vertical shift [leg lengths].
        root_acceleration: of the acceleration of the root's shift [leg lengths/s^2].
        root_farthest: soft bound on the root's shift [leg lengths].
        line: of the direction from hip to ankle [degrees].
        knee: of the knee's flexion [degrees].
        foot: of the foot's orientation in the world [degrees].
        toes: of the toes' bend [degrees].
        line_acceleration: of the angular acceleration of the line from hip to ankle [degrees/s^2].
        knee_acceleration: of the angular acceleration of the knee's flexion [degrees/s^2].
        foot_acceleration: of the angular acceleration of the foot [degrees/s^2].
        toes_acceleration: of the angular acceleration of the toes' bend [degrees/s^2].
        line_farthest: soft bound on the turn of the line from hip to ankle [degrees].
        ankle_farthest: soft bound on the foot's turn relative to the shank, and on the change of flexion [degrees].
        toes_farthest: soft bound on the change of the toes' bend [degrees].
        noticed: smallest fault that viewers notice: 21 mm for an adult (Prazak & O'Sullivan 2011) [leg lengths].
        unnoticed_turn: bound on joint turn for faults below `noticed`; grows in proportion above it; toes reach their
            own bound at twice `noticed` [degrees].
        speed: greatest increase of a joint's speed over the captured one [degrees/s].
        level: of a plant's distance from its floor, for a tenth of a second [leg lengths].
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
