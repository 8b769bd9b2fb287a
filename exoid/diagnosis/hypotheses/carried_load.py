"""Some recordings carry a load that nobody named, a small body on the axis of a link."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np

from exoid.diagnosis.hypotheses import Claim, Seen, StateColumn, each_said, listed
from exoid.symbolic.mechanics.payload import HEAVIEST, LINKS
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Float

PLACES = 24
"""Places along a link at which a load is looked for first."""


def claims(model: Model, columns: Sequence[StateColumn]) -> tuple[Claim, ...]:
    """Return a load on each link; none in space, where its place is no one number."""
    if model.spatial:
        return ()
    names = model.joint_names if model.chain else LINKS
    longest = [joint.length or 0.0 for joint in model.joints] if model.chain else [model.thigh_length] * 2
    reach = 1.5 * max(longest) or 0.6
    nodes = tuple(float(x) for x in np.linspace(reach / PLACES, reach, PLACES))
    return tuple(
        Claim("carried_load", name, "kg", partial(_pieces, k), (0.0, HEAVIEST), shared=True, nodes=nodes, mix=_mix)
        for k, name in enumerate(names)
    )


def _pieces(link: int, seen: Seen) -> Float:
    """Torques (J, K, 3) that inertia, first moment and mass of one link ask of the drives."""
    mixture = seen.model.mixture[:, link]
    return np.asarray(seen.columns[:, :, : len(mixture)] @ mixture)


def _mix(at: float) -> Float:
    return np.array([at**2, at, 1.0])


def said(claim: Claim, values: dict[str, str], where: str, when: str) -> str:
    """Sentence on the loads {recording: words}, and where they hang."""
    names, words = listed(values), next(iter(values.values()))
    each = "" if len(set(values.values())) == 1 else f" ({each_said(values)})"
    what = f"{words}{where}" if not each else f"something{where}{each}"
    verb = "carry" if len(values) > 1 else "carries"
    than = "a load" if when else "a load that the others do not"
    return f"{when} {names} {verb} {than}: {what} on the {claim.place}".strip()
