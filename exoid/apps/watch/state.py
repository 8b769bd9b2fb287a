"""The state that a watch has learnt, on disk: it survives a restart, and damage meanwhile does not become usual.

A file holds the windows that said what is usual, from which model and thresholds come out again as they were, the
state of the estimator, and what had changed. It is an NPZ archive of plain numbers and one text of JSON.
"""

from __future__ import annotations

import io
import json
import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, fields, replace
from typing import Any

import numpy as np

from exoid.apps.watch.acting import Applied
from exoid.apps.watch.alarm import SPANS
from exoid.apps.watch.course import Onset
from exoid.apps.watch.front import Filters, Samples
from exoid.apps.watch.memory import TOGETHER
from exoid.apps.watch.numbers import FollowedNumbers
from exoid.apps.watch.outside import Outside
from exoid.apps.watch.recursive.estimator import Estimator
from exoid.apps.watch.settings import Settings
from exoid.apps.watch.usual import Usual, learned
from exoid.apps.watch.window import Window, joined_windows, window
from exoid.diagnosis.against.questions import Acting
from exoid.diagnosis.against.result import ChangeFound
from exoid.ground.errors import ExoidError
from exoid.ground.plain import SPOILT
from exoid.symbolic.codegen.fingerprint import model_key
from exoid.symbolic.effect import Effect
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Float
from exoid.symbolic.quantity import Estimate

SCHEMA = "exoid.watch.state/1"
SAME_RATE = 1e-3
"""How far the rate of a stream may be from that of the one before, relative to it."""
EVER = Onset.at(-1e300)
"""When what an earlier watch saw began: before this one."""
OF_ESTIMATOR = ("root", "right", "linear", "variance", "credit", "score", "meat", "blocks", "scale", "feigned")
PARTS = ("t", "q", "dq", "ddq", "tau", "good")
"""Of a window: what its samples are made of, forces apart."""
OF_CHANGE = ("name", "kind", "share", "p_value")
ESTIMATES = ("before", "after", "change")
LARGEST = 200_000_000
"""Bytes of a file; those of a leg have some hundred thousand."""


class StateError(ExoidError):
    """A state that cannot be read, or is of another machine."""


@dataclass(frozen=True, eq=False)
class WatchState:
    """`arrays` {name: numbers} and `about`, which is JSON."""

    arrays: Mapping[str, Float]
    about: Mapping[str, Any]

    @classmethod
    def of(
        cls, model: Model, settings: Settings, first: Sequence[Window], changes: Sequence[Applied],
        numbers: FollowedNumbers,
    ) -> WatchState:  # fmt: skip
        """Return the state of a `model`: the windows that said what is usual, what has changed, the numbers."""
        estimator = numbers.estimator
        arrays = {f"estimator.{name}": np.array(getattr(estimator, name), dtype=float) for name in OF_ESTIMATOR}
        for k, item in enumerate(first):
            m = item.motion
            parts = {"t": m.t, "q": m.q, "dq": m.dq, "ddq": m.ddq, "tau": item.wide_tau, "good": item.weights}
            parts |= {} if m.force is None else {"force": m.force}
            arrays |= {f"window{k}.{name}": value for name, value in parts.items()}
            arrays[f"window{k}.torque"] = item.torque
        about = {
            "schema": SCHEMA, "model": model_key(model), "name": model.name, "block": settings.block,
            "cutoff": settings.cutoff, "rate": first[0].full_rate, "lead": [int(entry.kept[0]) for entry in first],
            "numbers": list(estimator.names), "units": list(estimator.units), "pace": list(map(float, estimator.pace)),
            "inside": estimator.inside, "followed": [_plain(element) for element in numbers.followed],
            "changes": [_told(found) for change in changes for found in change.found],
        }  # fmt: skip
        return cls(arrays, about)

    def to_bytes(self) -> bytes:
        """Return the file."""
        stream = io.BytesIO()
        text = np.frombuffer(json.dumps(self.about).encode(), dtype=np.uint8)
        whole: dict[str, Any] = {"about": text, **self.arrays}
        np.savez_compressed(stream, **whole)
        return stream.getvalue()

    @classmethod
    def from_bytes(cls, content: bytes, where: str = "") -> WatchState:
        """Read a file; StateError where it is none."""
        try:
            with np.load(io.BytesIO(content), allow_pickle=False) as found:
                arrays = {name: found[name] for name in found.files}
            about = json.loads(arrays.pop("about").tobytes())
            right = about["schema"] == SCHEMA and all(x.dtype.kind == "f" for x in arrays.values())
        except (*SPOILT, OSError, EOFError, zipfile.BadZipFile) as error:
            raise _damaged(where) from error
        if not right:
            raise _damaged(where)
        return cls(arrays, about)

    def check(self, model: Model, settings: Settings, one: Window) -> None:
        """Refuse another model, other settings, or a stream `one` of which is sampled at another rate."""
        about = self.about
        given = {"block": settings.block, "cutoff": settings.cutoff}
        other = [f"{name} {about[name]:g}" for name, value in given.items() if about[name] != value]
        if about["model"] != model_key(model):
            other = [f"the model {about['name']!r}, which is not this one"]
        elif abs(one.full_rate - about["rate"]) > SAME_RATE * about["rate"]:
            other = [f"a stream of {about['rate']:.5g} Hz, and this one has {one.full_rate:.5g} Hz"]
        if other:
            raise StateError(
                f"what was learnt is of {', '.join(other)}", remedy="name another --state file, or remove that one"
            )

    def taken_over(
        self, outside: Outside, settings: Settings, extra: Sequence[Effect], rng: np.random.Generator, one: Window
    ) -> tuple[tuple[Window, ...], Usual, list[Applied], FollowedNumbers]:
        """Return the knowledge taken over at the window `one`, the first of a stream: the windows that said what is
        usual, that, what has changed, and the numbers. StateError where the state is of something else.
        """
        self.check(outside.model, settings, one)
        first = self.windows(float(one.t[0]) - settings.block)
        usual = learned(outside.learnt_from(first), first, joined_windows(first, TOGETHER), settings, extra, rng)
        fresh = FollowedNumbers.started(usual.now, usual.scale, one.kept_rate, settings.pace)
        return first, usual, self.changes(usual), self.numbers(fresh.estimator, usual)

    def windows(self, end: float) -> tuple[Window, ...]:
        """Return the windows that said what is usual, as if they had come until `end` s of this stream."""
        filters, found = Filters(self.about["rate"], self.about["cutoff"]), []
        later = end - max(float(self.arrays[f"window{k}.t"][-1]) for k in range(len(self.about["lead"])))
        for k, lead in enumerate(self.about["lead"]):
            t, *parts = (self.arrays[f"window{k}.{name}"] for name in PARTS)
            parts += [self.arrays.get(f"window{k}.force", np.zeros((len(t), 0))), np.zeros_like(parts[0])]
            learnt = window(f"learnt {k}", Samples(t + later, *parts), lead, filters)
            found.append(replace(learnt, torque=self.arrays[f"window{k}.torque"]))
        return tuple(found)

    def changes(self, usual: Usual) -> list[Applied]:
        """Return the changes so far, as they act on what comes."""
        found = tuple(_change(change, usual) for change in self.about["changes"])
        return [Applied(found, EVER, SPANS[-1], True)] if found else []

    def numbers(self, fresh: Estimator, usual: Usual) -> FollowedNumbers:
        """Return the numbers as they were followed; `fresh` is an estimator that knows nothing yet."""
        about = self.about
        kept = {name: self.arrays.get(f"estimator.{name}") for name in OF_ESTIMATOR}
        values = {name: item.copy() for name, item in kept.items() if item is not None}  # earlier files have fewer
        made = Estimator(
            tuple(about["numbers"]), tuple(about["units"]), np.array(about["pace"]), fresh.block, fresh.follow,
            fresh.unit, values["root"], values["right"], values["linear"], values["variance"],
        )  # fmt: skip
        for name in OF_ESTIMATOR[4:]:
            setattr(made, name, values.get(name, getattr(made, name)))
        made.scale, made.inside = values["scale"].tolist(), about["inside"]
        return FollowedNumbers(made, usual.now, tuple(_acting(entry, usual) for entry in about["followed"]))


def _damaged(where: str) -> StateError:
    return StateError("this is no state of a watch, or it is damaged", where=where, remedy="remove it, and learn anew")


def _plain(one: Acting) -> dict[str, Any]:
    return {"name": one.asked.name, "nodes": one.nodes.tolist(), "size": one.size.tolist()}


def _acting(one: Mapping[str, Any], usual: Usual) -> Acting:
    asked = usual.asked.get(one["name"])
    if asked is None:
        raise StateError(
            f"what was learnt speaks of {one['name']!r}, which this version does not know", remedy="learn anew"
        )
    nodes, size = np.array(one["nodes"], dtype=float).reshape(1, -1), np.array(one["size"], dtype=float)
    if one.get("place") is not None:  # earlier files have a load's place apart, and how much there is of its slope
        nodes, size = np.array([[one["place"]]]), size[:1]
    return Acting(asked, nodes, size)


def _told(one: ChangeFound) -> dict[str, Any]:
    told: dict[str, Any] = {name: getattr(one, name) for name in OF_CHANGE}
    told |= {name: [asdict(e) for e in getattr(one, name)] for name in ESTIMATES}
    told |= {"shape": dict(one.shape), "look_alikes": list(one.look_alikes)}
    return told | {"acting": None if one.acting is None else _plain(one.acting)}


def _change(one: Mapping[str, Any], usual: Usual) -> ChangeFound:
    known = {entry.name for entry in fields(Estimate)}
    before, after, change = (
        tuple(Estimate(**{k: v for k, v in e.items() if k in known}) for e in one[name]) for name in ESTIMATES
    )
    acting = None if one["acting"] is None else _acting(one["acting"], usual)
    return ChangeFound(
        one["name"], one["kind"], before, after, change, one["shape"], tuple(one["look_alikes"]), one["share"],
        one["p_value"], acting=acting,
    )  # fmt: skip
