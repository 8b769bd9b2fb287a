"""The workspace open in the page: files, the session made of them, the effects added so far, and the work that goes on.

One thread computes (`work.py`); what a click needs at once is answered from what is there. Every tab sees the same
workspace; `version` says when to look again.
"""

from __future__ import annotations

import contextlib
import shutil
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from exoid.apps.page import given as files
from exoid.apps.page.given import FIT, VERIFY, Given, numbers_meant
from exoid.apps.page.history import History
from exoid.apps.page.judging import Judging
from exoid.apps.page.keeping import Keeping
from exoid.ground.errors import EffectError, ExoidError, RecordingError
from exoid.ground.inside import is_inside
from exoid.ground.lock import private_folder
from exoid.measurement.signals.methods import BUTTERWORTH

if TYPE_CHECKING:
    from exoid.apps.page.search import BackgroundSearch
    from exoid.diagnosis.results import Diagnosis
    from exoid.diagnosis.session import Ranking, Session
    from exoid.measurement.reading.mapping import StatedMapping
    from exoid.symbolic.effect import Effect
    from exoid.symbolic.joints import Joint
    from exoid.symbolic.model import Model

Names = tuple[str, ...]
TOLD_EVERY = 0.3
"""Seconds between two messages to the page while work goes on."""

class BackgroundTask(Protocol):
    """Work of a panel that goes on while the page is used."""

    def cancel(self) -> None:
        """End it soon."""

    def to_json(self) -> dict[str, Any]:
        """The data that the page is told of it whenever it draws."""


class Workspace:
    """Everything that the page shows. Its methods may be called from any thread."""

    def __init__(
        self, remembered: Path, seed: int = 0, cutoff: float | None = None, derivative: str = BUTTERWORTH
    ) -> None:
        self.remembered, self.seed, self.cutoff, self.derivative = remembered, seed, cutoff, derivative
        self.mapped = 0
        self._own = private_folder("exoid-open-")
        self.place = self._own.folder
        self.given: list[Given] = []
        self.model_path: Path | None = None
        self.model_name = ""
        self.own: dict[str, Effect] = {}
        self.own_texts: dict[str, dict[str, Any]] = {}
        self.history = History()
        self.session: Session | None = None
        self.failed: dict[Names, ExoidError] = {}
        self.verdicts: dict[frozenset[str], dict[str, Any]] = {}
        """What searches said of the models they came to, as JSON; effects added by hand may come to the same models."""
        self.diagnoses: dict[frozenset[str], Diagnosis] = {}
        """The same in full; a session that is opened again has the JSON alone."""
        self.search: BackgroundSearch | None = None
        self.tasks: dict[str, BackgroundTask] = {}
        """What panels of apps have running."""
        self.search_message = ""
        self.problem: ExoidError | None = None
        self.saved: Path | None = None
        self.version = 0
        self.edits: list[str] = []
        """Which page made each of the steps so far, "" where none says so or a search did."""
        self.busy = ""
        self._model: Model | None = None
        self.stale = False
        self.portions: dict[Ranking, Iterator[str]] = {}
        self._ids = 0
        self.lock = threading.RLock()
        self.change = threading.Condition(self.lock)
        self._closed = False
        self.keeping = Keeping(self.change, lambda: self._closed, self.touch)
        self.judging = Judging(self.touch)
        self.left_out: dict[str, str] = {}
        """Files of folders that are no recordings, {name: kind}."""
        self.answers: list[StatedMapping] = []
        """What was told of columns on this page, the latest first: files to come may be alike."""

    # -- life ---------------------------------------------------------------------------------------------------

    def close(self) -> None:
        """End the work and a search, and clear away what was dropped and not saved."""
        self.end()
        self.keeping.write()
        self.keeping.release()
        if self.search is not None and self.search.running:
            self.search.cancel()
        self.judging.stop()
        self._stop_tasks()
        shutil.rmtree(self.place, ignore_errors=True)
        self._own.release()

    def end(self) -> None:
        """Wake up everybody who waits, for the last time. Safe in a handler of signals."""
        self._closed = True
        threading.Thread(target=self.touch).start()

    def wait(self, version: int, seconds: float) -> int:
        """Wait until there is something newer than `version`, at most so long; return the present version."""
        with self.change:
            self.change.wait_for(lambda: self.version != version or self._closed, timeout=seconds)
            return self.version

    @property
    def closed(self) -> bool:
        """True if it is closed."""
        return self._closed

    def touch(self, changed: bool = False) -> None:
        """Let everybody who waits know of a new version; `changed` where there is something new to keep."""
        with self.change:
            if changed:
                self.keeping.changed()
            self.version += 1
            self.change.notify_all()

    # -- files --------------------------------------------------------------------------------------------------

    def add_file(self, path: Path, name: str, role: str = FIT, **more: Any) -> Given:
        """Take in a file, to be read as soon as there is time."""
        with self.change:
            self._ids += 1
            more = {"told": files.told_of_all(self.given), **more}
            entry = Given(self._ids, self._free(files.shown_name(name)), path, _role(role), **more)
            self.given.append(entry)
            self._begin_anew()
        self.touch(changed=True)
        return entry

    def leave_out(self, kind: str, *names: str) -> None:
        """Note files of a folder that are no recordings."""
        with self.change:
            self.left_out |= dict.fromkeys(names, kind)
        self.touch()

    def hold_out_last(self, ids: Sequence[int]) -> None:
        """Hold out the last of these files that is open, of three or more."""
        there = [entry.id for entry in self.given if entry.id in ids]
        if len(there) > 2:
            self.use_as(there[-1], VERIFY)

    def leave_others_out(self) -> None:
        """Leave out what stood in a folder and turned out to be no recording, once all is read and some is left.

        Where the only file held out goes, the last of three or more is held out instead, as when they were dropped.
        """
        others = [entry for entry in self.given if entry.is_other]
        rest = [item for item in self.given if not item.is_other]
        if not others or not all(entry.read for entry in self.given) or not any(entry.recordings for entry in rest):
            return
        self.given = rest
        self.left_out |= {other.name: other.error.kind for other in others if isinstance(other.error, RecordingError)}
        held = any(element.role == VERIFY for element in others) and not any(entry.role == VERIFY for entry in rest)
        if held and len(rest) > 2:
            rest[-1] = replace(rest[-1], role=VERIFY)
        self._delete_dropped(others)

    def drop_place(self, name: str) -> Path:
        """Return the path to which a dropped file of that name may be written."""
        with self.lock:
            self._ids += 1
            folder = self.place / str(self._ids)
        folder.mkdir()
        return folder / files.safe_name(name)

    def session_place(self, drop: int, name: str) -> Path:
        """Return the path to which a file of a dropped session may be written; `name` is its path in the session's
        folder.
        """
        folder, _, last = name.rpartition("/")
        target = self.place / f"session-{drop}" / ("recordings" if folder else "") / files.safe_name(last)
        target.parent.mkdir(parents=True, exist_ok=True)
        return target

    def find(self, id: int) -> Given:
        """Return the file with that number; RecordingError where there is none."""
        for entry in self.given:
            if entry.id == id:
                return entry
        raise RecordingError("this recording is not open any more", remedy="reload the page")

    def use_as(self, id: int, role: str) -> None:
        """Fit a file, or hold it out."""
        with self.change:
            old = self.find(id)
            self.given[self.given.index(old)] = replace(old, role=_role(role))
            self._begin_anew()
        self.touch(changed=True)

    def remove_file(self, id: int) -> None:
        """Close a file; one that was dropped here is deleted."""
        with self.change:
            old = self.find(id)
            self.given.remove(old)
            self._begin_anew()
            self._delete_dropped([old])
        self.touch(changed=True)

    def map_file(self, id: int, told: StatedMapping) -> Given:
        """Read a file as told and keep that for the next one like it; RecordingError where it does not fit."""
        from exoid.measurement.reading.read import open_table

        old = self.find(id)
        kept = {name: getattr(old.told, name) for name in ("join", "payloads", "only")}
        said = replace(told, **kept)
        entry = files.read_given(replace(old, told=said), self.remembered, self.joints)
        if entry.error is not None:
            raise entry.error
        files.remember_mapping(self.remembered, open_table(entry.path), told)
        with self.change:
            self.mapped += 1
            self.answers.insert(0, told)
            self.given[self.given.index(self.find(id))] = entry
            self._begin_anew()
            self._read_again()
        self.touch(changed=True)
        return entry

    def use_mapping(self, path: Path) -> None:
        """Keep what a file of `exoid map` says of columns; RecordingError where it is none."""
        files.keep_mappings(self.remembered, path)
        self._read_again()
        self.touch(changed=True)

    def _read_again(self) -> None:
        """Read the files again that wait for an answer."""
        self.given = [entry if entry.error is None else replace(entry, read=False, error=None) for entry in self.given]

    def clear(self) -> None:
        """Close everything: files, model, effects and what was done."""
        with self.change:
            before, self.given = self.given, []
            self.left_out = {}
            self.own, self.own_texts, self.history = {}, {}, History()
            self._model, self.model_path, self.model_name = None, None, ""
            self._begin_anew()
            self._delete_dropped(before)
        self.touch()

    def _delete_dropped(self, closed: Sequence[Given]) -> None:
        """Delete the files of recordings that were dropped here and are not open any more."""
        still = {path for entry in self.given for path in entry.files}
        for path in {path for item in closed for path in item.files} - still:
            if is_inside(path, self.place):
                with contextlib.suppress(OSError):  # Windows does not delete what is being read
                    path.unlink()
                    path.parent.rmdir()

    def _begin_anew(self) -> None:
        """The recordings are others: what was concluded from them does not hold any more."""
        self.stale = True
        self.verdicts, self.diagnoses = {}, {}
        self.judging.stop()
        self._stop_tasks()

    def _stop_tasks(self) -> None:
        for task in self.tasks.values():
            task.cancel()
        self.tasks = {}

    def _free(self, name: str) -> str:
        """Return a name that no other file has."""
        taken = {entry.name for entry in self.given}
        stem, dot, suffix = name.rpartition(".")
        count, free = 1, name
        while free in taken:
            count += 1
            free = f"{stem} ({count}){dot}{suffix}" if dot else f"{name} ({count})"
        return free

    # -- model and effects --------------------------------------------------------------------------------------

    @property
    def model(self) -> Model:
        """The model that everything starts from."""
        from exoid.symbolic.model import Model

        if self._model is None:
            self._model = Model.standard()
        return self._model

    @property
    def joints(self) -> Sequence[Joint] | None:
        """The joints that recordings must have; None where no model says so."""
        return None if self.model_path is None else self.model.joints

    def use_model(self, path: Path, name: str) -> None:
        """Start from the model in a file; its own errors where it is none."""
        from exoid.symbolic.model import read_model

        model = read_model(path)
        with self.change:
            self._model, self.model_path, self.model_name = model, path, files.shown_name(name)
            self.given = [replace(entry, read=False, recordings=(), error=None) for entry in self.given]
            self._begin_anew()
        self.touch(changed=True)

    def add_effect(self, entry: dict[str, Any]) -> Effect:
        """Let an effect of the user's own join the suspects; ExpressionError with a caret where its torque is wrong."""
        from exoid.ground.toml_reader import Table
        from exoid.symbolic.custom_effect import read_custom_effect

        entry = numbers_meant(entry)
        effect = read_custom_effect(Table(entry, (), "", ""), self.model.joints)
        with self.change:
            used = [layer.name for layer in self.history.now.layers if layer.name.partition(":")[0] == effect.id]
            if used:
                raise EffectError(f"{used[0]} is among the layers", where=effect.id, remedy="remove it first")
            self.own[effect.id], self.own_texts[effect.id] = effect, entry
            if self.session is not None:
                self.session = self.session.knowing(effect)
                self.portions.clear()
        self.touch(changed=True)
        return effect

    # -- layers -------------------------------------------------------------------------------------------------

    @property
    def names(self) -> Names:
        """Full names of the effects that are switched on."""
        return self.history.now.names

    @property
    def verdict(self) -> dict[str, Any] | None:
        """The verdict of a search on the present model, in the schema of `exoid discover`; None where none ended there.
        """
        return self.verdicts.get(frozenset(self.names))

    def ranking(self) -> Ranking | None:
        """Return the suspects beside the present effects; None before there is a fit."""
        with self.lock:
            session, names = self.session, self.names
            return None if session is None or session.known(names) is None else session.ranking(names)

    def add(self, name: str) -> None:
        """Add an effect. What the ranking knows of it is shown until it is fitted."""
        with self.change:
            session = self.opened()
            session.with_effects([*self.names, name])  # refuses what does not exist
            before, ranking = self.names, self.ranking()
            self.history = self.history.add(name)
            if ranking is not None and self.names == (*before, name):
                session.starts_at(self.names, ranking)
        self.touch(changed=True)

    def change_history(self, change: Callable[[History], History]) -> None:
        """Replace the history by what `change` makes of it."""
        with self.change:
            self.history = change(self.history)
        self.touch(changed=True)

    def opened(self) -> Session:
        """Return the session; RecordingError where nothing is open."""
        if self.session is None:
            raise RecordingError("nothing is open yet", remedy="give at least one recording to fit")
        return self.session

    # -- search -------------------------------------------------------------------------------------------------

    def discover(self) -> None:
        """Start the whole search beside the present effects, in a process of its own."""
        from exoid.apps.page.search import BackgroundSearch

        with self.change:
            session, names = self.opened(), self.names
            if self.search is not None and self.search.running:
                return
            self.search_message = ""
            known = self.judging.answer(session) if not names else None
            if known is not None:  # it was judged already
                self._found(session, names, known, "")
                return
            running = None if names else self.judging.taken_by(session, lambda s, *end: self._found(s, names, *end))
            session.prepared  # noqa: B018 - what is prepared need not be prepared again over there
            self.search = running or BackgroundSearch(session, names, lambda *end: self._found(session, names, *end))
        self.touch()
        threading.Thread(target=self._follow, args=(self.search,), daemon=True).start()

    def start(self, name: str, task: BackgroundTask) -> None:
        """Keep what a panel has started; what ran under this name before is cancelled."""
        with self.change:
            if name in self.tasks:
                self.tasks[name].cancel()
            self.tasks[name] = task
        self.touch()

    def cancel(self) -> None:
        """End a search; what was there before it stays."""
        with self.change:
            if self.search is not None and self.search.running:
                self.search.cancel()
                self.search_message = "cancelled; nothing was changed"
        self.touch()

    def _follow(self, search: BackgroundSearch) -> None:
        while search.running and not self._closed:
            if search.look():
                self.touch()
            time.sleep(TOLD_EVERY)
        self.touch()

    def _found(self, session: Session, names: Names, found: Diagnosis | None, error: str) -> None:
        with self.change:
            if found is None or session is not self.session:
                self.search_message = error or "the recordings were changed meanwhile; search again"
            else:
                accepted = [a.name for a in found.accepted]
                if self.names == names:
                    self.history = self.history.add(*accepted)
                    self.edits.append("")
                else:
                    what = ", ".join(accepted) or "nothing"
                    self.search_message = f"found {what} beside the effects as they were when it began"
                model = frozenset((*names, *accepted))
                self.diagnoses[model], self.verdicts[model] = found, found.to_json()
        self.touch(changed=True)


def _role(role: str) -> str:
    if role not in (FIT, VERIFY):
        raise RecordingError(f"a recording cannot be used as {role[:20]!r}", remedy=f"use {FIT} or {VERIFY}")
    return role


def spans_of(value: Any) -> Sequence[tuple[int, float, float]]:
    """Return (recording, from s, to s) of every stretch in a message of the page; RecordingError where it is none."""
    try:
        return [(int(k), float(low), float(high)) for k, low, high in value]
    except (TypeError, ValueError) as error:
        raise RecordingError("this is no selection", remedy="drag over a plot") from error
