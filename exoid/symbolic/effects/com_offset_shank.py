"""Centre of mass of the shank off the line from knee to foot, derived by Lagrange from a shank with COM
(l_sh, y).

One number is left beyond Φ1 to Φ4, the first moment m_y = m_sh y. It weighs on both joints (g cos(θ1 + θ2))
and couples their accelerations through sin θ2 where Φ3 couples them through cos θ2.
"""

from __future__ import annotations

from exoid.symbolic.effect import Coefficient, Effect
from exoid.symbolic.effects.com_offset import derive

EFFECT = Effect(
    id="com_offset_shank",
    title="Shank mass off axis",
    explains="The shank carries weight in front or behind (a calf box), so it does not hang straight.",
    derive=derive,
    joints=("both",),
    machines="leg",
    coefficients={
        "m_y": Coefficient("kg·m", min=-5.0, max=5.0, typical=0.2, explains="mass times distance, forward positive")
    },
    family="gravity",
    tells_apart="Slow knee swings at several thigh angles, then fast ones: it weighs and it couples.",
    reference=(
        "Gautier, Khalil, Direct calculation of minimum set of inertial parameters of serial robots, "
        "IEEE Transactions on Robotics and Automation 6(3), 368-373, 1990"
    ),
)
