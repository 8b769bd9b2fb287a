"""The jobs of a campaign on disk: one small file each, written whole, so that what was stopped goes on.

A file is named by a key of everything its answer depends on (recordings by their bytes, model, command, options, seed,
versions) and carries a hash of its content: a file that was cut or edited counts as not there.
"""

from __future__ import annotations

import base64
import json
import os
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any

from ground.errors import ExoidError, refused
from ground.files import sha256, sha256_file, write_whole
from ground.inputs import read_input
from workbench.campaign.plan import Job

SCHEMA = "exoid.campaign_job/1"
LARGEST = 500_000_000
"""Bytes of an answer that is read back; one has some thousand."""
FINAL = ("done", "refused")
"""Answers that would be the same again; a job that crashed or was late is tried again when the campaign goes on."""


class CampaignError(ExoidError):
    """A campaign that cannot start or go on."""


class JobStore:
    """The answers in `folder`/jobs."""

    def __init__(self, folder: Path, versions: Mapping[str, str]) -> None:
        self._home, self._folder = folder, folder / "jobs"
        self._versions = dict(versions)

    def key(self, job: Job) -> str:
        """Return the hash of everything the answer to `job` depends on."""
        model = None if job.model is None else _model_text(job.model)
        files = {role: [[Path(p).name, _hash(p)] for p in getattr(job, role)] for role in ("recordings", "verify")}
        parts = [job.verb, job.options, job.seed, job.case, model, files, self._versions]
        return sha256(json.dumps(parts, sort_keys=True))

    def path(self, job: Job, key: str) -> Path:
        """Return where the answer to `job` is kept."""
        return self._folder / f"{job_file_name(job.name, key)}.json"

    def read(self, job: Job, key: str) -> dict[str, Any] | None:
        """Return the row of `job` if it is there, whole and unchanged."""
        try:
            found = json.loads(read_input(self.path(job, key), LARGEST, remember=False, inside=self._home))
            row = found["row"]
            if found["schema"] == SCHEMA and found["key"] == key and found["sha256"] == _checksum(key, row):
                return dict(row)
        except (OSError, ValueError, KeyError, TypeError, RecursionError):
            return None
        return None

    def write(self, job: Job, key: str, row: Mapping[str, Any]) -> Path:
        """Keep the row of `job`, whole or not at all."""
        content = {"schema": SCHEMA, "key": key, "row": row, "sha256": _checksum(key, row)}
        return write_whole(self.path(job, key), json.dumps(content, indent=1) + "\n", at_once=True, inside=self._home)


def task_of(job: Job, *, ships: bool, report: bool, versions: Mapping[str, str]) -> dict[str, Any]:
    """Return `job` as a worker gets it: plain data, with the recordings' bytes where it `ships` them."""

    def sent(path: str) -> dict[str, Any]:
        if not ships:
            return {"path": os.path.realpath(path), "data": None}
        return {"path": Path(path).name, "data": base64.b64encode(Path(path).read_bytes()).decode("ascii")}

    return {
        "verb": job.verb, "options": list(job.options), "seed": job.seed, "case": job.case,
        "recordings": [sent(path) for path in job.recordings], "verify": [sent(path) for path in job.verify],
        "model": None if job.model is None else _model_text(job.model), "report": report, "versions": dict(versions),
    }  # fmt: skip


def job_file_name(name: str, key: str) -> str:
    """Return what the files of a job are called, without suffix: letters, digits, dot, dash and underscore only."""
    kept = "".join(c if c.isascii() and (c.isalnum() or c in "._") else "-" for c in name)
    return f"{kept.strip('-.')[:80] or 'job'}-{key[:16]}"


def _checksum(key: str, row: Mapping[str, Any]) -> str:
    return sha256(key + json.dumps(row, sort_keys=True))


@lru_cache(maxsize=256)
def _model_text(path: str) -> str:
    with refused(CampaignError, "the model file cannot be read", path, "see model in the plan", (OSError, ValueError)):
        return Path(path).read_text("utf-8")


@lru_cache(maxsize=100_000)
def _hash(path: str) -> str:
    with refused(CampaignError, "cannot be read: {}", path, "check the file"):
        return sha256_file(path)
