"""Data printed in the paper and taken from it: numbers of its leg, its thresholds, its claims. No result is here.

Source: "Model Identification of 2-DOF Lower Limb Exoskeleton with Neighborhood Field Optimization Algorithm".
"""

from __future__ import annotations

import numpy as np

PAPER_HUBER = np.array([25.14, 7.42, 1.43, -10.42, 31.35, 12.53, 43.40, 28.01])
PAPER_SSE = np.array([27.97, 12.15, 1.79, -8.41, 31.83, 15.25, 52.39, -5.89])
"""Its two fits (P,), in kg·m², N·m and N·m·s/rad."""
PAPER_DELTA = np.array([138.46, 92.89])
"""N·m: its Huber thresholds of hip and knee."""
PAPER_RATIO = 0.63
"""Error of Huber over that of SSE on its verification motion."""
DURATION, RATE = 35.0, 100.0
"""s and Hz of its recordings."""
CUTOFF = 5.0
"""Hz below which its encoders are read here; the paper does not say how it differentiated."""
