"""Encoders at the motor of a drive that gives way: they turn by what is between them and the link.

The link obeys its equation of motion; its encoder reads the link's angle plus the deflection of the effect. What is
not rigid body (friction above all) sits at the motor and acts with the encoder's motion. Nothing is to first order.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from exoid.measurement.bench.hidden import TrueModel
from exoid.symbolic.columns import model_torque, rigid_model
from exoid.symbolic.language.deflection import SLOW
from exoid.symbolic.language.lower import to_numpy
from exoid.symbolic.language.operators import slow
from exoid.symbolic.language.parser import parse
from exoid.symbolic.motion import Float, Motion


def at_encoders(true: TrueModel, mechanical: TrueModel, link: Motion) -> Motion:
    """Return the motion that encoders see, for that of the links on a uniform clock; itself where nothing gives way.

    `mechanical` is the model that the links obey.
    """
    terms = [term for term in true.model.terms if term.effect.deflection is not None]
    if not terms:
        return link
    t = link.t
    states = link.q, link.dq, link.ddq
    numbers = true.numbers()
    # The inertia of a rotor keeps the deflection from following the chatter of the controller.
    torque = rigid_torque(mechanical, link)
    smooth = np.column_stack([slow(link.t, torque[:, j], SLOW) for j in range(torque.shape[1])])
    turned = np.zeros_like(link.q)
    for term in terms:
        joint = term.first
        words: dict[str, Any] = {
            "t": t,
            "theta": states[0][:, joint],
            "dtheta": states[1][:, joint],
            "ddtheta": states[2][:, joint],
        }
        words |= {"tau_rigid": smooth[:, joint]}
        words |= {key: numbers[f"{term.name}.{key}"] for key in term.effect.shape}
        for key, angle in (term.effect.deflection or {}).items():
            turned[:, joint] += numbers[f"{term.name}.{key}"] * to_numpy(parse(angle, words.keys()), words)
    speed = np.gradient(turned, t, axis=0, edge_order=2)
    moving = link.dq + speed
    # A joint that sticks has a sign between -1 and 1; its motor sticks with it.
    sign = np.where(np.abs(link.sign) < 1.0 - 1e-9, link.sign, np.sign(moving))
    return replace(
        link,
        q=link.q + turned,
        dq=moving,
        ddq=link.ddq + np.gradient(speed, t, axis=0, edge_order=2),
        sign=np.where(turned.any(axis=0), sign, link.sign),
    )


def rigid_torque(true: TrueModel, motion: Motion) -> Float:
    """Return the rigid-body part (N, J) N·m of the torque."""
    numbers, bare = true.numbers(), rigid_model(true.model.unpushed)
    linear = np.array([numbers[entry.name] for entry in bare.parameters])
    linear[bare.friction] = 0.0
    return model_torque(bare, motion, linear, np.array([numbers[entry.name] for entry in bare.shapes]))
