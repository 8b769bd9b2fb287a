"""The work of a workspace, in one thread and in portions: reading, filtering, fitting, ranking.

After each portion is looked whether something more urgent has come.
"""

from __future__ import annotations

import threading
import time
import traceback
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from exoid.apps.page import answers
from exoid.apps.page.given import FIT, VERIFY, Given, read_as_others, read_given
from exoid.apps.page.workspace import TOLD_EVERY, Names, Workspace
from exoid.ground.errors import ExoidError, internal

if TYPE_CHECKING:
    from exoid.diagnosis.session import Ranking, Session


def start_work(workspace: Workspace) -> None:
    """Let the threads of `workspace` begin: one that computes, one that keeps what was done in its folder."""
    threading.Thread(target=_work, args=(workspace,), name="workspace", daemon=True).start()
    threading.Thread(target=workspace.keeping.run, name="keeper", daemon=True).start()


def _work(space: Workspace) -> None:
    """Do what there is to do, the most urgent first, until it is closed."""
    told = 0.0
    while not space.closed:
        with space.change:
            task = _next(space)
            if task is None:
                if space.busy:
                    space.busy = ""
                    space.touch()
                space.change.wait(timeout=5.0)
                continue
        before = space.busy
        try:
            task()
        except ExoidError as error:
            space.problem = error
        except Exception as error:  # noqa: BLE001 - the page must go on
            traceback.print_exc()
            space.problem = internal(error)
        if space.busy != before or time.monotonic() - told > TOLD_EVERY:
            told = time.monotonic()
            space.touch()


def _next(space: Workspace) -> Callable[[], object] | None:
    """Return the work to be done first; None where there is nothing to do."""
    unread = [entry for entry in space.given if not entry.read]
    if unread:
        space.busy = f"reading {unread[0].name}"
        return lambda: _read(space, unread[0])
    if space.stale:
        space.busy = "filtering the recordings" if any(item.role == FIT for item in space.given) else ""
        return lambda: _rebuild(space)
    session = space.session
    if session is None or space.problem is not None:
        return None
    for names in (space.names, *(step.names for step in space.history.steps)):
        if session.known(names) is None and names not in space.failed:
            space.busy = "fitting" if names == () else f"fitting with {', '.join(names)}"
            return lambda names=names: _fit(space, session, names)  # type: ignore[misc]
    if space.names in space.failed:
        return None
    if space.judging.wanted(session, space.names):
        return lambda: space.judging.start(session)
    ranking = session.ranking(space.names)
    if not ranking.finished:
        space.busy = "ranking suspects" if ranking.weighed < 1.0 else "asking placebos"
        return lambda: _rank(space, ranking)
    return space.keeping.reporting((space.names, space.verdict is None))


def _read(space: Workspace, one: Given) -> None:
    mapped = space.mapped
    found = read_given(one, space.remembered, space.joints)
    if found.error is not None:
        found = read_as_others(found, space.answers, space.joints)
    with space.lock:
        if found.error is not None and space.mapped != mapped:
            return  # somebody has said meanwhile which column is what: it is read again
        if one in space.given:
            space.given[space.given.index(one)] = found
            space.leave_others_out()
            space.stale = True


def _rebuild(space: Workspace) -> None:
    """Make a new session of the files as they are now; effects and history stay."""
    from exoid.diagnosis.session import Session

    with space.lock:
        space.stale = False
        fit, verify = _recordings(space, FIT), _recordings(space, VERIFY)
        model, own = space.model, tuple(space.own.values())
        space.problem, space.failed = None, {}
        if space.search is not None and space.search.running:
            space.search.cancel()
            space.search_message = "the recordings were changed; search again"
        space.session = None
        space.portions.clear()
    if not fit:
        return
    session = Session(model, fit, verify, extra=own, seed=space.seed, cutoff=space.cutoff, derivative=space.derivative)
    session.prepared  # noqa: B018 - outside the lock: the page goes on meanwhile
    session.fitted()
    with space.lock:
        if not space.stale:
            space.session = session


def _recordings(space: Workspace, role: str) -> list[Any]:
    """Return the recordings of a role, each under a name of its own."""
    return [recording for entry in space.given if entry.role == role for recording in entry.recordings]


def _fit(space: Workspace, session: Session, names: Names) -> None:
    try:
        found = answers.found(space, names)
        if found is not None:
            session.take(names, found.fitted_on(session.prepared))  # the numbers that its sentence named
        session.fitted(names)
    except ExoidError as error:
        space.failed[names] = error
    space.touch(changed=True)


def _rank(space: Workspace, ranking: Ranking) -> None:
    work = space.portions.setdefault(ranking, ranking.work())
    began = time.monotonic()
    while next(work, None) is not None and time.monotonic() - began < TOLD_EVERY:
        pass
