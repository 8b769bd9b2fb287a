"""What the leg is: mechanism, effects, model, and the code generated from them.

In a notebook: `from exoid.symbolic import Model`; `leg = Model.standard().with_effect("stribeck", joint="knee")`.
"""

from typing import TYPE_CHECKING

from exoid.ground.lazy import lend

if TYPE_CHECKING:
    from exoid.symbolic.catalogue import catalogue as catalogue
    from exoid.symbolic.catalogue import find_effect as find_effect
    from exoid.symbolic.check import check_equations as check_equations
    from exoid.symbolic.codegen.code import stale_files as stale_files
    from exoid.symbolic.codegen.kernel import compiled as compiled
    from exoid.symbolic.effect import Coefficient as Coefficient
    from exoid.symbolic.effect import Effect as Effect
    from exoid.symbolic.effect import Shape as Shape
    from exoid.symbolic.equations import equations as equations
    from exoid.symbolic.equations import regressor as regressor
    from exoid.symbolic.joints import Joint as Joint
    from exoid.symbolic.mechanics.body import Body as Body
    from exoid.symbolic.mechanics.payload import Payload as Payload
    from exoid.symbolic.model import Limits as Limits
    from exoid.symbolic.model import Model as Model
    from exoid.symbolic.model_file import read_model as read_model
    from exoid.symbolic.model_file import write_model as write_model
    from exoid.symbolic.motion import Motion as Motion
    from exoid.symbolic.robot_file import parse_robot as parse_robot
    from exoid.symbolic.robot_file import read_robot as read_robot
    from exoid.symbolic.spatial_machine import robot_machine as robot_machine

__all__ = lend(__name__)
