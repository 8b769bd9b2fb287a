"""The search for missing effects: comparison, suspects, look-alikes, verdict, extension.

In a notebook: `from exoid.diagnosis import compare, discover, watch`; `found = discover(leg, train, verify)`.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
