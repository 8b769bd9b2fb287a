"""The names that `exoid.optimisation` hands out, each loaded from its module at first use."""

from .contest.rivals import entrants as entrants
from .contest.rivals import rivals as rivals
from .excitation.design import design as design
from .excitation.design import evaluate as evaluate
from .excitation.design import evaluate_paper as evaluate_paper
from .fitting.fit import Fit as Fit
from .fitting.identify import identify as identify
from .fitting.settings import Search as Search
from .preparation.prepare import prepare as prepare
