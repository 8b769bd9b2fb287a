"""The search that starts by itself as soon as the recordings are fitted: it judges, and changes nothing until asked."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from exoid.apps.page.search import BackgroundSearch
    from exoid.diagnosis.evidence.fitted import FittedModel
    from exoid.diagnosis.results import Diagnosis
    from exoid.diagnosis.session import Session

Then = Callable[["Session", "Diagnosis | None", str], None]


class Judging:
    """The search for what the model as it was given lacks, of one session at a time; `touch` is called at its end."""

    def __init__(self, touch: Callable[[], object]) -> None:
        self.on = True
        self.search: BackgroundSearch | None = None
        self._session: Session | None = None
        self._found: Diagnosis | None = None
        self._told: dict[str, Any] | None = None
        self._after: FittedModel | None = None
        self._asked: Then | None = None
        self._touch = touch

    @property
    def running(self) -> bool:
        """True if it still searches."""
        return self.search is not None and self.search.running

    def wanted(self, session: Session, names: tuple[str, ...]) -> bool:
        """True if the model as it was given is to be judged, and was not yet."""
        return self.on and not names and session is not self._session

    def start(self, session: Session) -> None:
        """Search beside nothing, in a process of its own."""
        from exoid.apps.page.search import BackgroundSearch

        self.stop()
        self._session = session
        self.search = BackgroundSearch(session, (), lambda found, error: self._end(session, found, error))

    def answer(self, session: Session | None) -> Diagnosis | None:
        """Return the diagnosis of this session; None where it is not known (yet)."""
        return self._found if session is not None and session is self._session else None

    def told(self, session: Session | None) -> dict[str, Any] | None:
        """Return the same as JSON."""
        return None if self.answer(session) is None else self._told

    def after(self, session: Session) -> FittedModel | None:
        """Return the model that was found, on the recordings of this session; None where it is not known (yet)."""
        found = self.answer(session)
        if found is None:
            return None
        if self._after is None:
            self._after = found.fitted_on(session.prepared)
        return self._after

    def taken_by(self, session: Session, then: Then) -> BackgroundSearch | None:
        """Let `then` have what this search of the same session finds; None where it does not run."""
        if session is not self._session or not self.running:
            return None
        self._asked = then
        return self.search

    def switch(self, on: bool) -> None:
        """Start by itself from now on, or no more; a search that runs is ended."""
        self.on = on
        if not on and self.running:
            self.stop()

    def stop(self) -> None:
        """End a search, and forget what was found."""
        if self.search is not None and self.search.running:
            self.search.cancel()
        self.search, self._session, self._found, self._told = None, None, None, None
        self._after, self._asked = None, None

    def _end(self, session: Session, found: Diagnosis | None, error: str) -> None:
        if session is self._session:
            self._found, self._told = found, None if found is None else found.to_json()
            if self._asked is not None:
                self._asked(session, found, error)
        self._touch()
