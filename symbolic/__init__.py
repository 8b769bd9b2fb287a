"""What the leg is: mechanism, effects, model, and the code generated from them."""

from symbolic.effect import Coefficient, Effect, Shape
from symbolic.model import Limits, Model
from symbolic.motion import Motion

__all__ = ["Coefficient", "Effect", "Limits", "Model", "Motion", "Shape"]
