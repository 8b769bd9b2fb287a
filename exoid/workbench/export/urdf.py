"""URDF of the rigid machine: masses, centres of mass and inertias that reproduce the identified parameters exactly.

Base parameters do not fix them: many machines have the same numbers, so the same torques. One of them is chosen
(`exoid/optimisation/linear/links.py`). URDF carries damping and friction of a joint, but few of the effects; the
others are named in the file.
"""

from __future__ import annotations

from collections.abc import Iterable
from math import isfinite

from exoid.optimisation.linear.bodies import Body3D
from exoid.optimisation.linear.links import LinkInertia, tree_of
from exoid.symbolic.joints import HERE, Joint, parents
from exoid.symbolic.model_structure import STANDARD_GRAVITY
from exoid.workbench.bodies import (
    base_name,
    bodies_of,
    friction_of,
    gravity_of,
    left_out,
    link_names,
    links_of,
)
from exoid.workbench.identified import Options, Ready

HELP = "URDF of the rigid machine with viscous and Coulomb friction"
UNLIMITED = 1e3
"""rad, rad/s, m: limits of a joint whose model has none. A `continuous` joint has two coordinates in some libraries."""


def write(ready: Ready, options: Options) -> dict[str, str]:
    """Return {file name: text}; ExportError where no machine of positive masses has the numbers."""
    joints, names = tree_of(ready.model), link_names(ready)
    base = base_name(names)
    if ready.model.spatial:
        named = zip(names, bodies_of(ready), strict=True)
        parts = [f'  <link name="{name}">{inertial_of(item)}</link>' for name, item in named]
    else:
        parts = [_link(name, entry) for name, entry in zip(names, links_of(ready), strict=True)]
    for joint, child, parent in zip(joints, names, parents(joints), strict=True):
        above = base if parent is None else names[parent]
        if joint.axis is not None:
            origin = joint.origin or HERE
            xyz, rpy = _numbers(origin.xyz), _numbers(origin.rpy)
            parts.append(_joint(ready, joint, above, child, f'xyz="{xyz}" rpy="{rpy}"', _numbers(joint.axis)))
            continue
        down = 0.0 if parent is None else float(joints[parent].length or 0.0)
        axis = "0 -1 0" if joint.turns else "0 0 -1"
        parts.append(_joint(ready, joint, above, child, f'xyz="0 0 {0.0 - down!r}"', axis))
    x, y, z = gravity_of(ready)
    gravity = "" if (x, y, z) == (0.0, 0.0, -STANDARD_GRAVITY) else f" Its gravity is ({x:g}, {y:g}, {z:g}) m/s^2."
    frames = (
        "Frames, axes, zeros and signs are those of the model."
        if ready.model.spatial
        else "z is up, x forward; angles turn about -y; zero is the machine hanging straight down."
    )
    swaying = " The base is measured: move it as it moved." if ready.model.moving_base else ""
    text = "\n".join(parts)
    return {
        f"{options.name}.urdf": f"""<?xml version="1.0" encoding="utf-8"?>
<!-- Written by exoid. The rigid machine; masses and inertias are one choice of many with the identified parameters.
     {frames}{gravity}{swaying}
     damping and friction are torques at the joint, viscous and Coulomb. Libraries for inverse dynamics (Pinocchio, KDL)
     leave them out; add them there, or export C.
     Effects of the model that URDF cannot carry: {left_out(ready)}. effort is not identified: set your drive's. -->
<robot name="{options.name}">
  <link name="{base}"/>
{text}
</robot>
"""
    }


def _link(name: str, one: LinkInertia) -> str:
    # Only the inertia about y moves in a plane; a body of the same size about every axis is always possible.
    (along, across), own = one.centre, one.about_centre
    return f"""  <link name="{name}"><inertial>
    <origin xyz="{across!r} 0 {-along!r}"/><mass value="{one.mass!r}"/>
    <inertia ixx="{own!r}" iyy="{own!r}" izz="{own!r}" ixy="0" ixz="0" iyz="0"/>
  </inertial></link>"""


def inertial_of(one: Body3D) -> str:
    """Return the <inertial> of a body, in its joint's frame."""
    places = (("ixx", 0, 0), ("ixy", 0, 1), ("ixz", 0, 2), ("iyy", 1, 1), ("iyz", 1, 2), ("izz", 2, 2))
    entries = " ".join(f'{name}="{float(one.inertia[i, j])!r}"' for name, i, j in places)
    return (
        f'<inertial><origin xyz="{_numbers(one.centre)}" rpy="0 0 0"/><mass value="{one.mass!r}"/>'
        f"<inertia {entries}/></inertial>"
    )


def _numbers(values: Iterable[float]) -> str:
    return " ".join(repr(float(value)) for value in values)


def _joint(ready: Ready, joint: Joint, parent: str, child: str, origin: str, axis: str) -> str:
    limit, (damping, friction) = ready.model.limits.get(joint.name), friction_of(ready, joint.name)
    bounded = limit is not None and isfinite(limit.angle[0])
    low, high = limit.angle if limit is not None and bounded else (-UNLIMITED, UNLIMITED)
    velocity = limit.velocity if limit is not None and isfinite(limit.velocity) else UNLIMITED
    return f"""  <joint name="{joint.name}" type="{joint.kind}">
    <parent link="{parent}"/><child link="{child}"/><origin {origin}/>
    <axis xyz="{axis}"/><dynamics damping="{damping!r}" friction="{friction!r}"/>
    <limit lower="{low!r}" upper="{high!r}" velocity="{velocity!r}" effort="0"/>
  </joint>"""
