"""What the leg is: mechanism, effects, model, and the code generated from them.

In a notebook: `from symbolic import Model`; `leg = Model.standard().with_effect("stribeck", joint="knee")`.
"""

from typing import TYPE_CHECKING

from ground.lazy import lend, lend_methods

if TYPE_CHECKING:
    from symbolic.catalogue import catalogue as catalogue
    from symbolic.catalogue import find_effect as find_effect
    from symbolic.check import check_equations as check_equations
    from symbolic.codegen.code import stale_files as stale_files
    from symbolic.codegen.kernel import compiled as compiled
    from symbolic.effect import Coefficient as Coefficient
    from symbolic.effect import Effect as Effect
    from symbolic.effect import Shape as Shape
    from symbolic.joints import Joint as Joint
    from symbolic.mechanics.payload import Payload as Payload
    from symbolic.mechanics.regressor import regressor as regressor
    from symbolic.model import Limits as Limits
    from symbolic.model import Model as Model
    from symbolic.model_file import read_model as read_model
    from symbolic.model_file import write_model as write_model
    from symbolic.motion import Motion as Motion

__all__ = lend(__name__)

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
