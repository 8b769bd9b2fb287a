"""The jobs of a campaign on disk: one small file each, written whole, so that what was stopped goes on.

A file is named by a key of everything its answer depends on (recordings by their bytes, model, command, options, seed,
versions) and carries a hash of its content: a file that was cut or edited counts as not there.
"""

from __future__ import annotations

import base64
import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from exoid.apps.campaign.plan import Job
from exoid.ground.errors import ExoidError, refused
from exoid.ground.files import sha256, sha256_file, write_whole
from exoid.ground.inputs import read_input
from exoid.ground.inside import refuse_links
from exoid.ground.plain import SPOILT

SCHEMA = "exoid.campaign_job/1"
LARGEST = 500_000_000
"""Bytes of an answer that is read back; one has some thousand."""
FINAL = ("done", "refused")
"""Answers that would be the same again; a job that crashed or was late is tried again when the campaign goes on."""


CHANGED = "it is another file than when the campaign looked at it"


class CampaignError(ExoidError):
    """A campaign that cannot start or go on."""


class AwayError(CampaignError):
    """A recording that cannot be reached at the moment."""


class JobStore:
    """The answers in `folder`/jobs."""

    def __init__(self, folder: Path, versions: Mapping[str, str]) -> None:
        self._home, self._folder = folder, folder / "jobs"
        self._versions = dict(versions)
        self._sums: dict[str, str] = {}
        self._models: dict[str, str] = {}

    def key(self, job: Job) -> str:
        """Return the hash of everything the answer to `job` depends on; AwayError where a recording cannot be read."""
        files = {
            role: [[Path(p).name, item] for p, item in zip(getattr(job, role), sums, strict=True)]
            for role, sums in self.sums(job).items()
        }
        parts = [job.verb, job.options, job.seed, job.case, self.model(job), files, self._versions]
        return sha256(json.dumps(parts, sort_keys=True))

    def sums(self, job: Job) -> dict[str, list[str]]:
        """Return the SHA-256 of every recording of `job`, as it was when this store first looked at it."""
        return {role: [self._sum(path) for path in getattr(job, role)] for role in ("recordings", "verify")}

    def model(self, job: Job) -> str | None:
        """Return the text of the model file, as it was when this store first looked at it."""
        if job.model is not None and job.model not in self._models:
            self._models[job.model] = _model_text(job.model)
        return None if job.model is None else self._models[job.model]

    def _sum(self, path: str) -> str:
        if path not in self._sums:
            with refused(AwayError, "cannot be read: {}", path, "check the file"):
                self._sums[path] = sha256_file(path)
        return self._sums[path]

    def path(self, job: Job, key: str) -> Path:
        """Return the path of the file that keeps the answer to `job`."""
        return self._folder / f"{job_file_name(job.name, key)}.json"

    def read(self, job: Job, key: str) -> dict[str, Any] | None:
        """Return the row of `job` if it is there, whole and unchanged, under the names that the plan has for it.

        CampaignError where something else is in its place, which could not be written to later.
        """
        path = self.path(job, key)
        with refused(CampaignError, "an answer cannot be kept here: {}", path, "remove it"):
            refuse_links(path, self._home)
        try:
            found = json.loads(read_input(path, LARGEST, remember=False, inside=self._home))
            row: dict[str, Any] = found["row"]
            if found["schema"] == SCHEMA and found["key"] == key and found["sha256"] == _checksum(key, row):
                return row | self.labels(job)
        except (OSError, *SPOILT):
            return None
        return None

    def labels(self, job: Job) -> dict[str, Any]:
        """Return the entries of a row about its job and not about the answer: the same content may be called something
        else.
        """
        sums = {role: [item[:16] for item in found] for role, found in self.sums(job).items()}
        return {"name": job.name, "fields": dict(job.fields), "sums": sums}

    def write(self, job: Job, key: str, row: Mapping[str, Any]) -> Path:
        """Keep the row of `job`, whole or not at all."""
        content = {"schema": SCHEMA, "key": key, "row": row, "sha256": _checksum(key, row)}
        return write_whole(self.path(job, key), json.dumps(content, indent=1) + "\n", at_once=True, inside=self._home)


def task_of(
    job: Job, *, ships: bool, report: bool, versions: Mapping[str, str], store: JobStore | None = None
) -> dict[str, Any]:
    """Return `job` as a worker gets it: plain data, with the recordings' bytes where it `ships` them, and with what
    `store` has seen of them: another content is another job.
    """
    sums = {} if store is None else store.sums(job)

    def sent(path: str, expected: str) -> dict[str, Any]:
        where = os.path.realpath(path)
        if not ships:
            return {"path": where, "data": None, "sha256": expected}
        try:
            data = Path(path).read_bytes()
        except OSError as error:
            return {"path": where, "data": "", "sha256": "", "away": f"{path}: {error.strerror}"}
        away = f"{path}: {CHANGED}" if expected and sha256(data) != expected else ""
        return {"path": where, "data": base64.b64encode(data).decode("ascii"), "sha256": "", "away": away}

    def every(role: str) -> list[dict[str, Any]]:
        paths = getattr(job, role)
        return [sent(path, item) for path, item in zip(paths, sums.get(role, [""] * len(paths)), strict=True)]

    model = store.model(job) if store is not None else None if job.model is None else _model_text(job.model)
    return {
        "verb": job.verb, "options": list(job.options), "seed": job.seed, "case": job.case,
        "recordings": every("recordings"), "verify": every("verify"), "model": model, "report": report,
        "versions": dict(versions),
    }  # fmt: skip


def job_file_name(name: str, key: str) -> str:
    """Return the name of a job's files, without suffix: letters, digits, dot, dash and underscore only."""
    kept = "".join(c if c.isascii() and (c.isalnum() or c in "._") else "-" for c in name)
    return f"{kept.strip('-.')[:80] or 'job'}-{key[:16]}"


def _checksum(key: str, row: Mapping[str, Any]) -> str:
    return sha256(key + json.dumps(row, sort_keys=True))


def _model_text(path: str) -> str:
    with refused(CampaignError, "the model file cannot be read", path, "see model in the plan", (OSError, ValueError)):
        return read_input(path, LARGEST, remember=False).decode("utf-8")
