"""What the leg is: mechanism, effects, model, and the code generated from them.

In a notebook: `from symbolic import Model`; `leg = Model.standard().with_effect("stribeck", joint="knee")`.
"""

from typing import TYPE_CHECKING

from ground.lazy import lend

if TYPE_CHECKING:
    from symbolic.catalogue import catalogue as catalogue
    from symbolic.catalogue import find_effect as find_effect
    from symbolic.check import check_equations as check_equations
    from symbolic.codegen.code import stale_files as stale_files
    from symbolic.codegen.kernel import compiled as compiled
    from symbolic.effect import Coefficient as Coefficient
    from symbolic.effect import Effect as Effect
    from symbolic.effect import Shape as Shape
    from symbolic.equations import equations as equations
    from symbolic.equations import regressor as regressor
    from symbolic.joints import Joint as Joint
    from symbolic.mechanics.body import Body as Body
    from symbolic.mechanics.payload import Payload as Payload
    from symbolic.model import Limits as Limits
    from symbolic.model import Model as Model
    from symbolic.model_file import read_model as read_model
    from symbolic.model_file import write_model as write_model
    from symbolic.motion import Motion as Motion

__all__ = lend(__name__)
