"""Models of cycles as `.npz` files: arrays, and one JSON text for all else; nothing in them is pickled."""

from __future__ import annotations

import json
from collections.abc import Mapping
from io import BytesIO
from typing import Any, Literal, cast

import numpy as np

from footfix.errors import FootfixError, InputError
from footfix.locomotion.cycles.eigencycles import Code, GaitSpace, Ramp
from footfix.locomotion.cycles.model import CycleModel, Origin
from footfix.motion.clip import Skeleton
from footfix.rig.rig import Leg, Rig, SolePoint

FORMAT, VERSION = "footfix-cycles", 1
_SPACE = ("mean", "components", "map", "frequency", "contacts", "variance")


def encode_model(model: CycleModel) -> bytes:
    """Write a model."""
    skeleton, rig = model.skeleton, model.rig
    head = {
        "format": FORMAT,
        "version": VERSION,
        "joints": list(skeleton.names),
        "rig": {
            "root": rig.root,
            "pelvis": rig.pelvis,
            "leg_length_m": rig.leg_length,
            "legs": [[leg.name, leg.side, leg.hip, leg.knee, leg.ankle, leg.toe, list(leg.chain)] for leg in rig.legs],
            "soles": [[sole.name, sole.leg, sole.part, sole.joint, sole.offset, sole.held] for sole in rig.soles],
        },
        "styles": list(model.styles),
        "gaits": [
            {"gait": each.gait, "cycles": each.cycles, "low": each.ramp.low, "high": each.ramp.high,
             "degree": each.ramp.degree}
            for each in model.spaces
        ],
        "files": [[each.file, each.sha256, each.cycles, each.style] for each in model.origins],
    }  # fmt: skip
    arrays: dict[str, Any] = {
        "head": np.array(json.dumps(head)),
        "parents": skeleton.parents,
        "offsets_m": skeleton.offsets,
        "end_parents": skeleton.end_parents,
        "end_offsets_m": skeleton.end_offsets,
        "translates": skeleton.translates,
        "rotates": skeleton.rotates,
        "middle": model.code.middle,
        "reach": model.code.reach,
        "levels": model.levels,
        "knees": model.knees,
        "between": model.between,
    }
    for each in model.spaces:
        arrays |= {f"{each.gait}_{name}": getattr(each, name) for name in _SPACE}
    stream = BytesIO()
    np.savez_compressed(stream, **arrays)
    return stream.getvalue()


def decode_model(data: bytes, *, name: str = "") -> CycleModel:
    """Read a model.

    Raises:
        InputError: it is not a model, or is damaged.
    """
    try:
        with np.load(BytesIO(data), allow_pickle=False) as file:
            arrays = {key: file[key] for key in file.files}
        head = json.loads(str(arrays["head"]))
        if head["format"] != FORMAT:
            raise InputError("this is no model of cycles", file=name, hint="footfix cycles fit makes one")
        if head["version"] != VERSION:
            raise InputError(f"a model of version {head['version']}; this footfix reads version {VERSION}", file=name)
        return _model(head, arrays)
    except FootfixError as error:
        if isinstance(error, InputError) and error.file:
            raise
        raise InputError(f"the model is damaged: {error}", file=name) from None
    except Exception as error:
        text = f"this is no model of cycles ({type(error).__name__})"
        raise InputError(text, file=name, hint="footfix cycles fit makes one") from None


def _model(head: Mapping[str, Any], arrays: Mapping[str, Any]) -> CycleModel:
    for key, array in arrays.items():
        if array.dtype.kind == "f" and not np.all(np.isfinite(array)):
            raise InputError(f"{key} holds NaN or infinity")
    skeleton = Skeleton(
        tuple(head["joints"]), arrays["parents"], arrays["offsets_m"], arrays["end_parents"], arrays["end_offsets_m"],
        arrays["translates"], arrays["rotates"],
    )  # fmt: skip
    rig = head["rig"]
    legs = tuple(Leg(a, b, c, d, e, f, tuple(chain)) for a, b, c, d, e, f, chain in rig["legs"])
    soles = tuple(SolePoint(*row[:4], *(at and tuple(at) for at in row[4:])) for row in rig["soles"])
    joints = [j for leg in legs for j in (leg.hip, leg.knee, leg.ankle, leg.toe) if j is not None]
    if not legs or not 0.0 < rig["leg_length_m"] < np.inf or not all(0 <= j < len(skeleton) for j in joints):
        raise InputError("its legs are no joints of its skeleton")
    styles = tuple(head["styles"])
    spaces = []
    for each in head["gaits"]:
        parts = {part: arrays[f"{each['gait']}_{part}"] for part in _SPACE}
        width = 3 + 3 * len(skeleton)
        if parts["mean"].shape[-1] != width or parts["components"].shape[1:] != parts["mean"].shape:
            raise InputError(f"the cycles of the {each['gait']} are not of its {len(skeleton)} joints")
        gait = cast(Literal["walk", "run"], each["gait"])
        ramp = Ramp(each["low"], each["high"], each["degree"])
        spaces.append(GaitSpace(gait=gait, ramp=ramp, styles=styles, cycles=each["cycles"], **parts))
    if not spaces:
        raise InputError("it holds no gait")
    return CycleModel(
        skeleton, Rig(rig["root"], rig["pelvis"], legs, soles, rig["leg_length_m"], 0.0),
        Code(arrays["middle"], arrays["reach"]), tuple(spaces), arrays["levels"], arrays["knees"],
        arrays["between"],
        tuple(Origin(*row) for row in head["files"]),
    )  # fmt: skip
