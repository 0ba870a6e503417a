"""Measures of a whole clip: one definition each, with its source."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from footfix.measure.plants import NOTICED_MM, PlantMeasure, measure_plants
from footfix.measure.skinned_joints import posed
from footfix.motion.clip import Clip, Floats
from footfix.motion.contacts import Contacts
from footfix.motion.kinematics import Pose, places
from footfix.rig.rig import Rig

GMD_FPS = 20.0  # of the data sets for which GMD and OmniControl fixed their bounds
WORLD = ("skating_ratio", "weighted_skate_cm_s", "phys_penetrate_mm", "phys_float_mm", "phys_skate_mm")


@dataclass(frozen=True)
class Measures:
    """Measures of a clip; the unit is in the name.

    Read any skate measure together with `coverage`: a foot lifted off the floor does not skate. The measures from the
    literature are defined for ground at rest; on a belt they are None.

    Args:
        plants: contacts counted [count].
        plants_over_21mm: how many of them slide farther than viewers notice (Prazak 2011) [count].
        share_over_21mm: the same, of all plants [share].
        tip_over_21mm: toe plants whose tip slides farther than that, of all toe plants; None where no foot has a tip
            [share].
        slide_mm: the worst plant's slide: farthest horizontal distance of its visible point from its median place [mm].
        slide_median_mm: the median plant's [mm].
        yaw_deg: the worst plant's turn about the vertical [deg].
        coverage: effector-frames in contact, of all [share].
        skate_cm_s: mean horizontal speed of planted feet: of the plants' means, by their lengths [cm/s].
        skate_worst_cm_s: highest horizontal speed of a planted foot [cm/s].
        penetration_mm: deepest of all planted points below their floor [mm].
        float_mm: highest of all planted points above their floor [mm].
        skating_ratio: GMD / OmniControl's foot skating ratio of the toe joints, over all frames [share].
        weighted_skate_cm_s: mean of v (2 - 2^(h / H)) over sole points and frames, H = 3.3 cm [cm/s].
        phys_penetrate_mm: PhysDiff's mean depth of the lowest sole point below the floor, over all frames [mm].
        phys_float_mm: PhysDiff's mean height of the lowest sole point above the floor, over all frames [mm].
        phys_skate_mm: PhysDiff's mean step from frame to frame of sole points that are on the floor [mm].
        jitter_100m_s3: mean third difference of joint positions [10^2 m/s^3].
        peak_acceleration_m_s2: 99.9th percentile of knee and ankle acceleration relative to the pelvis [m/s^2].
        peak_knee_speed_deg_s: 99.9th percentile of the knees' angular speed [deg/s].
    """

    plants: int
    plants_over_21mm: int
    share_over_21mm: float
    tip_over_21mm: float | None
    slide_mm: float
    slide_median_mm: float
    yaw_deg: float
    coverage: float
    skate_cm_s: float
    skate_worst_cm_s: float
    penetration_mm: float
    float_mm: float
    skating_ratio: float | None
    weighted_skate_cm_s: float | None
    phys_penetrate_mm: float | None
    phys_float_mm: float | None
    phys_skate_mm: float | None
    jitter_100m_s3: float
    peak_acceleration_m_s2: float
    peak_knee_speed_deg_s: float


def measure(
    clip: Clip, rig: Rig, contacts: Contacts, *, belt: Floats | None = None
) -> tuple[Measures, tuple[PlantMeasure, ...]]:
    """Measure a clip, given its contacts.

    Args:
        clip: F frames.
        rig: its legs, sole points and floor.
        contacts: which sole points are planted when, in the order of `rig.soles`.
        belt: (F, 3) [m] how far the ground has moved, as under a figure on a treadmill; at rest by default. Plants
            are measured relative to it.

    Returns:
        The measures of the clip, and those of every contact, effector by effector, in order of time.
    """
    pose = posed(clip, rig)
    plants = measure_plants(clip, rig, contacts, pose, belt)
    slides = np.array([plant.slide_mm for plant in plants])
    tips = [plant.tip_slide_mm for plant in plants if plant.tip_slide_mm is not None]
    weights = np.array([max(plant.end - plant.start - 1, 0) for plant in plants])
    speeds = np.array([plant.speed_cm_s for plant in plants])
    on_belt = belt is not None and bool(np.any(belt != 0.0))
    world = dict.fromkeys(WORLD) if on_belt else _in_world(rig, contacts, pose, clip.frame_time)
    return (
        Measures(
            plants=len(plants),
            plants_over_21mm=int(np.sum(slides > NOTICED_MM)),
            share_over_21mm=float(np.mean(slides > NOTICED_MM)) if len(slides) else 0.0,
            tip_over_21mm=float(np.mean(np.array(tips) > NOTICED_MM)) if tips else None,
            slide_mm=float(slides.max(initial=0.0)),
            slide_median_mm=float(np.median(slides)) if len(slides) else 0.0,
            yaw_deg=max((plant.yaw_deg for plant in plants), default=0.0),
            coverage=float(contacts.mask().mean()) if len(clip) and contacts.effectors else 0.0,
            skate_cm_s=float(np.average(speeds, weights=weights)) if weights.sum() else 0.0,
            skate_worst_cm_s=max((plant.peak_speed_cm_s for plant in plants), default=0.0),
            penetration_mm=max((plant.penetration_mm for plant in plants), default=0.0),
            float_mm=max((plant.float_mm for plant in plants), default=0.0),
            **world,
            jitter_100m_s3=jitter(clip),
            peak_acceleration_m_s2=peak_acceleration(rig, pose, clip.frame_time),
            peak_knee_speed_deg_s=peak_knee_speed(rig, pose, clip.frame_time),
        ),
        plants,
    )


def _in_world(rig: Rig, contacts: Contacts, pose: Pose, frame_time: float) -> dict[str, float | None]:
    """Compute the measures of `WORLD`, by name; all of them are defined for a floor at rest."""
    tracks, planted = rig.tracks(pose), contacts.mask()
    toes, rests = [], []
    for e, sole in enumerate(rig.soles):
        if sole.part == "toe":
            toes.append(pose.point(*rig.held_at(sole)))  # (F, 3) [m]
            resting = toes[-1][planted[:, e], 1]
            rests.append(float(np.median(resting)) if len(resting) else -np.inf)  # a toe without rest never skates
    floor = float(rig.floor)
    figures = (
        skating_ratio(toes, rests, frame_time),
        weighted_skate(tracks, floor, frame_time),
        *physdiff(tracks, floor, rig.lowest(pose) if rig.meshes else None),
    )
    return dict(zip(WORLD, figures, strict=True))


def _horizontal_steps(track: Floats) -> Floats:
    """Measure the horizontal distance (F - 1,) [m] of a track (F, 3) [m] from each frame to the next."""
    return np.asarray(np.hypot(np.diff(track[:, 0]), np.diff(track[:, 2])))


def skating_ratio(toes: Sequence[Floats], rests: Sequence[float], frame_time: float) -> float:
    """Measure the share of all frames in which a toe skates.

    A toe skates where it is less than 5 cm above its height at rest, now and in the next frame, and faster than 0.5 m/s
    now and in the mean of 5 frames. Source: GMD (Karunratanakul 2023, `calculate_skating_ratio`) and OmniControl
    (Xie 2024), at the 20 fps of their data: motion at another rate is resampled. They count height from 0, just below
    the toe joints at rest in their data; here each toe has its own height at rest.

    Args:
        toes: (F, 3) [m] the track of each toe joint.
        rests: [m] the height of each of them at rest.
        frame_time: [s].
    """
    seen = [_at_rate(track, frame_time, GMD_FPS) for track in toes]
    if not seen or len(seen[0]) < 2:
        return 0.0
    skates = np.zeros(len(seen[0]) - 1, dtype=np.bool_)
    for track, rest in zip(seen, rests, strict=True):
        speed = GMD_FPS * _horizontal_steps(track)  # [m/s]
        padded = np.pad(speed, 2)
        mean = sum(padded[k : k + len(speed)] for k in range(5)) / 5.0
        low = track[:, 1] - rest < 0.05
        skates |= low[:-1] & low[1:] & (speed > 0.5) & (mean > 0.5)
    return float(skates.mean())


def _at_rate(track: Floats, frame_time: float, fps: float) -> Floats:
    """Resample a track (F, 3) to another frame rate, by linear interpolation."""
    if not len(track):
        return track
    frames = int(np.floor((len(track) - 1) * frame_time * fps + 1e-6)) + 1
    at = np.arange(frames) / (fps * frame_time)
    return np.stack([np.interp(at, np.arange(len(track)), column) for column in track.T], axis=1)


def weighted_skate(tracks: Sequence[Floats], floor: float, frame_time: float, height: float = 0.033) -> float:
    """Measure the mean of v (2 - 2^(h / H)) over sole points and frames [cm/s], for 0 <= h < H; below the floor h is 0.

    Source: Mode-adaptive neural networks (Zhang 2018), H = 3.3 cm as in later code.
    """
    if not tracks or len(tracks[0]) < 2:
        return 0.0
    total = 0.0
    for track in tracks:
        h = np.maximum(track[:-1, 1] - floor, 0.0)
        weight = np.where(h < height, 2.0 - 2.0 ** (np.minimum(h, height) / height), 0.0)
        total += float(np.mean(weight * _horizontal_steps(track)))
    return 100.0 * total / len(tracks) / frame_time


def physdiff(
    tracks: Sequence[Floats], floor: float, lowest: Sequence[Floats] | None = None, tolerance: float = 0.005
) -> tuple[float, float, float]:  # fmt: skip
    """Measure penetrate, float and skate [mm] of PhysDiff (Yuan 2023), over the sole points in place of vertices.

    Penetrate and float are the mean depth and height of the lowest point beyond the tolerance [m], skate
    the mean horizontal step of points at or below the floor in both of two frames.

    Args:
        tracks: (F, 3) [m] of each sole point.
        floor: [m] its height.
        lowest: (F,) [m] heights of the lowest vertices near each sole point, whose minimum replaces that of the sole
            points; empty without a skin.
        tolerance: [m].
    """
    if not tracks or not len(tracks[0]):
        return 0.0, 0.0, 0.0
    heights = np.stack([track[:, 1] for track in tracks]) - floor  # (E, F) [m]
    least = heights.min(axis=0) if lowest is None else np.min(lowest, axis=0) - floor
    penetrate = float(np.mean(np.where(least < -tolerance, -least, 0.0)))
    floating = float(np.mean(np.where(least > tolerance, least, 0.0)))
    steps = np.stack([_horizontal_steps(track) for track in tracks])
    on = (heights[:, :-1] <= tolerance) & (heights[:, 1:] <= tolerance)
    count = on.sum(axis=0)
    skate = np.where(count > 0, (steps * on).sum(axis=0) / np.maximum(count, 1), 0.0)
    return 1000.0 * penetrate, 1000.0 * floating, 1000.0 * float(skate.mean()) if skate.size else 0.0


def jitter(clip: Clip, block: int = 4096) -> float:
    """Measure the mean length of the third difference of joint positions x fps^3 [10^2 m/s^3].

    Source: DNO (Karunratanakul 2024); others divide by 10 in place of 100. Taken in blocks of frames, so that
    an hour of motion needs no more memory than a minute.
    """
    total, count = 0.0, 0
    for start in range(0, len(clip) - 3, block):
        more = jerks(places(clip.frames(slice(start, start + block + 3))))
        total, count = total + more[0], count + more[1]
    return total / count / clip.frame_time**3 / 100.0 if count else 0.0


def jerks(place: Floats) -> tuple[float, int]:
    """Add up the lengths of third differences of places (F, J, 3) [m], and count them."""
    if len(place) < 4:
        return 0.0, 0
    jerk = place[3:] - place[:-3] + 3.0 * (place[1:-2] - place[2:-1])
    total = float(np.sum(np.sqrt(jerk[..., 0] ** 2 + jerk[..., 1] ** 2 + jerk[..., 2] ** 2)))
    return total, jerk.shape[0] * jerk.shape[1]


def peak_acceleration(rig: Rig, pose: Pose, frame_time: float) -> float:
    """Measure the 99.9th percentile of the acceleration of knees and ankles relative to the pelvis [m/s^2]."""
    pelvis = pose.position(rig.pelvis)
    joints = [joint for leg in rig.legs for joint in (leg.knee, leg.ankle)]
    if len(pelvis) < 3 or not joints:
        return 0.0
    bends = [np.diff(pose.position(joint) - pelvis, n=2, axis=0) / frame_time**2 for joint in joints]
    return float(np.percentile(np.linalg.norm(np.stack(bends), axis=-1), 99.9))


def peak_knee_speed(rig: Rig, pose: Pose, frame_time: float) -> float:
    """Measure the 99.9th percentile of the angular speed of knee flexion and extension [deg/s]."""
    speeds = []
    for leg in rig.legs:
        thigh = pose.position(leg.hip) - pose.position(leg.knee)
        shin = pose.position(leg.ankle) - pose.position(leg.knee)
        cross = np.linalg.norm(np.cross(thigh, shin), axis=1)
        bend = np.arctan2(cross, np.einsum("fi,fi->f", thigh, shin))
        speeds.append(np.abs(np.diff(bend)) / frame_time)
    if not speeds or not speeds[0].size:
        return 0.0
    return float(np.degrees(np.percentile(np.concatenate(speeds), 99.9)))
