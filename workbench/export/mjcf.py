"""MJCF, the model file of MuJoCo: the rigid machine with identified parameters, damping, friction, rotors and springs.

Bodies are those of the URDF (`urdf.py`). MuJoCo's `armature` is the rotor inertia, `stiffness` and `springref` are the
joint spring, `frictionloss` is Coulomb friction; other effects are named in the file.
"""

from __future__ import annotations

from math import isfinite

from exoid.optimisation.linear.links import tree_of
from exoid.symbolic.joints import Joint, parents
from exoid.workbench.bodies import friction_of, left_out, link_names, links_of, terms_of
from exoid.workbench.identified import Options, Ready

HELP = "MJCF (MuJoCo) of the rigid machine with friction, rotor inertias and joint springs"
CARRIED = ("rotor_inertia", "joint_spring")


def write(ready: Ready, options: Options) -> dict[str, str]:
    """Return {file name: text}; ExportError where no machine of positive masses has the numbers."""
    joints, names, links = tree_of(ready.model), link_names(ready), links_of(ready)
    above = parents(joints)

    def body(k: int, depth: int) -> str:
        parent, one = above[k], links[k]
        down = 0.0 if parent is None else float(joints[parent].length or 0.0)
        (along, across), own, pad = one.centre, one.about_centre, "  " * depth
        inside = "".join(body(j, depth + 1) for j, carrier in enumerate(above) if carrier == k)
        return f"""{pad}<body name="{names[k]}" pos="0 0 {0.0 - down!r}">
{pad}  <inertial pos="{across!r} 0 {-along!r}" mass="{one.mass!r}" diaginertia="{own!r} {own!r} {own!r}"/>
{pad}  {_joint(ready, joints[k])}
{inside}{pad}</body>
"""

    bodies = "".join(body(k, 2) for k, carrier in enumerate(above) if carrier is None)
    swaying = "\n     The base is measured: move it as it moved." if ready.model.moving_base else ""
    return {
        f"{options.name}.xml": f"""<?xml version="1.0" encoding="utf-8"?>
<!-- Written by exoid for MuJoCo. Masses and inertias are one choice of many with the identified parameters.
     z is up, x forward; angles turn about -y; zero is the machine hanging straight down.{swaying}
     Effects of the model that MJCF cannot carry: {left_out(ready, CARRIED)}. -->
<mujoco model="{options.name}">
  <compiler angle="radian" autolimits="true"/>
  <option gravity="0 0 {0.0 - ready.model.gravity!r}"/>
  <worldbody>
{bodies}  </worldbody>
</mujoco>
"""
    }


def _joint(ready: Ready, joint: Joint) -> str:
    damping, friction = friction_of(ready, joint.name)
    kind, axis = ("hinge", "0 -1 0") if joint.turns else ("slide", "0 0 -1")
    entries = {"name": joint.name, "type": kind, "axis": axis, "damping": repr(damping), "frictionloss": repr(friction)}
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
