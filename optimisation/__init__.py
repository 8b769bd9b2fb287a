"""How numbers are found: fitness, optimisers, reference optimum with certificate, identification.

In a notebook: `from optimisation import identify, prepare`; `fit = identify(leg, prepare(leg, [run]).train)`.
"""

from typing import TYPE_CHECKING

from symbolic.lazy import lend

if TYPE_CHECKING:
    from optimisation.excitation import design, evaluate, evaluate_paper
    from optimisation.fit import Fit
    from optimisation.identify import identify
    from optimisation.prepare import prepare
    from optimisation.rivals import rivals

__all__ = ["Fit", "design", "evaluate", "evaluate_paper", "identify", "prepare", "rivals"]

lend(
    __name__,
    {
        "Fit": "optimisation.fit",
        "design": "optimisation.excitation",
        "evaluate": "optimisation.excitation",
        "evaluate_paper": "optimisation.excitation",
        "identify": "optimisation.identify",
        "prepare": "optimisation.prepare",
        "rivals": "optimisation.rivals",
    },
)
