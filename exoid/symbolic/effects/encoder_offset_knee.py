"""The knee encoder reads too little: θ2 -> θ2 + offset everywhere inside the model.

The knee's zero enters inertia, velocity and gravity terms alike. Turning the shank about the knee also takes its
centre of mass off its axis, so a shank with its mass off axis gives exactly the same equations.
"""

from __future__ import annotations

from exoid.symbolic.effect import Effect, Shape
from exoid.symbolic.effects.encoder_offset import derive

EFFECT = Effect(
    id="encoder_offset_knee",
    title="Knee encoder zero",
    explains="The zero of the knee encoder is off: the knee is bent more or less than the reading says.",
    derive=derive,
    joints=("both",),
    machines="leg",
    shape={"offset": Shape("rad", min=-0.8, max=0.8, points=9, typical=0.05, explains="true angle minus reading")},
    family="sensor",
    tells_apart="Move the knee to its mechanical stop and compare the reading with the drawing.",
    reference="Hollerbach, Khalil, Gautier, Model identification, Springer Handbook of Robotics, 2nd ed., 2016, ch. 6",
)
