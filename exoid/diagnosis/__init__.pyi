"""The names that `exoid.diagnosis` hands out, each loaded from its module at first use."""

from .against.differences import compare_against as compare_against
from .comparison import compare as compare
from .discovery import diagnose as diagnose
from .discovery import discover as discover
from .evidence.fitted import fitted_model as fitted_model
from .extend import add as add
from .separation.design import separate as separate
from .session import Session as Session
