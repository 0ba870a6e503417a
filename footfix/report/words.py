"""What the words of a report mean, in plain English: for tooltips and for the table of all measures."""

from __future__ import annotations

from collections.abc import Mapping

# Outcome of a plant -> (the word shown, what it means).
OUTCOMES: Mapping[str, tuple[str, str]] = {
    "pinned": ("pinned", "held at one place for as long as it stands"),
    "kept": ("left alone", "it stood still enough, or for too short a time to be held, so it was not touched"),
    "partly": ("held in part", "held at one place in most of its frames; in the others the foot still moves"),
    "released": ("let go", "not held: holding it would bend the motion too much, or the file lacks rotation channels"),
}

# Measure of the report -> what it is.
MEASURES: Mapping[str, str] = {
    "slide_mm": "the farthest that the toe joint, or the ankle of a flat foot, gets from its place in one plant",
    "slide_median_mm": "half of the plants slide less than this",
    "share_over_21mm": "21 mm is what viewers begin to notice",
    "tip_over_21mm": "the same for the tips of the toes",
    "yaw_deg": "how far a planted foot turns about the vertical",
    "skate_cm_s": "how fast planted feet move over the floor, on average",
    "skate_worst_cm_s": "the fastest that a planted foot moves over the floor",
    "coverage": "how much of the clip heels and toes are planted; a slide counts for little where this is small",
    "penetration_mm": "how deep the sole sinks into the floor at worst",
    "float_mm": "how high the sole hovers over the floor at worst",
    "skating_ratio": "share of frames in which a low foot moves fast, as papers on motion synthesis count it",
    "weighted_skate_cm_s": "speed of the feet over the floor, the lower they are the more it counts",
    "phys_penetrate_mm": "mean depth of the lowest point below the floor, over all frames",
    "phys_float_mm": "mean height of the lowest point above the floor, over all frames",
    "phys_skate_mm": "mean way between frames of feet that are on the floor",
    "jitter_100m_s3": "how shaky the motion is: the mean change of acceleration; smooth motion has little",
    "peak_acceleration_m_s2": "the hardest that knees and ankles are sped up or slowed down",
    "peak_knee_speed_deg_s": "the fastest that a knee bends or stretches",
}

# Other words on the page.
PLANT = "a stretch of time in which a heel or a toe stands on the floor"
OFF_TARGET = "the farthest that the sole gets from its place, the frames in which it lands and leaves included"
BELOW_FLOOR = "how deep the sole sinks into the floor while it is planted"
CHANGE = "the joint that cleaning turned most, and when; look there first"
DRIFT = "how far the figure ends from where it ended before"
CLIP_WORSE = "a plant slides farther than before, or a measure of the clip grew noticeably"
WORSE = "slides more than 5 mm farther than it did"


def outcome(key: str) -> str:
    """Translate an outcome to the word shown for it; an unknown one stays as it is."""
    return OUTCOMES[key][0] if key in OUTCOMES else key
