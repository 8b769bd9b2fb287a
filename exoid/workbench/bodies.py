"""The links of an identified machine as a robot file has them: masses, centres of mass and inertias that reproduce its
base parameters exactly, and what such a file cannot carry.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from exoid.ground.text import in_comment
from exoid.optimisation.linear.bodies import Body3D, gyration, nearest_bodies
from exoid.optimisation.linear.links import LinkInertia, nearest_links
from exoid.symbolic.joints import Joint
from exoid.symbolic.mechanics.base_parameters import pull_of
from exoid.symbolic.mechanics.spatial import KINDS
from exoid.symbolic.mechanics.spatial_energy import pseudo_inertia
from exoid.symbolic.model import Model
from exoid.symbolic.term import Term
from exoid.workbench.identified import ExportError, Ready

OFF_AXIS = {"com_offset": None, "com_offset_thigh": 0, "com_offset_shank": 1}
"""Effects that are a mass beside a link's axis, and the link, None where the joint says it."""


def link_names(ready: Ready) -> tuple[str, ...]:
    """Return the names of the links in a file: thigh and shank of the leg, else after their joints."""
    return tuple(f"{name}_link" for name in ready.model.joint_names) if ready.model.chain else ("thigh", "shank")


def base_name(links: Sequence[str]) -> str:
    """Return the name of the link that carries the machine."""
    return "base_link" if "base" in links else "base"


def links_of(ready: Ready, near: Sequence[LinkInertia] | None = None) -> tuple[LinkInertia, ...]:
    """Return links with the identified parameters, nearest to `near`; ExportError where none have them."""
    import numpy as np

    model = ready.model
    phi = np.array([ready.linear[p.name] for p in model.inertial])
    across = np.zeros(len(model.joints))
    for term in model.terms:
        if term.effect.id in OFF_AXIS:
            link = OFF_AXIS[term.effect.id]
            across[term.first if link is None else link] = ready.linear[f"{term.name}.m_y"]
    found = nearest_links(model, phi, across, near)
    if found is None:
        what = "machine" if model.chain else "leg"
        numbers = ", ".join(
            f"{p.name.replace('Phi', 'Φ')} = {v:g} {p.unit}" for p, v in zip(model.inertial, phi, strict=True)
        )
        raise ExportError(
            f"no {what} of positive masses has {numbers}",
            remedy="identify with --physical or on richer motion; the other formats carry these numbers",
        )
    return found


def bodies_of(ready: Ready, joints: Sequence[Joint] = ()) -> tuple[Body3D, ...]:
    """Return bodies of a spatial machine with the identified numbers, nearest to what a robot file says of those of its
    `joints` (default: the model's); ExportError where none have them.
    """
    import numpy as np

    model = ready.model
    phi = np.array([ready.linear[p.name] for p in model.inertial])
    found = nearest_bodies(model, phi, _known_bodies(model, joints or model.joints), patient=True)
    if found is None:
        raise ExportError(
            f"no machine of positive masses has the numbers Φ1 to Φ{len(model.inertial)}",
            remedy="identify with --physical or on richer motion; the other formats carry these numbers",
        )
    return found


def _known_bodies(model: Model, joints: Sequence[Joint]) -> tuple[Body3D, ...] | None:
    """Bodies (J,) that a robot file has, round ones where it has none that can be; None where it has no mass at all."""
    import numpy as np

    lightest = min((joint.body[0] for joint in joints if joint.body), default=None)
    if lightest is None:
        return None
    round_ = gyration(model) ** 2 * np.eye(3)
    found = []
    for joint in joints:
        mass, x, y, z, xx, xy, xz, yy, yz, zz = joint.body or (lightest, *[0.0] * 9)
        body = Body3D(mass, np.array([x, y, z]), np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]))
        possible = np.linalg.eigvalsh(pseudo_inertia(dict(zip(KINDS, body.numbers, strict=True))))[0] > 0.0
        found.append(body if possible else replace(body, inertia=mass * round_))
    return tuple(found)


def gravity_of(ready: Ready) -> tuple[float, float, float]:
    """Return gravity (3,) in the frame of the base, m/s², z upwards for a planar machine."""
    return pull_of(ready.model.pull)


def left_out(ready: Ready, carried: Sequence[str] = ()) -> str:
    """Return the effects that a file cannot carry, for a comment; `carried` are ids of those it does."""
    names = [term.name for term in ready.model.terms if term.effect.id not in (*OFF_AXIS, *carried)]
    return ", ".join(in_comment(name) for name in names) or "nothing"


def terms_of(ready: Ready, effect: str) -> dict[str, Term]:
    """Return {joint: term} of one effect of the catalogue."""
    return {str(term.joint): term for term in ready.model.terms if term.effect.id == effect}


def friction_of(ready: Ready, joint: str) -> tuple[float, float]:
    """Return viscous and Coulomb friction of a joint, not below zero: robot files know no friction that pushes."""
    viscous, coulomb = (max(0.0, ready.linear[f"{kind}:{joint}"]) for kind in ("viscous", "coulomb"))
    return viscous, coulomb
