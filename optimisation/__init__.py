"""How numbers are found: fitness, optimisers, reference optimum with certificate, identification.

In a notebook: `from exoid.optimisation import identify, prepare`; `fit = identify(leg, prepare(leg, [run]).train)`.
"""

from typing import TYPE_CHECKING

from exoid.ground.lazy import lend

if TYPE_CHECKING:
    from exoid.optimisation.contest.rivals import entrants as entrants
    from exoid.optimisation.contest.rivals import rivals as rivals
    from exoid.optimisation.excitation.design import design as design
    from exoid.optimisation.excitation.design import evaluate as evaluate
    from exoid.optimisation.excitation.design import evaluate_paper as evaluate_paper
    from exoid.optimisation.fitting.fit import Fit as Fit
    from exoid.optimisation.fitting.identify import identify as identify
    from exoid.optimisation.fitting.settings import Search as Search
    from exoid.optimisation.paper.reproduce import paper_items as paper_items
    from exoid.optimisation.paper.reproduce import reproduce_paper as reproduce_paper
    from exoid.optimisation.preparation.prepare import prepare as prepare

__all__ = lend(__name__)
