"""From the bytes of clips to a model of the cycles of their figure. No file is read or written here."""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from footfix.enforce.task import ground_of
from footfix.errors import InputError
from footfix.formats.document import Beside
from footfix.jobs.contacts import find_contacts
from footfix.jobs.source import about, read
from footfix.locomotion.cycles.fit import make_model
from footfix.locomotion.cycles.fit_space import SpaceParams
from footfix.locomotion.cycles.leave_out import LeftOut
from footfix.locomotion.cycles.model import CycleModel, Origin
from footfix.locomotion.cycles.samples import Sample, SampleParams, sample_cycles
from footfix.motion.clip import Floats, Skeleton
from footfix.motion.lead_in import motion_range
from footfix.pipeline import prepare
from footfix.report.document import rounded
from footfix.rig.find import find_rigs
from footfix.rig.rig import Rig
from footfix.settings import Settings

FEWEST = 20  # cycles that a gait needs
_APART = 1.05  # speeds whose ratio is less count as one
_SAME_REST = 0.97  # cosine between the rest offsets of a joint in two files of one skeleton


@dataclass(frozen=True, eq=False)
class FileCycles:
    """The cycles of one file.

    Args:
        name: of the file.
        sha256: of its bytes.
        skeleton, rig: its figure.
        samples: its cycles.
        left_out: reason -> how many strides were left out for it.
    """

    name: str
    sha256: str
    skeleton: Skeleton
    rig: Rig
    samples: tuple[Sample, ...]
    left_out: Mapping[str, int]

    @property
    def summary(self) -> str:
        """Describe the cycles that were found in words."""
        count = len(self.samples)
        text = f"{count} {'cycle' if count == 1 else 'cycles'}"
        if self.samples:
            froude = float(np.sqrt(9.81 * self.rig.leg_length))
            for gait in ("walk", "run"):
                speeds = [each.speed * froude for each in self.samples if each.gait == gait]
                if speeds:
                    text += f", {gait} {min(speeds):.2f} to {max(speeds):.2f} m/s"
        reasons = ", ".join(f"{n} x {reason}" for reason, n in self.left_out.items())
        return text + (f" (left out: {reasons})" if reasons else "")


@dataclass(frozen=True, eq=False)
class Fitted:
    """A model and how it was fitted.

    Args:
        model: the model.
        error: of the file left out.
        skipped: name -> why a file's cycles are not in it.
    """

    model: CycleModel
    error: LeftOut
    skipped: Mapping[str, str]


def cycles_of_file(
    data: bytes, name: str, settings: Settings, *, style: str = "", beside: Beside | None = None
) -> FileCycles:
    """Find the straight cycles of a clip.

    Args:
        data: the bytes of the file.
        name: its name.
        settings: how figures and contacts are found.
        style: the style of its cycles.
        beside: reads files that it names.

    Raises:
        InputError: the clip can't be used; says why.
    """
    document = read(data, name, settings, beside=beside)
    if len(document.clip) < 8:
        raise InputError(f"{len(document.clip)} frames are too few for a stride", file=name)
    with about(name):
        frame_range = motion_range(document.clip)
        rigs = find_rigs(document.clip, settings.rig, frame_range)
        if len(rigs) > 1:
            raise InputError(f"the file holds {len(rigs)} figures; cycles are learnt from one")
        prepared = prepare(document.clip, settings, rigs, frame_range)
        crop, (rig,) = prepared.crops[0], rigs
        contacts = crop.contacts(find_contacts(prepared, settings, None))
        clip = crop.clip(prepared.clip)
        ground = ground_of(clip, rig, contacts, settings.enforce.ground)
        found = sample_cycles(clip, rig, contacts, ground, SampleParams())
    samples = tuple(
        replace(s, source=name, style=style, start=s.start + crop.start, end=s.end + crop.start) for s in found.samples
    )
    return FileCycles(name, hashlib.sha256(data).hexdigest(), document.clip.skeleton, rig, samples, found.left_out)


def fit_files(files: Sequence[FileCycles], *, components: int | None = None) -> Fitted:
    """Fit a model to the cycles of files.

    Args:
        files: their cycles; only those of the skeleton with most cycles are used.
        components: how many principal components a gait keeps at most.

    Raises:
        InputError: there are too few cycles; says what was found.
    """
    useful = [each for each in files if each.samples]
    if not useful:
        raise InputError(f"no straight, steady cycle of a walk or run in {len(files)} files", hint=_NEEDED)
    votes = Counter[tuple[Any, ...]]()
    for each in useful:
        votes[_tree(each.skeleton)] += len(each.samples)
    (tree, _), *_ = votes.most_common(1)
    first = max((each for each in useful if _tree(each.skeleton) == tree), key=lambda each: len(each.samples))
    skipped, taken = dict[str, str](), list[FileCycles]()
    for each in useful:
        why = _unlike(each.skeleton, first.skeleton)
        if why:
            skipped[each.name] = why
        else:
            taken.append(each)
    samples, few = _enough(taken)
    typical = sorted(taken, key=lambda each: each.rig.leg_length)[len(taken) // 2]
    names = sorted({each.style for each in samples} - {""})
    params = SpaceParams() if components is None else SpaceParams(components=components)
    used = Counter(each.source for each in samples)
    origins = [
        Origin(each.name, each.sha256, used[each.name], each.samples[0].style) for each in taken if used[each.name]
    ]
    model, error = make_model(typical.skeleton, typical.rig, samples, names, params, origins)
    return Fitted(model, error, skipped | few)


_NEEDED = f"a gait needs {FEWEST} cycles, of at least two speeds"


def _enough(files: Sequence[FileCycles]) -> tuple[list[Sample], dict[str, str]]:
    """Choose the gaits with enough cycles; return their cycles, and a sentence on each other gait."""
    samples, told, few = list[Sample](), list[str](), dict[str, str]()
    for gait in ("walk", "run"):
        own = [each for file in files for each in file.samples if each.gait == gait]
        speeds = sorted(each.speed for each in own)
        distinct = _distinct(speeds)
        froude = float(np.sqrt(9.81 * files[0].rig.leg_length)) if files else 1.0
        text = f"{gait}: {len(own)} cycles"
        if own:
            text += f" of {distinct} {'speed' if distinct == 1 else 'speeds'}, {speeds[0] * froude:.2f} to "
            text += f"{speeds[-1] * froude:.2f} m/s"
        told.append(text)
        if len(own) >= FEWEST and distinct >= 2:
            samples += own
        elif own:
            few[f"the {gait}"] = f"left out, with {text.removeprefix(gait + ': ')}: {_NEEDED}"
    if not samples:
        raise InputError(f"too few cycles to learn from; {', '.join(told)}", hint=_NEEDED)
    return samples, few


def _distinct(speeds: Sequence[float]) -> int:
    """Count sorted speeds that differ from one another by at least a twentieth."""
    count, last = 0, 0.0
    for speed in speeds:
        if speed > _APART * last:
            count, last = count + 1, speed
    return count


def _tree(skeleton: Skeleton) -> tuple[Any, ...]:
    return skeleton.names, tuple(skeleton.parents.tolist())


def _unlike(one: Skeleton, other: Skeleton) -> str:
    """Say why two skeletons differ; "" where they are the same but for size."""
    if _tree(one) != _tree(other):
        return f"another skeleton, of {len(one)} joints, than most files have"
    sizes: list[Floats] = [np.linalg.norm(each.offsets, axis=1) for each in (one, other)]
    bones = np.minimum(*sizes) > 0.05 * max(float(sizes[1].max()), 1e-9)
    bones &= one.parents >= 0
    cosine = np.einsum("ji,ji->j", one.offsets, other.offsets)[bones] / (sizes[0] * sizes[1])[bones]
    if np.any(cosine < _SAME_REST):
        joint = np.array(one.names)[bones][int(np.argmin(cosine))]
        return f"{joint} rests in another direction than in most files, so that its angles mean something else"
    return ""


def fit_entry(fitted: Fitted) -> dict[str, Any]:
    """Describe a fit as a document; each key carries its unit."""
    model, error = fitted.model, fitted.error
    return {
        "joints": len(model.skeleton),
        "leg_length_m": rounded(model.rig.leg_length),
        "styles": list(model.styles),
        "gaits": [
            {
                "gait": each.gait,
                "cycles": each.cycles,
                "slowest_m_s": rounded(each.ramp.low * model.froude),
                "fastest_m_s": rounded(each.ramp.high * model.froude),
                "components": len(each.components),
                "variance": rounded(float(each.variance.sum())),
                "degree": each.ramp.degree,
            }
            for each in model.spaces
        ],
        "file_left_out": {
            "cycles": error.cycles,
            "error_mm": rounded(1000.0 * error.predicted),
            "nearest_real_cycle_mm": rounded(1000.0 * error.nearest),
            "mean_cycle_mm": rounded(1000.0 * error.mean),
            "frequency_error": rounded(error.frequency),
        }
        if error.cycles
        else None,
        "files": [{"file": each.file, "cycles": each.cycles, "style": each.style} for each in model.origins],
        "skipped": dict(fitted.skipped),
    }
