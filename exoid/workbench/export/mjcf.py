"""MJCF, the model file of MuJoCo: the rigid machine with identified parameters, damping, friction, rotors and springs.

Bodies are those of the URDF (`urdf.py`). MuJoCo's `armature` is the rotor inertia, `stiffness` and `springref` are the
joint spring, `frictionloss` is Coulomb friction; other effects are named in the file.
"""

from __future__ import annotations

from collections.abc import Iterable
from math import isfinite

from exoid.optimisation.linear.links import tree_of
from exoid.symbolic.joints import HERE, Joint, parents
from exoid.workbench.bodies import bodies_of, friction_of, gravity_of, left_out, link_names, links_of, terms_of
from exoid.workbench.identified import Options, Ready

HELP = "MJCF (MuJoCo) of the rigid machine with friction, rotor inertias and joint springs"
CARRIED = ("rotor_inertia", "joint_spring")
HARD = "0.99 0.999 0.001"
"""Of MuJoCo's constraint that is dry friction: at its usual one a light wrist moves at 1 rad/s before it has it whole.
"""


def write(ready: Ready, options: Options) -> dict[str, str]:
    """Return {file name: text}; ExportError where no machine of positive masses has the numbers."""
    joints, names = tree_of(ready.model), link_names(ready)
    above = parents(joints)
    placed = _in_space(ready) if ready.model.spatial else _in_a_plane(ready)

    def body(k: int, depth: int) -> str:
        (place, inertial, axis), pad = placed[k], "  " * depth
        inside = "".join(body(j, depth + 1) for j, carrier in enumerate(above) if carrier == k)
        return f"""{pad}<body name="{names[k]}" {place}>
{pad}  <inertial {inertial}/>
{pad}  {_joint(ready, joints[k], axis)}
{inside}{pad}</body>
"""

    bodies = "".join(body(k, 2) for k, carrier in enumerate(above) if carrier is None)
    frames = (
        "Frames, axes, zeros and signs are those of the model."
        if ready.model.spatial
        else "z is up, x forward; angles turn about -y; zero is the machine hanging straight down."
    )
    gravity = " ".join(f"{part:.17g}" for part in gravity_of(ready))
    swaying = "\n     The base is measured: move it as it moved." if ready.model.moving_base else ""
    return {
        f"{options.name}.xml": f"""<?xml version="1.0" encoding="utf-8"?>
<!-- Written by exoid for MuJoCo. Masses and inertias are one choice of many with the identified parameters.
     {frames}{swaying}
     frictionloss is Coulomb friction, a constraint of MuJoCo that is a little soft at rest, though made hard here
     (solimpfriction), where the model has the sign of the velocity; damping is viscous friction; armature is the
     drive's inertia times its gear ratio squared,
     where the bodies do not contain it.
     Effects of the model that MJCF cannot carry: {left_out(ready, CARRIED)}. -->
<mujoco model="{options.name}">
  <compiler angle="radian" autolimits="true" eulerseq="XYZ"/>
  <option gravity="{gravity}"/>
  <worldbody>
{bodies}  </worldbody>
</mujoco>
"""
    }


def _in_a_plane(ready: Ready) -> list[tuple[str, str, str]]:
    """Return attributes of every link: of its body, of the inertial of that, and its joint's axis."""
    joints, found = tree_of(ready.model), []
    for joint, parent, item in zip(joints, parents(joints), links_of(ready), strict=True):
        down = 0.0 if parent is None else float(joints[parent].length or 0.0)
        (along, across), own = item.centre, item.about_centre
        inertial = f'pos="{across!r} 0 {-along!r}" mass="{item.mass!r}" diaginertia="{own!r} {own!r} {own!r}"'
        found.append((f'pos="0 0 {0.0 - down!r}"', inertial, "0 -1 0" if joint.turns else "0 0 -1"))
    return found


def _in_space(ready: Ready) -> list[tuple[str, str, str]]:
    """Return the same of a spatial machine."""
    found = []
    for joint, item in zip(ready.model.joints, bodies_of(ready), strict=True):
        origin, tensor = joint.origin or HERE, item.inertia
        entries = _numbers(tensor[place] for place in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)))
        inertial = f'pos="{_numbers(item.centre)}" mass="{item.mass!r}" fullinertia="{entries}"'
        place = f'pos="{_numbers(origin.xyz)}" euler="{_numbers(origin.rpy)}"'
        found.append((place, inertial, _numbers(joint.axis or ())))
    return found


def _numbers(values: Iterable[float]) -> str:
    return " ".join(repr(float(value)) for value in values)


def _joint(ready: Ready, joint: Joint, axis: str) -> str:
    damping, friction = friction_of(ready, joint.name)
    kind = "hinge" if joint.turns else "slide"
    entries = {"name": joint.name, "type": kind, "axis": axis, "damping": repr(damping), "frictionloss": repr(friction)}
    if friction:
        entries["solimpfriction"] = HARD
    limit = ready.model.limits.get(joint.name)
    if limit is not None and isfinite(limit.angle[0]):
        entries["range"] = f"{limit.angle[0]!r} {limit.angle[1]!r}"
    rotor, spring = (terms_of(ready, effect).get(joint.name) for effect in CARRIED)
    if rotor is not None:
        entries["armature"] = repr(max(0.0, ready.linear[f"{rotor.name}.c"]))
    if spring is not None and (stiffness := ready.linear[f"{spring.name}.k"]) > 0.0:
        rest = -ready.linear[f"{spring.name}.c"] / stiffness
        entries |= {"stiffness": repr(stiffness), "springref": repr(rest)}
    return "<joint " + " ".join(f'{key}="{value}"' for key, value in entries.items()) + "/>"
