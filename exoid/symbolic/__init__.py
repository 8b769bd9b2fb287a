"""The machine: mechanism, effects, model, and the code generated from them.

In a notebook: `from exoid.symbolic import Model`; `leg = Model.standard().with_effect("stribeck", joint="knee")`.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
