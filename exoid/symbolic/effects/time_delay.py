"""Torque and motion recorded at different moments: τ_model(t - d) instead of τ_model(t).

Loggers that are started by hand, or a bus that is busier in one run than in another, give every recording a delay of
its own.
"""

from __future__ import annotations

from exoid.symbolic.effect import Effect, Shape

EFFECT = Effect(
    id="time_delay",
    title="Time delay",
    family="sensor",
    drive=True,
    torque="delay(tau_model, d) - tau_model",
    shape={
        "d": Shape(
            "s",
            min=-0.1,
            max=0.1,
            points=21,
            typical=0.02,
            explains="delay of the torque; negative: of the motion",
            per_recording=True,
        )
    },
    explains="The torque is logged later (or earlier) than the motion that belongs to it.",
    tells_apart=("Fast reversals and a knock against the machine: both channels must show it at the same moment."),
    reference=(
        "Björklund, Ljung, A review of time-delay estimation techniques, IEEE Conference on Decision and Control, 2003"
    ),
)
