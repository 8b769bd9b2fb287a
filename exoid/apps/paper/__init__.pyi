"""The names that `exoid.apps.paper` hands out, each loaded from its module at first use."""

from .reproduce import paper_items as paper_items
from .reproduce import reproduce_paper as reproduce_paper
