"""The paper, made again: what it prints, its experiments, and one file per figure, table and equation."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
