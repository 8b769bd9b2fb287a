"""Torque that pulsates with the angle: a sin(nθ) + b cos(nθ)."""

from __future__ import annotations

from exoid.symbolic.effect import Coefficient, Effect, Shape

EFFECT = Effect(
    id="torque_ripple",
    title="Torque ripple",
    family="drive",
    drive=True,
    torque="a * sin(n * theta) + b * cos(n * theta)",
    coefficients={
        "a": Coefficient("N·m", typical=2.0, explains="sine part"),
        "b": Coefficient("N·m", typical=2.0, explains="cosine part"),
    },
    shape={
        "n": Shape(
            "1",
            min=3.0,
            max=400.0,
            points=398,
            typical=60.0,
            counts_angle=True,
            explains="cycles per turn of the joint: pole pairs or teeth times gear ratio (2π over its period)",
        )
    },
    explains=("The torque pulsates at fixed angles: motor poles, gear teeth, the wave generator of a harmonic drive."),
    tells_apart=(
        "Very slow motion at constant speed: the pulsation must keep its place over the angle at every speed."
    ),
    reference=(
        "Jahns, Soong, Pulsating torque minimization techniques for permanent magnet AC motor drives: a "
        "review, IEEE Transactions on Industrial Electronics 43(2), 321-330, 1996"
    ),
)
