"""The names that `exoid.optimisation` hands out, each loaded from its module at first use."""

from .contest.rivals import entrants as entrants
from .contest.rivals import rivals as rivals
from .excitation.design import design as design
from .excitation.design import evaluate as evaluate
from .excitation.design import evaluate_paper as evaluate_paper
from .fitting.fit import Fit as Fit
from .fitting.identify import identify as identify
from .fitting.settings import Search as Search
from .paper.reproduce import paper_items as paper_items
from .paper.reproduce import reproduce_paper as reproduce_paper
from .preparation.prepare import prepare as prepare
