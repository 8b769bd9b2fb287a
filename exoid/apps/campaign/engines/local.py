"""This machine: as many workers as it has cores, each with a process of its own (`cell.py`)."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

from exoid.apps.campaign.engines.cell import Cell, cell_of_thread
from exoid.ground.cores import cores
from exoid.ground.engines.engine import Engine


def local(jobs: int = 0) -> Engine:
    """Return an engine of `jobs` workers; 0 means one per core that this process may use."""
    count = jobs or cores()
    cells: list[Cell] = []
    executor = ThreadPoolExecutor(count, "exoid-worker", initializer=lambda: cells.append(cell_of_thread()))

    def close(wait: bool) -> None:
        executor.shutdown(wait=wait, cancel_futures=True)
        for cell in cells:
            cell.close()

    return Engine(f"{count} workers on this machine", executor, lambda: count, list, close)
