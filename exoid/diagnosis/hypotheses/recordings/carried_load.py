"""Some recordings carry a load that nobody named: a small body on the axis of a link, in space anywhere on it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from itertools import product

import numpy as np

from exoid.diagnosis.hypotheses.recordings import Claim, Node, Seen, StateColumn, each_said, listed
from exoid.symbolic.joints import HERE, parents
from exoid.symbolic.mechanics.payload import HEAVIEST, LINKS, one_kg_at
from exoid.symbolic.mechanics.spatial import AXES, INERTIAS, MOMENTS
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Float

PLACES = 24
"""Places along a link at which a load is looked for first."""
FEW = 3
"""Joints of a machine in space, at most, each link of which is asked about: an arm holds its load at its end."""
BOUNDS = (0.0, HEAVIEST)
UNITS = ("kg·m²", "kg·m", "kg")
UNITS_IN_SPACE = (*("kg·m²",) * len(INERTIAS), *("kg·m",) * len(MOMENTS), "kg")
"""Units of the inertial numbers of a link."""


def claims(model: Model, columns: Sequence[StateColumn]) -> tuple[Claim, ...]:
    """Return a load on each link; on an arm of many on those that carry no other."""
    names = model.joint_names if model.chain else LINKS
    links = [*range(len(names))]
    if model.spatial and len(names) > FEW:
        carrying = parents(model.joints)
        links = [k for k in links if k not in carrying]
    nodes, at_one = (_in_space(model), AXES) if model.spatial else (_along(model), ((1.0,),))
    units = UNITS_IN_SPACE if model.spatial else UNITS
    found = []
    for k in links:
        shown = tuple(np.flatnonzero(model.mixture[:, k].any(axis=0)).tolist())
        pieces, mix = partial(_pieces, k, shown), partial(_mix, shown)
        places, unit = nodes, "kg"
        if len(shown) == 1:  # as of a slide its mass: that number is told, which 1 kg at 1 m has as 1
            places, unit = tuple(at for at in at_one if mix(at)[0] == 1.0)[:1], units[shown[0]]
        if shown and places:
            found.append(
                Claim("carried_load", names[k], unit, pieces, BOUNDS, borne=True, shared=True, nodes=places, mix=mix)
            )
    return tuple(found)


def _along(model: Model) -> tuple[Node, ...]:
    longest = [joint.length or 0.0 for joint in model.joints] if model.chain else [model.thigh_length] * 2
    reach = 1.5 * max(longest) or 0.6
    return tuple((float(x),) for x in np.linspace(reach / PLACES, reach, PLACES))


def _in_space(model: Model) -> tuple[Node, ...]:
    """Places (3,) in the frame of a joint: its origin, and near and far from it in every direction."""
    reach = max(math.hypot(*(joint.origin or HERE).xyz) for joint in model.joints) or 0.6
    ways = [way for way in product((0.0, 1.0, -1.0), repeat=3) if any(way)]
    return ((0.0, 0.0, 0.0), *((r * x, r * y, r * z) for r in (0.2 * reach, 0.6 * reach) for x, y, z in ways))


def _pieces(link: int, shown: tuple[int, ...], seen: Seen) -> Float:
    """Torques (J, K, m) that the inertial numbers of one link which show ask of the drives."""
    mixture = seen.model.mixture[:, link, list(shown)]
    return np.asarray(seen.columns[:, :, : len(mixture)] @ mixture)


def _mix(shown: tuple[int, ...], at: Node) -> Float:
    """Return those numbers (m,) of 1 kg at a place."""
    return one_kg_at(at)[list(shown)]


def said(claim: Claim, values: dict[str, str], where: str, when: str) -> str:
    """Sentence on the loads {recording: words}, and where they hang."""
    names, words = listed(values), next(iter(values.values()))
    each = "" if len(set(values.values())) == 1 else f" ({each_said(values)})"
    what = f"{words}{where}" if not each else f"something{where}{each}"
    verb = "carry" if len(values) > 1 else "carries"
    than = "a load" if when else "a load that the others do not"
    return f"{when} {names} {verb} {than}: {what} on the {claim.place}".strip()
