"""Measurements: recordings, their audit, signals, and the virtual test bench.

In a notebook: `from exoid.measurement import read_recording`; `run = read_recording("run1.csv")`.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
