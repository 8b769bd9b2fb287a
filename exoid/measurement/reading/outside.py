"""Columns about pushes on a machine from outside: cuffs, the ground under the foot, and its contact.

Names as force plates ("FP1_Fz"), insoles, load cells and OpenSim ("ground_force_r_vy", upwards there) write them.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from itertools import product

from exoid.symbolic.joints import Joint, is_leg, is_spatial

CONTACT = "contact"
"""Column that says when the foot carries load: 0 or 1, or the load."""
INTERACTION = "interaction_torque_"
"""Before the name of a joint: the column of a torque that a person applies about it."""
GROUND: Mapping[str, str] = {"grf_x": "f", "grf_z": "f"}
"""Columns of the ground's force on the foot, forwards and upwards, and what quantity each is."""
SEGMENTS: Mapping[str, int] = {"thigh": 0, "femur": 0, "shank": 1, "calf": 1, "tibia": 1}
"""Links of a leg as people call them, and which joint each follows."""

WRENCH: Mapping[str, str] = {
    f"wrench_{what}_{axis}": kind for what, kind in (("force", "f"), ("torque", "tau")) for axis in "xyz"
}
"""Columns of a force-torque sensor on a machine in space, and what quantity each is."""

_PLATE = ("grf", "groundreactionforce", "groundreaction", "groundforce", "forceplate", "forceplatform", "plate", "fp",
          "footforce", "treadmillforce", "treadmill")  # fmt: skip
_FORWARDS = ("x", "fx", "vx", "forcex", "ap", "anterior", "anteroposterior", "forward", "forwards", "horizontal")
_UPWARDS = ("z", "fz", "vz", "forcez", "vertical", "vert", "up", "upwards", "normal")
_NAMES = {
    **{"".join(pair): "grf_x" for pair in product(_PLATE, _FORWARDS)},
    **{"".join(pair): "grf_z" for pair in product(_PLATE, _UPWARDS)},
    **{"".join(pair): "grf_z" for pair in product(("vertical", "v", "normal"), ("grf", "groundreactionforce"))},
    "fx": "grf_x", "fz": "grf_z",
    "groundforcevy": "grf_z",  # OpenSim counts y upwards, and z sideways
    "groundforcevz": "",
    **{"".join(pair): CONTACT for pair in product(
        ("foot", "heel", "sole", "ground", ""), ("contact", "stance", "switch", "footswitch", "fsr", "onground"))},
    "switch": "", "stancephase": CONTACT, "instance": CONTACT,
    **{"".join(pair): CONTACT for pair in product(("insole", "plantar"), ("", "force", "load", "fz", "normalforce"))},
}  # fmt: skip
_SENSORS = ("", "wrench", "flange", "ft", "fts", "ftsensor", "forcetorque", "forcetorquesensor", "tcp", "tool", "eef")
_IN_SPACE = {
    before + word: f"wrench_{what}_{axis}"
    for what, stems in (("force", ("f", "force")), ("torque", ("t", "torque", "m", "moment")))
    for axis in "xyz" for stem in stems for word in (stem + axis, axis + stem) for before in _SENSORS
}  # fmt: skip
_PUSHING = frozenset({"force", "f", "cuff", "strap", "load", "loadcell"})
_BESIDE = frozenset({"cell", "interaction", "interface", "human", "user", "wearer", "normal"})
_PERSON = frozenset({"interaction", "human", "user", "wearer", "interface"})
_TORQUE = frozenset({"torque", "moment", "tau"})


def outside_columns(joints: Sequence[Joint]) -> tuple[str, ...]:
    """Return the canonical columns of what pushes a machine with `joints`, cuffs (f1, ...) apart."""
    person = (f"{INTERACTION}{joint.name}" for joint in joints)
    return (*WRENCH, *person) if is_spatial(joints) else (*GROUND, *person, CONTACT)


def force_columns(joints: Sequence[Joint]) -> tuple[str, ...]:
    """Return the canonical columns of all forces and torques from outside, cuffs first, which machines in space have
    none of.
    """
    cuffs = () if is_spatial(joints) else tuple(f"f{k}" for k in range(1, len(joints) + 1))
    return (*cuffs, *(name for name in outside_columns(joints) if name != CONTACT))


def outside_kind(name: str) -> str | None:
    """Return the quantity of an outside column (a key of `units.QUANTITIES`), None for any other column."""
    if name == CONTACT:
        return "load"
    return "tau" if name.startswith(INTERACTION) else GROUND.get(name) or WRENCH.get(name)


def outside_name(words: Sequence[str], joints: Sequence[Joint]) -> str:
    """Return the canonical column that the `words` of a name mean, fillers and sides left out; "" for none."""
    own = [joint.name.lower() for joint in joints]
    plain = [word for word in words if not word.isdigit()]
    spatial = is_spatial(joints)
    if found := (_IN_SPACE if spatial else _NAMES).get("".join(plain), ""):
        return found
    there = set(plain)
    named = {k for k, name in enumerate(own) if name in there}
    if is_leg(joints):
        named |= {SEGMENTS[word] for word in there & SEGMENTS.keys()}
    rest = there - set(own) - SEGMENTS.keys()
    if len(named) != 1:
        return ""
    (index,) = named
    if rest & _PERSON and rest & _TORQUE and rest <= _PERSON | _TORQUE:
        return f"{INTERACTION}{joints[index].name}"
    return f"f{index + 1}" if not spatial and rest & _PUSHING and rest <= _PUSHING | _BESIDE else ""


def words_of(name: str) -> list[str]:
    """Return the words of a name in lower case, numbers apart, capitals taken as they stand together: "FP1_Fz"."""
    parted = re.sub(r"(?<=[^\W\d_])(?=\d)|(?<=\d)(?=[^\W\d_])|(?<=[a-z])(?=[A-Z])", " ", name)
    return [word for word in re.split(r"[\W_]+", parted.lower()) if word]
