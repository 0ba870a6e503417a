"""The door of enforcement: what it leaves as it is, and what it says."""

from __future__ import annotations

from dataclasses import replace

import artefacts
import numpy as np
from walks import rig_of
from walks import short_walk as walk

from footfix.enforce.correction import apply
from footfix.enforce.params import EnforceParams
from footfix.enforce.run import enforce
from footfix.enforce.style import StyleParams


def test_a_clip_that_enforcement_made_is_left_as_it_is_whatever_is_asked_of_it() -> None:
    made = walk(duration=2.0)
    rig = rig_of(made)
    clip = artefacts.wander(made.clip, 0.05)
    effectors = tuple(
        replace(e, contacts=tuple(replace(c, wish="force", position=(9.0, 0.0, 9.0)) for c in e.contacts))
        for e in made.contacts.effectors
    )
    style = EnforceParams(style=StyleParams(toe_out={"left": 15.0}))
    for params in (EnforceParams(), EnforceParams(method="root"), EnforceParams(solver="glardon"), style):
        found = enforce(clip, rig, replace(made.contacts, effectors=effectors), params, leave=True)
        after = apply(clip, found.correction)
        assert np.array_equal(after.rotations, clip.rotations) and np.array_equal(after.positions, clip.positions)
        assert {plant.outcome for plant in found.plants} == {"kept"}
        assert not any(plant.force or plant.asked for plant in found.plants)
