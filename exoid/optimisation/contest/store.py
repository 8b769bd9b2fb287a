"""Runs of a comparison on disk, one small JSON file each, so that what was stopped can go on.

A file is named by optimiser, seed and a key of everything its result depends on, and written whole or not at all. A
file that cannot be read, or that belongs to other data or settings, counts as not there. So does one that was damaged
or altered: it has to match its own hash, and the best parameters it names have to come as near the optimum as it says.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from exoid.ground.files import sha256, write_whole
from exoid.ground.inputs import read_input
from exoid.ground.plain import SPOILT
from exoid.optimisation.contest.problem import Outcome
from exoid.optimisation.contest.subject import ContestSubject
from exoid.optimisation.fitting.settings import Search

SCHEMA = "exoid.rival_run/1"
LARGEST = 50_000_000
"""Bytes; a run has some thousands of improvements at most."""
SAME = 1e-9
"""Difference of two gaps that is rounding."""


class RunStore:
    """The runs of one contest in `folder`; without a folder nothing is kept."""

    def __init__(self, folder: str | Path | None, contest: ContestSubject) -> None:
        self._folder = None if folder is None else Path(folder)
        self._contest = contest
        self._fingerprint = "" if folder is None else contest.fingerprint()
        self.damaged = 0
        """How many files were there and not to be believed."""

    def read(self, name: str, search: Search, seed: int) -> Outcome | None:
        """Return the run if it is there, whole, and of these data and settings."""
        if self._folder is None:
            return None
        key = self._key(name, search, seed)
        path = self._path(name, seed, key)
        try:
            found = json.loads(read_input(path, LARGEST, remember=False, inside=self._folder))
            if found["schema"] != SCHEMA or found["key"] != key or found["sha256"] != _hash(found):
                raise ValueError("altered")
            run = found["run"]
            arrays = {name: np.array(run[name], dtype=float) for name in ("found_at", "gaps", "x")}
            outcome = Outcome(**{**run, **arrays})
            if outcome.name == name and outcome.seed == seed and self._holds(outcome, search):
                return outcome
        except FileNotFoundError:
            return None
        except (OSError, *SPOILT):
            pass
        self.damaged += 1
        return None

    def _holds(self, outcome: Outcome, search: Search) -> bool:
        """True if a run is one that can be: improvements in order, and at its best point the gap it names."""
        at, gaps = outcome.found_at, outcome.gaps
        if not (at.ndim == 1 and at.shape == gaps.shape and at.size and outcome.x.shape == (self._contest.size,)):
            return False
        ordered = (
            np.all(np.diff(at) > 0) and np.all(np.diff(gaps) <= 0) and at[0] >= 1 and at[-1] <= outcome.evaluations
        )
        if not ordered or not np.isfinite(outcome.x).all() or not outcome.seconds >= 0.0:
            return False
        gap = float(self._contest.gap(np.array(self._contest.value(outcome.x, search))))
        return gap == outcome.gap or abs(gap - outcome.gap) <= SAME * (1.0 + gap)

    def write(self, outcome: Outcome, search: Search) -> None:
        """Keep a run."""
        if self._folder is None:
            return
        key = self._key(outcome.name, search, outcome.seed)
        content = {"schema": SCHEMA, "key": key, "settings": repr(search), "run": outcome.to_json()}
        content["sha256"] = _hash(content)
        # A fitness that was infinite is written as Infinity, which Python reads back.
        path = self._path(outcome.name, outcome.seed, key)
        write_whole(path, json.dumps(content), at_once=True, inside=self._folder)

    def _key(self, name: str, search: Search, seed: int) -> str:
        return sha256(json.dumps([self._fingerprint, name, repr(search), seed]))

    def _path(self, name: str, seed: int, key: str) -> Path:
        assert self._folder is not None
        return self._folder / f"{name}-{seed:05d}-{key[:12]}.json"


def _hash(content: dict[str, Any]) -> str:
    """Return the hash of a run, its key and its settings."""
    return sha256(json.dumps([content["key"], content["settings"], content["run"]], sort_keys=True))
