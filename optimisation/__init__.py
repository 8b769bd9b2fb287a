"""How numbers are found: fitness, optimisers, reference optimum with certificate, identification.

In a notebook: `from optimisation import identify, prepare`; `fit = identify(leg, prepare(leg, [run]).train)`.
"""

from typing import TYPE_CHECKING

from ground.lazy import lend

if TYPE_CHECKING:
    from optimisation.contest.rivals import entrants as entrants
    from optimisation.contest.rivals import rivals as rivals
    from optimisation.excitation.design import design as design
    from optimisation.excitation.design import evaluate as evaluate
    from optimisation.excitation.design import evaluate_paper as evaluate_paper
    from optimisation.fitting.fit import Fit as Fit
    from optimisation.fitting.identify import Search as Search
    from optimisation.fitting.identify import identify as identify
    from optimisation.paper.reproduce import paper_items as paper_items
    from optimisation.paper.reproduce import reproduce_paper as reproduce_paper
    from optimisation.preparation.prepare import prepare as prepare

__all__ = lend(__name__)
