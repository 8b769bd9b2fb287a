"""The names that `exoid.symbolic` hands out, each loaded from its module at first use."""

from .check import check_equations as check_equations
from .codegen.code import stale_files as stale_files
from .codegen.kernel import compiled as compiled
from .effect import Coefficient as Coefficient
from .effect import Effect as Effect
from .effect import Shape as Shape
from .effect_catalogue import catalogue as catalogue
from .effect_catalogue import find_effect as find_effect
from .joints import Joint as Joint
from .mechanics.body import Body as Body
from .mechanics.payload import Payload as Payload
from .model import Model as Model
from .model import read_model as read_model
from .model import robot_machine as robot_machine
from .model_equations import equations as equations
from .model_equations import regressor as regressor
from .model_file import write_model as write_model
from .model_structure import Limits as Limits
from .motion import Motion as Motion
from .robot_file import parse_robot as parse_robot
from .robot_file import read_robot as read_robot
