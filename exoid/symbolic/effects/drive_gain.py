"""A torque reading in error by a constant factor: c τ_model."""

from __future__ import annotations

from exoid.symbolic.effect import Effect, Shape

EFFECT = Effect(
    id="drive_gain",
    title="Drive gain",
    family="drive",
    drive=True,
    torque="c * tau_model",
    shape={"c": Shape("1", min=-0.5, max=0.5, points=10, typical=0.1, explains="relative error of the gain")},
    explains="The torque constant or the gear ratio behind the torque reading is wrong by some per cent.",
    tells_apart="A known mass added at a known place (--payload); without it the joints cannot be distinguished.",
    reference=(
        "Gautier, Briot, Global identification of joint drive gains and dynamic parameters of robots, "
        "ASME Journal of Dynamic Systems, Measurement, and Control 136(5), 2014"
    ),
)
