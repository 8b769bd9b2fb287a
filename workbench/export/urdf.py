"""URDF of the rigid leg: masses, centres of mass and inertias that reproduce the identified Φ1..Φ4 exactly.

Φ does not fix them: many legs have the same four numbers, so the same torques. One of them is chosen: the shank's mass
in the middle (geometrically) of what is possible, the thigh's so that half of its inertia is about its own centre.
URDF carries damping and friction of a joint, but none of the effects; those are named in the file.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from ground.text import in_comment
from workbench.identified import ExportError, Options, Ready

HELP = "URDF of the rigid leg with viscous and Coulomb friction"

INDIFFERENT = 1.0
"""Mass in kg of a thigh whose centre of mass is at the hip: any does."""


@dataclass(frozen=True)
class UrdfLink:
    """Mass kg, centre of mass m below its joint, inertia kg·m² about it."""

    mass: float
    com: float
    inertia: float


def segments(phi: tuple[float, float, float, float], thigh: float) -> tuple[UrdfLink, UrdfLink]:
    """Return a thigh and a shank with these base parameters; ExportError where no leg has them.

    With H = Φ1 - Φ2 - m_sh a² the inertia of the thigh about the hip: I_sh > 0 needs m_sh > Φ3²/(a² Φ2), H > 0 needs
    m_sh < (Φ1 - Φ2)/a²; both are possible just where Φ2 > 0 and Φ3² < Φ2 (Φ1 - Φ2), which is M positive definite in
    every pose. The thigh then needs only a mass above (m_th l_th)²/H.
    """
    first, second, third, fourth = phi
    low, high = (third**2 / (thigh**2 * second) if second > 0.0 else math.inf), (first - second) / thigh**2
    if not low < high:
        raise ExportError(
            f"no leg of positive masses has Φ1 = {first:g}, Φ2 = {second:g}, Φ3 = {third:g} kg·m²",
            remedy="URDF needs Φ2 > 0 and Φ3² < Φ2 (Φ1 - Φ2); export the other formats, or identify on richer motion",
        )
    mass = math.sqrt(low * high) if low > 0.0 else 0.5 * high
    shank = UrdfLink(mass, third / (thigh * mass), second - third**2 / (thigh**2 * mass))
    about_hip = first - second - mass * thigh**2
    moment = (fourth + about_hip) / thigh
    heavy = 2.0 * moment**2 / about_hip or INDIFFERENT
    return UrdfLink(heavy, moment / heavy, about_hip - moment**2 / heavy), shank


def write(ready: Ready, options: Options) -> dict[str, str]:
    """Return {file name: text}."""
    numbers = ready.linear
    upper, lower = segments(
        (numbers["Phi1"], numbers["Phi2"], numbers["Phi3"], numbers["Phi4"]), ready.model.thigh_length
    )
    left_out = ", ".join(in_comment(term.name) for term in ready.model.terms) or "nothing"
    hip, knee = (_joint(ready, joint, options) for joint in ("hip", "knee"))
    return {
        f"{options.name}.urdf": f"""<?xml version="1.0" encoding="utf-8"?>
<!-- Written by exoid. The rigid leg; masses and inertias are one choice of many with the identified Phi1..Phi4.
     z is up, x forward; both angles turn about -y; zero is the leg hanging straight down.
     Effects of the model that URDF cannot carry: {left_out}. effort is not identified: set your drive's. -->
<robot name="{options.name}">
  <link name="base"/>
{_link("thigh", upper)}
{_link("shank", lower)}
  <joint name="hip" type="revolute">
    <parent link="base"/><child link="thigh"/><origin xyz="0 0 0"/>
{hip}
  </joint>
  <joint name="knee" type="revolute">
    <parent link="thigh"/><child link="shank"/><origin xyz="0 0 {-ready.model.thigh_length!r}"/>
{knee}
  </joint>
</robot>
"""
    }


def _link(name: str, one: UrdfLink) -> str:
    # Only the inertia about y moves in a plane; a body of the same size about every axis is always possible.
    return f"""  <link name="{name}"><inertial>
    <origin xyz="0 0 {-one.com!r}"/><mass value="{one.mass!r}"/>
    <inertia ixx="{one.inertia!r}" iyy="{one.inertia!r}" izz="{one.inertia!r}" ixy="0" ixz="0" iyz="0"/>
  </inertial></link>"""


def _joint(ready: Ready, joint: str, options: Options) -> str:
    limit = ready.model.limits[joint]
    low, high = limit.angle
    damping, friction = (max(0.0, ready.linear[f"{kind}:{joint}"]) for kind in ("viscous", "coulomb"))
    return f"""    <axis xyz="0 -1 0"/><dynamics damping="{damping!r}" friction="{friction!r}"/>
    <limit lower="{low!r}" upper="{high!r}" velocity="{limit.velocity!r}" effort="0"/>"""
