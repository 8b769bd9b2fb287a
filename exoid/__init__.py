"""One door to everything a notebook needs.

    import exoid

    leg = exoid.Model.standard(thigh_length=0.40)
    found = exoid.discover(leg, ["run1.csv", "run2.csv", "run3.csv"], verify="run4.csv")
    found.report("out")

the leg          `Model`, `Effect`, `Coefficient`, `Shape`, `Limits`, `Motion`, `catalogue`, `read_model`, `write_model`
any machine      `Joint`, `Payload`, `Body` (the limb of a wearer); its equations and code: `mechanics`, `equations`,
                 `regressor`, `check_equations`, `compiled`
measurements     `read_recording`, `Recording`, `Finding`, `write_recording`; the virtual bench: `Bench`, `Hidden`,
                 `simulate`, `simulate_runs`, `draw_hidden`, `Wearer`, `Walk`
numbers          `prepare`, `identify`, `Fit`, `rivals`; motions to record: `design`, `evaluate`, `evaluate_paper`
the paper        `reproduce_paper`, `paper_items`: its figures, tables and equations, made again
what is missing  `compare`, `diagnose`, `discover`, `add`, `watch`, `separate`; all of one preparation: `Session`;
                 a fit with its errors: `fitted_model`
figures          `figure_style`, `new_figure`, `label`
bad input        `ExoidError`: what is wrong, where, what to do

Wherever recordings are asked for, paths, folders, DataFrames, mappings {name: array} and arrays will do, one or many.
`dir(exoid)` has them all. Every name lives in one of the packages `exoid.symbolic`, `exoid.measurement`,
`exoid.optimisation` and `exoid.diagnosis`, which can be imported from as well, and is loaded at its first use:
`import exoid` itself costs nothing.
"""

from exoid.places import folders_of_packages, leave_out_folder_of_m

leave_out_folder_of_m()  # first: a `typing.py` lies there perhaps
__path__ = folders_of_packages()

from typing import TYPE_CHECKING  # noqa: E402

from exoid.ground.lazy import lend  # noqa: E402

if TYPE_CHECKING:
    from exoid.diagnosis import *  # noqa: F403
    from exoid.ground.errors import ExoidError as ExoidError
    from exoid.ground.figures import figure_style as figure_style
    from exoid.ground.figures import label as label
    from exoid.ground.figures import new_figure as new_figure
    from exoid.ground.version import __version__ as __version__
    from exoid.measurement import *  # noqa: F403
    from exoid.optimisation import *  # noqa: F403
    from exoid.symbolic import *  # noqa: F403
    from exoid.symbolic.mechanics.lagrange import mechanics as mechanics  # `exoid.symbolic.mechanics` is a folder

__all__ = lend(__name__)
