"""How numbers are found: fitness, optimisers, reference optimum with certificate, identification.

In a notebook: `from optimisation import identify, prepare`; `fit = identify(leg, prepare(leg, [run]).train)`.
"""

from typing import TYPE_CHECKING

from ground.lazy import lend

if TYPE_CHECKING:
    from optimisation.contest.rivals import rivals
    from optimisation.excitation.design import design, evaluate, evaluate_paper
    from optimisation.fitting.fit import Fit
    from optimisation.fitting.identify import identify
    from optimisation.preparation.prepare import prepare

__all__ = ["Fit", "design", "evaluate", "evaluate_paper", "identify", "prepare", "rivals"]

lend(
    __name__,
    {
        "Fit": "optimisation.fitting.fit",
        "design": "optimisation.excitation.design",
        "evaluate": "optimisation.excitation.design",
        "evaluate_paper": "optimisation.excitation.design",
        "identify": "optimisation.fitting.identify",
        "prepare": "optimisation.preparation.prepare",
        "rivals": "optimisation.contest.rivals",
    },
)
