"""The names of all packages for type checkers and editors; at run time `__init__.py` finds them."""

from .apps.paper import *  # noqa: F403
from .apps.watch import *  # noqa: F403
from .diagnosis import *  # noqa: F403
from .ground.errors import ExoidError as ExoidError
from .ground.figures import figure_style as figure_style
from .ground.figures import label as label
from .ground.figures import new_figure as new_figure
from .ground.version import __version__ as __version__
from .measurement import *  # noqa: F403
from .optimisation import *  # noqa: F403
from .symbolic import *  # noqa: F403
from .symbolic.mechanics.lagrange import mechanics as mechanics
