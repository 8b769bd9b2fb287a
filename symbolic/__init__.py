"""What the leg is: mechanism, effects, model, and the code generated from them.

In a notebook: `from symbolic import Model`; `leg = Model.standard().with_effect("stribeck", joint="knee")`.
"""

from typing import TYPE_CHECKING

from ground.lazy import lend, lend_methods

if TYPE_CHECKING:
    from symbolic.catalogue import catalogue, find_effect
    from symbolic.effect import Coefficient, Effect, Shape
    from symbolic.model import Limits, Model
    from symbolic.model_file import read_model, write_model
    from symbolic.motion import Motion

__all__ = [
    "Coefficient",
    "Effect",
    "Limits",
    "Model",
    "Motion",
    "Shape",
    "catalogue",
    "find_effect",
    "read_model",
    "write_model",
]

lend(
    __name__,
    {
        "Coefficient": "symbolic.effect",
        "Effect": "symbolic.effect",
        "Limits": "symbolic.model",
        "Model": "symbolic.model",
        "Motion": "symbolic.motion",
        "Shape": "symbolic.effect",
        "catalogue": "symbolic.catalogue",
        "find_effect": "symbolic.catalogue",
        "read_model": "symbolic.model_file",
        "write_model": "symbolic.model_file",
    },
)

lend_methods(
    "symbolic.model.Model",
    {
        "columns": "symbolic.columns:model_columns",
        "torque": "symbolic.columns:model_torque",
        "moving_torque": "symbolic.columns:moving_torque",
        "needs_reference": "symbolic.columns:needs_reference",
        "reference_places": "symbolic.columns:reference_places",
        "following_places": "symbolic.columns:following_places",
        "held_places": "symbolic.columns:held_places",
        "following_columns": "symbolic.columns:following_columns",
        "key": "symbolic.codegen.fingerprint:model_key",
    },
    properties=("needs_reference", "reference_places", "following_places", "held_places"),
)
