"""A spring that gets stiffer away from its middle: k (θ - θ_m)³."""

from __future__ import annotations

from exoid.symbolic.effect import Coefficient, Effect, Shape

EFFECT = Effect(
    id="hardening_spring",
    title="Hardening spring",
    family="spring",
    torque="k * (theta - theta_m)**3",
    coefficients={"k": Coefficient("N·m/rad³", min=0.0, typical=5.0, explains="cubic stiffness")},
    shape={"theta_m": Shape("rad", min=-2.0, max=2.0, points=41, typical=0.0, explains="angle without torque")},
    explains="Near the middle the joint moves freely, and towards both ends an elastic part stiffens.",
    tells_apart="Hold still at many angles over the full range, both ends included.",
    reference=("Kovacic, Brennan (eds), The Duffing Equation: Nonlinear Oscillators and their Behaviour, Wiley, 2011"),
)
