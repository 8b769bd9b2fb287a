"""While it runs, and afterwards: what changed between motion before and motion after, and when."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
