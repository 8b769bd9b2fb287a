"""A Dask cluster: one that runs already, by its address, or one of processes on this machine ("local")."""

from __future__ import annotations

import logging
from contextlib import ExitStack
from typing import Any

from exoid.ground.cores import cores
from exoid.ground.engines.engine import Engine, EngineError
from exoid.ground.extras import needing
from exoid.ground.import_path import workers_import_alike

PATIENCE = 30.0
"""Seconds to wait for a scheduler, and for its first worker."""


def dask(address: str, jobs: int = 0) -> Engine:
    """Return the Dask cluster at `address` ("tcp://host:8786", a scheduler file, or "local" with `jobs` processes).

    Raises EngineError where Dask is missing or nobody answers.
    """
    with needing("dask", "clusters of Dask", "distributed", error=EngineError):
        from distributed import Client
    here = address == "local"
    where: dict[str, Any] = {"scheduler_file" if address.endswith(".json") else "address": address}
    if here:
        where = {"n_workers": jobs or cores(), "threads_per_worker": 1, "dashboard_address": None, "silence_logs": 50}
    opened = ExitStack()
    try:
        if here:
            opened.enter_context(workers_import_alike())  # as long as it lives: lost workers are started anew
        client = opened.enter_context(Client(timeout=PATIENCE, **where))
        client.wait_for_workers(1, timeout=PATIENCE)
    except (OSError, ValueError, TimeoutError) as error:
        opened.close()
        what = f"no Dask cluster with a worker answers within {PATIENCE:g} s ({error})"
        remedy = "give the address that dask scheduler prints, for example tcp://host:8786, or local"
        raise EngineError(what, where=f"--dask {address}", remedy=remedy) from error
    for name in ("distributed.client", "distributed.core", "distributed.scheduler", "distributed.worker"):
        logging.getLogger(name).setLevel(logging.CRITICAL)  # what is lost is said by `lost`
    known = set(_workers(client))

    def lost() -> list[str]:
        gone = known - (now := set(_workers(client)))
        known.clear()
        known.update(now)
        return [f"Dask worker {name} is gone; what it was doing is done again" for name in sorted(gone)]

    return Engine(
        f"Dask {'on this machine' if here else f'at {address}'}, {len(known)} workers", client.get_executor(pure=False),
        lambda: sum(worker["nthreads"] for worker in _workers(client).values()), lost, lambda wait: opened.close(),
        ships=not here,
    )  # fmt: skip


def _workers(client: Any) -> dict[str, Any]:
    """Return the workers; EngineError where the scheduler has gone."""
    try:
        found: dict[str, Any] = client.scheduler_info(n_workers=-1)["workers"]
    except (KeyError, OSError, TimeoutError, RuntimeError, ValueError) as error:
        raise EngineError("the Dask scheduler does not answer any more") from error
    if client.status not in ("running", "connecting"):
        raise EngineError("the Dask scheduler does not answer any more")
    return found
