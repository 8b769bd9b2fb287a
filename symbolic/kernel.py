"""What runs fast: fitness kernels and compiled models, under one roof."""

from __future__ import annotations

from symbolic.compiler import NoCompilerWarning
from symbolic.fitness import Fitness, fitness

__all__ = ["Fitness", "NoCompilerWarning", "fitness"]
