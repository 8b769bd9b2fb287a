"""The whole search in a process of its own: it says how far it is, shows each step as it is found, and can be ended."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Callable
from concurrent.futures import Future
from pathlib import Path
from typing import TYPE_CHECKING, Any

from exoid.ground.engines.processes import alone
from exoid.ground.errors import ExoidError
from exoid.ground.plain import plain

if TYPE_CHECKING:
    from exoid.diagnosis.results import Diagnosis
    from exoid.diagnosis.session import Session


class BackgroundSearch:
    """A search that runs. `then(diagnosis, error)` is called once, from another thread, unless it is cancelled."""

    def __init__(self, session: Session, names: tuple[str, ...], then: Callable[[Diagnosis | None, str], None]) -> None:
        self.names = names
        self.fraction, self.text = 0.0, "starting"
        self.steps: list[dict[str, Any]] = []
        self.cancelled = False
        self._then = then
        self._read = 0
        self._folder = tempfile.TemporaryDirectory(prefix="exoid-search-", ignore_cleanup_errors=True)
        self._told = Path(self._folder.name) / "told.jsonl"
        self._engine = alone()
        self._future: Future[Any] = self._engine.executor.submit(_search, session.light(), names, str(self._told))
        self._future.add_done_callback(self._done)

    @property
    def running(self) -> bool:
        """True if it still runs."""
        return not self.cancelled and not self._future.done()

    def look(self) -> bool:
        """Take in what the process has told since last time; whether it told anything."""
        try:
            content = self._told.read_bytes()[self._read :]
        except OSError:
            return False
        whole, newline, _ = content.rpartition(b"\n")
        self._read += len(whole) + len(newline)
        for line in whole.splitlines():
            told = json.loads(line)
            if "steps" in told:
                self.steps = told["steps"]
            else:
                self.fraction, self.text = max(self.fraction, told["fraction"]), told["text"]
        return bool(whole)

    def cancel(self) -> None:
        """End it now."""
        self.cancelled = True
        self._engine.close(False)
        self._folder.cleanup()

    def _done(self, future: Future[Any]) -> None:
        if self.cancelled:
            return
        self.look()
        try:
            found, error = future.result(), ""
        except ExoidError as problem:
            found, error = None, str(problem)
        except BaseException as problem:  # noqa: BLE001 - its process may have been ended from outside
            found, error = None, f"the search ended before its time ({type(problem).__name__}); start it again"
        self._then(found, error)
        self._engine.executor.shutdown(wait=False)
        self._folder.cleanup()


def _search(session: Session, names: tuple[str, ...], path: str) -> Diagnosis:
    """Search, and write down what happens meanwhile as lines of JSON."""
    with open(path, "a", encoding="utf-8") as stream:

        def tell(**what: Any) -> None:
            stream.write(json.dumps(plain(what)) + "\n")
            stream.flush()

        return session.discover(
            names,
            progress=lambda fraction, text: tell(fraction=fraction, text=text),
            found=lambda steps: tell(steps=[step.to_json() for step in steps]),
        )
