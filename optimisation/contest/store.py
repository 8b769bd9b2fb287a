"""Runs of a comparison on disk, one small JSON file each, so that what was stopped can go on.

A file is named by optimiser, seed and a key of everything its result depends on, and written whole or not at all. A
file that cannot be read, or that belongs to other data or settings, counts as not there.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from ground.files import sha256, write_whole
from optimisation.contest.problem import Contest, Outcome
from optimisation.fitting.identify import Search

SCHEMA = "exoid.rival_run/1"


class Store:
    """The runs of one contest in `folder`; without a folder nothing is kept."""

    def __init__(self, folder: str | Path | None, contest: Contest) -> None:
        self._folder = None if folder is None else Path(folder)
        self._fingerprint = "" if folder is None else contest.fingerprint()

    def read(self, name: str, search: Search, seed: int) -> Outcome | None:
        """Return the run if it is there, whole, and of these data and settings."""
        if self._folder is None:
            return None
        key = self._key(name, search, seed)
        try:
            found = json.loads(self._path(name, seed, key).read_text("utf-8"))
        except (OSError, ValueError):
            return None
        if not isinstance(found, dict) or found.get("schema") != SCHEMA or found.get("key") != key:
            return None
        run = found["run"]
        arrays = {name: np.array(run[name], dtype=float) for name in ("found_at", "gaps", "x")}
        return Outcome(**{**run, **arrays})

    def write(self, outcome: Outcome, search: Search) -> None:
        """Keep a run."""
        if self._folder is None:
            return
        key = self._key(outcome.name, search, outcome.seed)
        content = {"schema": SCHEMA, "key": key, "settings": repr(search), "run": outcome.to_json()}
        # A fitness that was infinite is written as Infinity, which Python reads back.
        write_whole(self._path(outcome.name, outcome.seed, key), json.dumps(content), at_once=True)

    def _key(self, name: str, search: Search, seed: int) -> str:
        return sha256(json.dumps([self._fingerprint, name, repr(search), seed]))

    def _path(self, name: str, seed: int, key: str) -> Path:
        assert self._folder is not None
        return self._folder / f"{name}-{seed:05d}-{key[:12]}.json"
