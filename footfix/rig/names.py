"""Read a joint's side and part of the body from its name."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import lru_cache

# The parts that are needed. A joint is named after the bone below it, or after itself: LeftUpLeg and
# LeftHip are both at the top of the thigh.
_PARTS = {
    "toe": r"toe|forefoot|ball|metatars|phalan|tsumasaki|つま先|足先|爪先|脚趾|脚尖",
    "heel": r"heel|calcane|かかと|踵",
    "ankle": r"ankle|foot|feet|hoof|paw$|足首|脚踝|脚腕|hock",
    "knee": r"knee|shin|calf|crus|lo(w|wer)?leg|legl(o|ow|ower)$|tibia|ひざ|膝|小腿|すね",
    "thigh": r"thigh|upp?(er)?leg|legup(per)?$|femur|大腿|太もも|もも|hip$|hip(pitch|yaw|roll)|股",
    "leg": r"leg|足|脚|腿",
    "arm": r"arm|hand|wrist|elbow|should|shldr|clav|collar|finger|thumb|humer|radius|ulna|scap|palm|pinky|pinkie"
    r"|index|middle|ring\d*|metacarp|carpal|wing|腕|手|肩|ひじ|肘|指|鎖骨",
    "other": r"tail|hair|skirt|cloth|cape|cloak|ear|eye|jaw|tongue|brow|breast|boob|bust|weapon|sword|gun|prop|ribbon"
    r"|dress|coat|sleeve|head|neck|face|spine|chest|torso|mouth|lip|cheek|nose|beard|ponytail|feather|fin"
    r"|頭|首|髪|胸|スカート|目|尾|上半身|脊",
}
_HELPER = re.compile(
    r"(^|[^a-z])ik([^a-z]|$)|pole|target|ctrl|control|helper|nub|twist|roll|mesh|goal|locator|effector|(^|_)end(site)?$|dummy|ｉｋ|捩"
)
_TIP = re.compile(r"(^|_)(end|endsite|site|nub|tip)(_\d+)?$")
_LEFT = {"l", "left", "lft", "lf", "links", "izq", "izquierda", "gauche", "左"}
_RIGHT = {"r", "right", "rgt", "rt", "rechts", "der", "derecha", "droite", "右"}
_NAMESPACE = re.compile(r"^.*[:|]")
_PREFIX = re.compile(
    r"^(mixamorig\d*|character\d*|ctrl|cc_base|bip\d*|valvebiped|j_bip_[clr](?=_)"
    r"|def|org|bn|jnt|joint|sim|b|bone)[_ .\-]+",
    re.IGNORECASE,
)
_WORDS = re.compile(r"[A-Z]+(?=[A-Z][a-z])|[A-Z]?[a-z]+|[A-Z]+|\d+|[^\x00-\x7f]+")
_GLUED = re.compile(
    r"^(l|r|left|right)_?(thigh|shin|calf|foot|toes?|hip|knee|ankle|leg|femur|tibia|upleg|upperleg|lowleg|lowerleg|lowleg"
    r"|arm|hand|wrist|elbow|shldr|shoulder|collar|clavicle|forearm|buttock|hipjoint|humerus|radius|thumb|fingers"
    r"|upperarm|lowerarm|eye|index\d|mid\d|ring\d|pinky\d|thumb\d|toebase|heel|ball)(.*)$"
)


@dataclass(frozen=True)
class Reading:
    """The meaning of a joint's name.

    Args:
        side: "left", "right" or "".
        part: one of thigh, knee, leg, ankle, toe, heel, arm, other, or "".
        helper: whether it names no bone of a body but a helper: an IK target, a twist or roll bone, an end.
        tip: whether it names the end of a chain, where other files have an End Site.
    """

    side: str
    part: str
    helper: bool
    tip: bool


def bare(name: str) -> str:
    """Strip the namespace of a name, `mixamorig:Hips` -> `Hips`."""
    return _NAMESPACE.sub("", name.strip())


@lru_cache(maxsize=4096)
def read(name: str) -> Reading:
    """Read a joint's name in the known naming schemes."""
    text = bare(name)
    vrm = re.match(r"^J_(?:Bip|Sec|Adj)_([CLR])_", text)
    side = {"L": "left", "R": "right"}.get(vrm.group(1), "") if vrm else ""
    text = _PREFIX.sub("", text) or text
    for leading, found in (("左", "left"), ("右", "right")):
        if leading in text:
            side, text = found, text.replace(leading, "")
    words = [word.lower() for word in _WORDS.findall(text)]
    rest = []
    for word in words:
        glued = _GLUED.match(word)
        if not side and (word in _LEFT or word in _RIGHT):
            side = "left" if word in _LEFT else "right"
        elif not side and glued:
            side = "left" if glued.group(1)[0] == "l" else "right"
            rest.append(word[len(glued.group(1)) :])
        else:
            rest.append(word)
    joined = "".join(word for word in rest if not word.isdigit())
    helper = bool(_HELPER.search("_".join(rest)))
    part = next((part for part, pattern in _PARTS.items() if re.search(pattern, joined)), "")
    if part == "thigh" and joined.endswith("hips"):
        part = ""
    if part in ("thigh",) and joined in ("hip",) and not side:
        part = ""  # the centre of the pelvis
    return Reading(side, part, helper, bool(_TIP.search("_".join(rest))))
