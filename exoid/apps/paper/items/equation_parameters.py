"""The minimal parameters Φ."""

from __future__ import annotations

from exoid.apps.paper.experiments import Experiments
from exoid.apps.paper.item import FAILS, IN_PART, ItemAnswer
from exoid.symbolic.mechanics.mechanism import leg
from exoid.symbolic.mechanics.regressor import derive_regressor

TITLE = "the minimal parameters Φ"
SAYS = "four inertial parameters and two of friction per joint determine the torque; Φ5 to Φ8 have printed units."


def answer(experiments: Experiments) -> ItemAnswer:
    """Find the base parameters by elimination, and compare them with the printed ones."""
    from sympy import expand

    plain = leg()
    thigh, shank = plain.links
    m1, m2, a, l1, l2, i1, i2 = (
        thigh.mass, shank.mass, thigh.length, thigh.along, shank.along, thigh.inertia, shank.inertia,
    )  # fmt: skip
    printed = (
        i1 + i2 + m1 * l1**2 + m2 * a**2 + m2 * l2**2, i2 + m2 * l2**2, m2 * a * l2, m1 * a * l1 - i1 - m1 * l1**2,
    )  # fmt: skip
    found = derive_regressor(plain)
    same = [expand(parameter - other) == 0 for parameter, other in zip(found.parameters, printed, strict=True)]
    lines = [f"{name} = {made}    [kg·m²]" for name, made in zip(found.names, found.parameters, strict=True)]
    friction = experiments.leg.parameters[len(printed) :]
    lines += [f"Phi{k} = {p.label}    [{p.unit}]" for k, p in enumerate(friction, len(printed) + 1)]
    return ItemAnswer(
        f"elimination finds {len(found.names)} inertial parameters, {sum(same)} of them as printed. What motion cannot "
        "tell: the rotor inertia of the hip drive is a part of Φ1 and Φ4; masses, lengths and inertias enter through "
        "Φ1 to Φ4 alone.",
        IN_PART if all(same) else FAILS,
        "the units printed for Φ5 to Φ8 are wrong: Coulomb friction is N·m, viscous friction N·m·s/rad",
        text="\n".join(lines),
    )
