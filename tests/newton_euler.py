"""A planar two-link arm by Newton and Euler, written without a look at the package: forces first, energies never.

Angles from the downward vertical, x to the front, z upwards. Each link's centre of mass lies `along` the link and
`across` it (positive to the front when hanging). `tilt` turns gravity, `offset` is added to the encoder readings.
"""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Leg:
    m: tuple[float, float]
    inertia: tuple[float, float]
    along: tuple[float, float]
    across: tuple[float, float] = (0.0, 0.0)
    length: float = 0.4
    g: float = 9.81
    tilt: float = 0.0
    offset: tuple[float, float] = (0.0, 0.0)


def cross(a, b):
    """The y-component, positive for a turn from down to front, of a planar cross product."""
    return a[0] * b[1] - a[1] * b[0]


def point_acceleration(arm, omega, alpha):
    """Acceleration of the end of `arm` that turns with omega and alpha about its start."""
    turned = np.array([-arm[1], arm[0]])
    return alpha * turned - omega**2 * arm


def torque(leg, q, dq, ddq, base=(0.0, 0.0)):
    """Joint torques (2,) that this motion takes; `base` is the acceleration of the hip."""
    phi = np.cumsum(np.asarray(q) + np.asarray(leg.offset))
    omega, alpha = np.cumsum(dq), np.cumsum(ddq)
    gravity = leg.g * np.array([-np.sin(leg.tilt), -np.cos(leg.tilt)])
    down = [np.array([np.sin(p), -np.cos(p)]) for p in phi]
    front = [np.array([np.cos(p), np.sin(p)]) for p in phi]
    com = [leg.along[k] * down[k] + leg.across[k] * front[k] for k in range(2)]
    thigh = leg.length * down[0]
    hip_acceleration = np.asarray(base)
    knee_acceleration = hip_acceleration + point_acceleration(thigh, omega[0], alpha[0])
    acceleration = [
        hip_acceleration + point_acceleration(com[0], omega[0], alpha[0]),
        knee_acceleration + point_acceleration(com[1], omega[1], alpha[1]),
    ]
    # From the foot upwards: the force through a joint, and the moment about it.
    force_knee = leg.m[1] * (acceleration[1] - gravity)
    moment_knee = leg.inertia[1] * alpha[1] + cross(com[1], force_knee)
    force_thigh = leg.m[0] * (acceleration[0] - gravity)
    moment_hip = leg.inertia[0] * alpha[0] + cross(com[0], force_thigh) + cross(thigh, force_knee) + moment_knee
    return np.array([moment_hip, moment_knee])


def base_parameters(leg):
    """Φ1 to Φ4 of the paper for this leg (centres of mass across the link count towards the inertias)."""
    own = [leg.inertia[k] + leg.m[k] * (leg.along[k] ** 2 + leg.across[k] ** 2) for k in range(2)]
    carried = leg.m[1] * leg.length**2
    return np.array(
        [
            own[0] + own[1] + carried,
            own[1],
            leg.m[1] * leg.length * leg.along[1],
            leg.m[0] * leg.length * leg.along[0] - own[0],
        ]
    )
