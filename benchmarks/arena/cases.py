"""Every case of the arena, from all plants, in an order of which every part is a fair sample."""

from __future__ import annotations

import importlib
from collections import defaultdict
from pathlib import Path

import numpy as np

from benchmarks.arena.task import Sealed


def folder(name: str) -> list[str]:
    """Return the names of the modules in a folder of the arena."""
    here = Path(__file__).parent / name
    return sorted(path.stem for path in here.glob("*.py") if path.stem != "__init__")


def names(other: int = 0) -> list[str]:
    """Return the name of every case, kinds by turns; with `other`, of as many cases that nobody was tuned to."""
    piles = defaultdict(list)
    for plant in folder("plants"):
        for name in importlib.import_module(f"benchmarks.arena.plants.{plant}").names(other):
            piles[plant, kind_of(f"{plant}/{name}")].append(f"{plant}/{name}")
    for key, pile in piles.items():
        piles[key] = [pile[int(k)] for k in np.random.default_rng(0).permutation(len(pile))]
    longest = max(len(pile) for pile in piles.values())
    return [pile[k] for k in range(longest) for pile in piles.values() if k < len(pile)]


def kind_of(case: str) -> str:
    """Return the kind of a case, without its noise and rate."""
    plant, kind, _ = case.split("/", 2)
    return f"{plant}, {kind.partition('@')[0]}"


def draw(case: str) -> Sealed:
    """Return a case by its name; Left where its plant cannot be simulated here."""
    plant, _, name = case.partition("/")
    sealed: Sealed = importlib.import_module(f"benchmarks.arena.plants.{plant}").draw(name)
    return sealed
