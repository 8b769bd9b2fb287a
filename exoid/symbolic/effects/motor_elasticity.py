"""An elastic drive whose encoder sits at the motor: the link stays behind by the twist τ / K.

τ is the model's rigid-body torque, which gear, belt or cable pass on; friction sits before them, with the encoder. To
first order in the twist. Where the encoder sits at the joint, the angles are right: `joint_elasticity`.
"""

from __future__ import annotations

from exoid.symbolic.effect import Coefficient, Effect

EFFECT = Effect(
    id="motor_elasticity",
    title="Elastic drive, encoder at the motor",
    family="drive",
    drive=True,
    deflection={"c": "tau_rigid"},
    coefficients={
        "c": Coefficient("rad/(N·m)", min=0.0, typical=0.001, explains="compliance 1/K of gear, belt or cable")
    },
    explains=(
        "Gear, belt or cable deform under load, and the encoder sits before them: the joint is not where it says, "
        "which all joints feel."
    ),
    tells_apart=(
        "Clamp the joint and load the drive: the encoder shows the twist per torque. Or a second encoder at the joint."
    ),
    reference=(
        "Spong, Modeling and control of elastic joint robots, ASME Journal of Dynamic Systems, "
        "Measurement, and Control 109(4), 310-319, 1987"
    ),
)
