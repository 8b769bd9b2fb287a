"""Estimation of numbers: fitness, optimisers, reference optimum with certificate, identification.

In a notebook: `from exoid.optimisation import identify, prepare`; `fit = identify(leg, prepare(leg, [run]).train)`.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
