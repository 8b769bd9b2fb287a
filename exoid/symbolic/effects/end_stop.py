"""A one-sided spring near the end of the range: c max(0, ±(θ - θ_s))."""

from __future__ import annotations

from exoid.symbolic.effect import Coefficient, Effect, Shape

EFFECT = Effect(
    id="end_stop",
    title="End stop",
    family="contact",
    torque="c * side * max(0, side * (theta - theta_s))",
    coefficients={"c": Coefficient("N·m/rad", min=0.0, typical=50.0, explains="stiffness of the stop")},
    shape={
        "theta_s": Shape(
            "rad",
            min=-2.0,
            max=2.0,
            spacing="position",
            points=41,
            explains="angle at which contact begins; strapping and encoder zero may move it between recordings",
            per_recording=True,
        ),
        "side": Shape(
            "1",
            min=-1.0,
            max=1.0,
            choices=(-1.0, 1.0),
            points=2,
            explains="+1: at large angles, -1: at small angles",
        ),
    },
    explains="Beyond a certain angle something is pressed: a bumper, a cable, soft tissue.",
    tells_apart="Go slowly into the end of the range and back, on both sides.",
    reference=(
        "Hatze, A three-dimensional multivariate model of passive human joint torques and articular "
        "boundaries, Clinical Biomechanics 12(2), 128-135, 1997"
    ),
)
