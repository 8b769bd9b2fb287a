"""This machine: as many workers as it has cores, each with a process of its own (`exoid.ground.engines.cell`)."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

from exoid.ground.cores import cores
from exoid.ground.engines.cell import close_cells
from exoid.ground.engines.engine import Engine


def local(jobs: int = 0) -> Engine:
    """Return an engine of `jobs` workers; 0 means one per core that this process may use."""
    count = jobs or cores()
    executor = ThreadPoolExecutor(count, thread_name_prefix="exoid-worker")

    def close(wait: bool) -> None:
        if not wait:
            close_cells()
        executor.shutdown(wait=wait, cancel_futures=True)
        close_cells()

    return Engine(f"{count} workers on this machine", executor, lambda: count, list, close)
