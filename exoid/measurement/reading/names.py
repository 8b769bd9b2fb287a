"""The meaning of a column's name: quantity, joint, leg and unit.

A name is cut into words. If the words that remain after fillers ("measured", "joint", ...) are a known quantity and a
known joint, the column is recognised; groups around it (`/joint_states/hip_joint/position`, `left_leg.hip.angle`) may
name what the last part leaves open. Anything else in the last part, and "desired", "ref" or "error" anywhere, forbids
it: a set-point is never taken for a measurement, nor hip adduction for hip flexion.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from functools import lru_cache
from itertools import pairwise
from typing import NamedTuple

from exoid.ground.text import without_accents
from exoid.measurement.reading.outside import outside_columns, outside_kind, outside_name, words_of
from exoid.measurement.reading.units import SLIDING, factor, is_scaled, is_unit
from exoid.measurement.recording import BASE_COLUMNS, SPACE_BASE_COLUMNS
from exoid.symbolic.joints import LEG, Joint, is_spatial
from exoid.symbolic.joints import names as joint_names
from exoid.symbolic.units import QUANTITIES, plain_unit

WORDS: Mapping[str, tuple[str, ...]] = {
    "t": ("t", "time", "timestamp", "timestamps", "zeit", "clock", "elapsed", "elapsedtime", "seconds",
          "stamp", "rowtimes", "datetime", "epoch", "timesec", "timesecs", "rostime", "rosbagtimestamp", "timestep",
          "systemtime", "walltime", "date", "datetime", "uptime", "unixtime", "epochtime", "tick", "ticks",
          "logtime", "publishtime", "times", "temps", "tiempo"),
    "q": ("q", "theta", "angle", "angles", "pos", "position", "positions", "phi", "winkel", "th", "qpos", "ang",
          "angularposition", "displacement", "flexion", "flex", "flexionextension", "flexext", "istposition",
          "istwinkel", "lage", "gelenkwinkel", "posicion", "angulo"),
    "dq": ("dq", "qd", "qdot", "qp", "dtheta", "thetadot", "thetad", "theta dot", "omega", "vel", "velocity",
           "velocities", "speed", "w", "angularvelocity", "angularvelocities", "angvel", "anglerate", "dth", "qvel",
           "angularrate", "geschwindigkeit", "istgeschwindigkeit", "winkelgeschwindigkeit", "drehzahl", "vitesse",
           "vitesseangulaire", "velocidad", "velocidadangular"),
    "ddq": ("ddq", "qdd", "qddot", "qpp", "ddtheta", "thetaddot", "thetadd", "acc", "acceleration", "accelerations",
            "angularacceleration", "angacc", "ddth", "qacc"),
    "tau": ("tau", "torque", "torques", "trq", "moment", "moments", "drehmoment", "effort", "efforts", "u", "qfrc",
            "jointtorque", "generalizedforce", "generalisedforce", "eff", "istmoment", "istdrehmoment", "gelenkmoment",
            "couple", "par", "momento", "esfuerzo"),
    "f": ("f", "force", "cuffforce", "interactionforce", "fint", "fdis", "fcuff", "kraft"),
    "i": ("i", "iq", "current", "currents", "strom", "iststrom", "motorstrom", "amps", "ampere", "motorcurrent",
          "courant", "corriente"),
}  # fmt: skip
WEAK_TIME = ("name", "header", "epoch", "xvalue", "xaxis", "x")
"""Used for the time only where nothing else is and the column runs forwards: what TwinCAT ("Name"), MATLAB tables of a
gait data set ("Header") and LabVIEW ("X_Value") head theirs with."""
SYNONYMS: Mapping[str, tuple[str, ...]] = {
    "hip": ("h", "hufte", "huefte", "hanche", "cadera"),
    "knee": ("k", "kn", "knie", "genou", "rodilla"),
    "ankle": ("sprunggelenk", "knochel", "knoechel", "cheville", "tobillo"),
}
"""Other words for a joint, by the name of the joint, without accents."""
SIDES: Mapping[str, tuple[str, ...]] = {
    "left": ("left", "l", "lft", "lt", "links"),
    "right": ("right", "r", "rgt", "rt", "rechts"),
    "ipsi": ("ipsi", "ipsilateral"),
    "contra": ("contra", "contralateral"),
}
FILLERS = frozenset(
    {
        "joint", "joints", "measured", "meas", "actual", "act", "sensor", "motor", "of", "in", "the", "encoder", "data",
        "value", "values", "signal", "output", "link", "leg", "exo", "exoskeleton", "robot", "drive", "axis",
        "actuator", "applied", "filtered", "filt", "estimate", "estimated", "est", "state", "states", "feedback", "fbk",
        "node", "jnt", "channel", "sagittal", "raw", "pitch", "present", "de",
        "la", "le", "du", "del", "der", "am", "moteur",
        "gemessen", "ist", "istwert", "mesure", "mesuree", "reel", "reelle", "medido", "medida", "real", "articulacion",
        "articulation", "gelenk",
    }
)  # fmt: skip
PLANES = frozenset({"s"})
"""Words that may stand beside a joint and mean the sagittal plane."""
SET_POINTS = frozenset(
    {
        "ref", "reference", "desired", "des", "cmd", "command", "commanded", "setpoint", "target", "goal", "commands",
        "targets", "references", "setpoints", "goals", "demand", "setpt", "soll", "sollwert", "consigne", "consigna",
        "cible", "objetivo",
    }
)  # fmt: skip
FOREIGN = SET_POINTS | {
    "roll", "yaw", "adduction", "abduction", "rotation", "frontal", "transverse", "error", "err", "model", "simulated",
    "predicted", "feedforward", "std", "variance",
}  # fmt: skip
"""Anywhere in a name, also in its group, these say that it is no measurement, or not in the plane of the leg."""
RATES = frozenset({"angle", "angles", "angular", "flexion", "ang"})
"""Beside another quantity these only say which: OpenSim's `knee_angle_r_moment` is a moment."""
COUNTED = frozenset({"joint", "axis", "motor", "drive", "actuator", "node", "jnt"})
"""In the name of a group, a number counts joints only behind one of these: `joint1/position`, not `run1/position`."""
PORT = re.compile(r"(out|outport|value|values)\d*", re.IGNORECASE)
"""Last part of a path that names a port of a block, not a signal."""
GREEK = {
    "θ̈": " ddtheta ",
    "θ̇": " dtheta ",
    "θ": " theta ",
    "ϑ": " theta ",
    "φ": " phi ",
    "τ": " tau ",
    "ω": " omega ",
}
_OF_UNIT = {"rad": "q", "m/s²": "ddx"}
BASE: Mapping[str, str] = {
    name: _OF_UNIT[unit] for name, unit in (*BASE_COLUMNS.items(), *SPACE_BASE_COLUMNS.items())
}
"""Columns of a measured base, and what quantity each is."""
CARRIERS = ("base", "backpack", "pelvis", "trunk")
BASE_WORDS: Mapping[str, str] = {
    **{name.replace("_", ""): name for name in BASE_COLUMNS},
    **{f"{part}{word}": "base_angle" for part in CARRIERS for word in ("angle", "tilt", "pitch")},
}
SPACE_BASE_WORDS: Mapping[str, str] = {
    **{name.replace("_", ""): name for name in SPACE_BASE_COLUMNS},
    **{f"{part}{word}": f"base_{word}" for part in CARRIERS for word in ("roll", "pitch", "yaw")},
}
OWN = ("q", "dq", "ddq", "tau", "f")
"""Quantities that every joint has a column of."""
_QUANTITY = {word.replace(" ", ""): quantity for quantity, words in WORDS.items() for word in words}
_SIDE = {word: side for side, words in SIDES.items() for word in words}
SIDE_WORDS = frozenset(_SIDE)


class ColumnMeaning(NamedTuple):
    """The possible meaning of a column: canonical `name`, the `unit` hidden in its own name, `rank` (the smaller is
    taken before the larger: number of filler words), `side` of the body ("" if unsaid).
    """

    name: str
    unit: str = ""
    rank: int = 0
    side: str = ""


class _Part(NamedTuple):
    """The words of one part of a path, sorted out."""

    quantity: str
    joints: frozenset[int]
    sides: frozenset[str]
    rank: int
    rest: bool


@lru_cache(maxsize=4096)
def recognise(name: str, joints: tuple[Joint, ...] = LEG) -> ColumnMeaning | None:
    """Return the meaning of the column `name` of a machine with `joints`, None where it cannot be told.

    "tau1_mNm" is ColumnMeaning("tau1", "mNm"); "hip_flexion_r_moment" is ColumnMeaning("tau1", side="right"). A
    quantity and the name of a joint as the model writes it, "tau_roll", come before any reading of words.
    """
    quantity, _, own = name.partition("_")
    if quantity in OWN and own in joint_names(joints):
        return ColumnMeaning(f"{quantity}{joint_names(joints).index(own) + 1}", rank=-1)
    for sign, word in GREEK.items():
        name = name.replace(sign, word)
    name = without_accents(name)
    if base := _of_base(name, SPACE_BASE_WORDS if is_spatial(joints) else BASE_WORDS):
        return base
    name = name.removeprefix("Model Root/")  # dSPACE names the block diagram so; "model" elsewhere is no measurement
    if len(name) > 300 or FOREIGN.intersection(re.split(r"[\W\d_]+", _spaced(name).lower())):
        return None
    path = [part for part in re.split(r"[./:|\\]|->", name) if re.search(r"\w", part)]
    while len(path) > 1 and PORT.fullmatch(path[-1]):
        path.pop()
    if len(path) > 1 and path[-1].lower() == "stamp":
        return ColumnMeaning("t", rank=-1)  # the instant of the measurement, before that of its arrival
    whole = _text(" ".join(path) if len(path) < 4 else path[-1], joints)
    found = whole or (_in_groups(path, joints) if len(path) > 1 else None)
    # Programs for controllers put the type in front of a name: fHipAngle, lrKneeTorque.
    typed = re.sub(r"(?<![A-Za-z0-9])(f|lr)(?=[A-Z][a-z])", "", name)
    return found or (recognise(typed, joints) if typed != name else None) or _of_outside(name, joints)


def _of_outside(name: str, joints: tuple[Joint, ...]) -> ColumnMeaning | None:
    """Return the meaning of a column of a force from outside, or of the foot's contact; a unit may stand at its end."""
    if name in outside_columns(joints):
        return ColumnMeaning(name, rank=-1)
    words = words_of(name)
    for used in (0, 1):
        own = words[: len(words) - used]
        sides = {_SIDE[word] for word in own if word in _SIDE}
        kept = [word for word in own if word not in _SIDE and word not in FILLERS]
        meant = outside_name(kept, joints)
        unit = words[-1] if used and words else ""
        if meant and len(sides) < 2 and (not used or _is_unit_of(kind_of(meant, joints), unit)):
            return ColumnMeaning(meant, unit, len(own) - len(kept), "".join(sides))
    return None


def _of_base(name: str, known: Mapping[str, str]) -> ColumnMeaning | None:
    """Return the meaning of a column of a measured base: "base_angle", "backpack tilt deg", "base_ax"; `known` are
    words.
    """
    parts = [part.lower() for part in re.split(r"[\W_]+", name) if part]
    for used in (0, 1, 2):  # a unit at the end may be cut in two
        meant = known.get("".join(parts[: len(parts) - used]))
        unit = "/".join(parts[len(parts) - used :]) if used else ""
        if meant and (not used or _is_unit_of(BASE[meant], unit)):
            return ColumnMeaning(meant, unit)
    return None


def words_in(name: str) -> frozenset[str]:
    """Return the words of a name in small letters: "LeftHipMotor1" -> left, hip, motor, 1."""
    return frozenset(word for word in re.split(r"[\W_]+", _spaced(without_accents(name)).lower()) if word)


def is_set_point(name: str, joints: tuple[Joint, ...]) -> bool:
    """True if `name` would say an angle or a torque, but for the word that says that it was only asked for."""
    words = [word for word in re.split(r"[\W_]+", _spaced(name).lower()) if word]
    measured = [word for word in words if word not in SET_POINTS]
    found = recognise("_".join(measured), joints) if len(measured) < len(words) else None
    return found is not None and quantity_of(found.name) in ("q", "tau")


def weak_time(name: str) -> bool:
    """True if `name` heads the time in some logs though it says nothing of the kind."""
    return re.sub(r"[\W_]+", "", name).lower() in WEAK_TIME


def quantity_of(name: str) -> str:
    """Return the quantity of a canonical column name: "dq1" -> "dq"."""
    return name.rstrip("0123456789")


def kind_of(name: str, joints: Sequence[Joint]) -> str:
    """Return the key of `units.QUANTITIES` of a canonical column: "dq1" -> "dq", or "dx" where joint 1 slides."""
    if name in BASE:
        return BASE[name]
    if outside := outside_kind(name):
        return outside
    quantity = quantity_of(name)
    number = name.removeprefix(quantity)
    return quantity if not number or joints[int(number) - 1].turns else SLIDING.get(quantity, quantity)


def _text(text: str, joints: tuple[Joint, ...]) -> ColumnMeaning | None:
    """Return the meaning of a name without groups, with its unit, which may stand at the end."""
    parts = _unit_last([part for part in re.split(r"[\W_]+", text) if part])
    for used in (2, 1):  # a unit at the end may be cut in two: "rad_s"
        tail = "/".join(parts[-used:])
        found = _whole(parts[:-used], joints) if len(parts) > used and not tail.isdigit() else None
        if found and tail.lower() not in _SIDE and _is_unit_of(kind_of(found.name, joints), tail):
            return found._replace(unit=tail)
    return _whole(parts, joints) or _by_unit(parts, joints)


def _by_unit(parts: Sequence[str], joints: tuple[Joint, ...]) -> ColumnMeaning | None:
    """Meaning of a joint and a unit where no quantity is named: "hip_deg", "knee_Nm"."""
    for used in (2, 1):
        tail = "/".join(parts[-used:])
        found = _sorted_out(parts[:-used], joints) if len(parts) > used else None
        if found is None or found.quantity or found.rest or len(found.joints) != 1 or len(found.sides) > 1:
            continue
        number = min(found.joints)
        meant = [key for key in ("q", "dq", "ddq", "tau") if _is_unit_alone(kind_of(f"{key}{number}", joints), tail)]
        if len(meant) == 1 and (len(tail) > 1 or not tail.isalpha()):
            return ColumnMeaning(f"{meant[0]}{number}", tail, found.rank + 1, "".join(found.sides))
    return None


def _is_unit_alone(quantity: str, tail: str) -> bool:
    return plain_unit(tail) in QUANTITIES[quantity]


def _unit_last(parts: list[str]) -> list[str]:
    """Return the words of a name with its number before its unit: columns of a matrix are counted behind its name,
    q_deg1 or q_deg_1.
    """
    counted = re.fullmatch(r"(.*[^\W\d_])_?(\d{1,2})", "_".join(parts))
    words = counted[1].split("_") if counted else []
    for used in (2, 1):
        unit = "/".join(words[-used:])
        if counted and len(words) > used and unit.lower() not in _SIDE and is_unit(unit):
            return [*words[:-used], counted[2], *words[-used:]]
    return parts


def _is_unit_of(quantity: str, tail: str) -> bool:
    return factor(quantity, tail) is not None or is_scaled(quantity, tail)


def _whole(parts: Sequence[str], joints: tuple[Joint, ...]) -> ColumnMeaning | None:
    found = _sorted_out(parts, joints)
    if found.rest or len(found.sides) > 1:
        return None
    if found.quantity == "t" and not found.joints and not found.sides:
        return ColumnMeaning("t", rank=found.rank)
    if found.quantity in ("", "t"):
        return None
    if len(joints) == 1 and not found.joints:  # one joint need not be named
        shortest = "".join(parts).lower() == found.quantity
        return _reading(found.quantity, 1, found.rank + (not shortest), found.sides, parts, joints)
    if len(found.joints) != 1:
        return None
    return _reading(found.quantity, min(found.joints), found.rank, found.sides, parts, joints)


def _reading(
    quantity: str, number: int, rank: int, sides: frozenset[str], words: Sequence[str], joints: tuple[Joint, ...]
) -> ColumnMeaning:
    """Return the reading of a column; what is called a force is the drive's where the joint slides."""
    if quantity == "f" and not joints[number - 1].turns and "force" in (word.lower() for word in words):
        quantity, rank = "tau", rank + 1
    return ColumnMeaning(f"{quantity}{number}", "", rank, "".join(sides))


def _in_groups(path: Sequence[str], joints: tuple[Joint, ...]) -> ColumnMeaning | None:
    """Return the meaning of a path: quantity, joint and side each from the innermost part that has it."""
    unit = ""
    last = _unit_last([part for part in re.split(r"[\W_]+", path[-1]) if part])
    inner = _sorted_out(last, joints)
    if inner.rest and len(last) > 1 and _is_unit_of(_sorted_out(last[:-1], joints).quantity or "t", last[-1]):
        inner, unit = _sorted_out(last[:-1], joints), last[-1]
    if inner.rest:
        return None
    quantity, found, sides, rank = inner.quantity, inner.joints, inner.sides, inner.rank
    if quantity == "t":
        return None if found or sides else ColumnMeaning("t", unit, rank)
    for part in reversed(path[:-1]):
        words = [word for word in re.split(r"[\W_]+", part) if word]
        outer = _sorted_out(words, joints)
        if not quantity and outer.quantity not in ("", "t") and not outer.rest:
            quantity = outer.quantity
        lower = _spaced(" ".join(words)).lower().split()
        if not found and outer.quantity not in ("", "t") and not outer.rest:
            found = outer.joints
        if not found:
            named = {_joint(word, joints) for word in lower if not word.isdigit() and len(word) > 1} - {0}
            number, lower = _spelt(lower, joints)
            named = {number} - {0} or named
            counted = {_joint(b, joints) for a, b in pairwise(lower) if a in COUNTED and b.isdigit()} - {0}
            found = frozenset(named or counted)
        if not sides:
            sides = frozenset(_SIDE[word] for word in lower if word in _SIDE and (len(word) > 1 or not outer.rest))
    if len(joints) == 1 and not found:
        found = frozenset((1,))
    if quantity in ("", "t") or len(found) != 1 or len(sides) > 1:
        return None
    return _reading(quantity, min(found), rank, sides, last, joints)._replace(unit=unit)


def joints_of(name: str, joints: tuple[Joint, ...]) -> frozenset[int]:
    """Return the joints that a name names, counted from 1, whatever else it says."""
    return frozenset(_joint(word, joints) for word in words_in(name)) - {0}


def _sorted_out(parts: Sequence[str], joints: tuple[Joint, ...]) -> _Part:
    """Return quantity, joints and sides among the words of `parts`, and whether any other word is left."""
    number, lower = _spelt(_spaced(" ".join(parts)).lower().split(), joints)
    kept = [word for word in lower if word not in FILLERS]
    found = frozenset(_joint(word, joints) for word in kept) - {0} if not number else frozenset((number,))
    sides = frozenset(_SIDE[word] for word in kept if word in _SIDE)
    plain = [word for word in kept if not _joint(word, joints) and word not in _SIDE]
    if found and len(plain) > 1:
        plain = [word for word in plain if word not in PLANES]
    quantity = _QUANTITY.get("".join(plain), "")
    if not quantity and plain:
        bare = [word for word in plain if word not in RATES]
        quantity = _QUANTITY.get("".join(bare), "") if bare else "q" if plain != ["angular"] else ""
        if bare and (quantity not in ("tau", "dq", "ddq") or len("".join(bare)) == 1):
            quantity = ""  # "fHipAngle" is an angle in the notation of a controller, no force
    # The side a drive pushes on and the side the joint turns on are not the same: the joint's own is taken first.
    rank = len(lower) - len(kept) + 2 * lower.count("motor") - lower.count("output")
    return _Part(quantity, found, sides, rank, bool(plain) and not quantity)


def _spelt(words: list[str], joints: tuple[Joint, ...]) -> tuple[int, list[str]]:
    """Return the joint, counted from 1 (0: none), whose name is spelt out among `words` and no single word says, and
    the words that are left: "left_hip" in "left hip torque", "drive", which otherwise means nothing.
    """
    best, rest, length = 0, words, 0
    for number, joint in enumerate(joints, start=1):
        own = _spaced(joint.name.replace("_", " ")).lower().split()
        if len(own) == 1 and own[0] not in FILLERS and own[0] not in _SIDE and own[0] not in _QUANTITY:
            continue
        left = [_SIDE.get(word, word) for word in words]
        wanted = [_SIDE.get(word, word) for word in own]
        if len(wanted) <= length or any(left.count(word) < wanted.count(word) for word in wanted):
            continue
        rest, length, best = list(words), len(wanted), number
        for word in wanted:
            place = left.index(word)
            del left[place], rest[place]
    return best, rest


def _joint(word: str, joints: tuple[Joint, ...]) -> int:
    """Return the number of the joint that `word` names, counted from 1, or 0."""
    if word.isascii() and word.isdigit() and len(word) < 3:
        return int(word) if 1 <= int(word) <= len(joints) else 0
    for number, joint in enumerate(joints, start=1):
        if word == joint.name.lower() or word in SYNONYMS.get(joint.name.lower(), ()):
            return number
    return 0


def _spaced(name: str) -> str:
    """Return `name` with a blank between words and numbers written as one: "hipAngle", "RHipAngle", "q1"."""
    name = re.sub(r"(?<=[a-z])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", " ", name)
    return re.sub(r"(?<=[^\W\d_])(?=\d)|(?<=\d)(?=[^\W\d_])", " ", name)
