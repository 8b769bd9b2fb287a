"""How numbers are found: fitness, optimisers, reference optimum with certificate, identification.

In a notebook: `from optimisation import identify, prepare`; `fit = identify(leg, prepare(leg, [run]).train)`.
"""

from typing import TYPE_CHECKING

from symbolic.lazy import lend

if TYPE_CHECKING:
    from optimisation.fit import Fit
    from optimisation.identify import identify
    from optimisation.prepare import prepare
    from optimisation.rivals import rivals

__all__ = ["Fit", "identify", "prepare", "rivals"]

lend(
    __name__,
    {
        "Fit": "optimisation.fit",
        "identify": "optimisation.identify",
        "prepare": "optimisation.prepare",
        "rivals": "optimisation.rivals",
    },
)
