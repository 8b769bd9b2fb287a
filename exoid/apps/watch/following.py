"""Watch a machine: an iterator of samples in, an iterator of events out."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from exoid.apps.watch.events import Event
from exoid.apps.watch.outside import outside_names, stream_of
from exoid.apps.watch.settings import Settings
from exoid.apps.watch.watcher import Watcher
from exoid.diagnosis.extend import Waterfall, fit_in_turn
from exoid.ground.errors import ExoidError
from exoid.measurement.reading.frames import is_table
from exoid.measurement.reading.given import machine_of, model_of, one_recording
from exoid.measurement.recording import Recording
from exoid.optimisation.fitting.fit import Fit
from exoid.symbolic.effect import Effect
from exoid.symbolic.model import Model

PORTION = 500
"""Samples that are handed on at a time."""


def follow(
    model: Model | Fit | str | Path, samples: Recording | Iterable[Any], settings: Settings | None = None,
    *, extra: Sequence[Effect] = (),
) -> Iterator[Event]:  # fmt: skip
    """Yield what is to be reported of `samples` as they come; the last event is the summary.

    `samples` is a recording (its path, a table), an array (N, 1 + 2 J), or anything that yields rows (t, q1, ..., tau1,
    ...) or mappings with these names, one sample or an array of several at a time, in s, rad and N·m. Forces of the
    model stand behind the torques of a row; mappings have them, or the usual ones (f1, grf_z, contact), by name.
    ExoidError for anything else.
    """
    machine = machine_of(model_of(model))
    names: tuple[str, ...] | None = None
    if isinstance(samples, (str, Path, Mapping)) or (is_table(samples) and not isinstance(samples, np.ndarray)):
        samples = one_recording(samples, machine.joints)
    if isinstance(samples, Recording):
        samples, names = stream_of(machine, samples)
    watcher = Watcher(machine, settings or Settings(), tuple(extra))
    if names is not None:
        watcher.measures(names)
    waiting: list[np.ndarray] = []
    for sample in samples:
        if names is None:
            there = tuple(n for n in outside_names(machine.joints) if isinstance(sample, Mapping) and n in sample)
            names = there or machine.channels
            watcher.measures(names)
        waiting.append(_row(sample, watcher.outside.columns))
        if sum(map(len, waiting)) >= PORTION:
            yield from watcher.push(np.concatenate(waiting))
            waiting = []
    if waiting:
        yield from watcher.push(np.concatenate(waiting))
    yield from watcher.finish()


def _row(sample: Any, names: Sequence[str]) -> np.ndarray:
    try:
        values = [sample[name] for name in names] if isinstance(sample, Mapping) else sample
        return np.atleast_2d(np.asarray(values, dtype=float))
    except (KeyError, TypeError, ValueError) as error:
        raise ExoidError(
            f"a sample cannot be read: {error!r}", remedy=f"yield rows of numbers, or mappings with {', '.join(names)}"
        ) from None


def watch(model: Any, samples: Any, *further: Any, **options: Any) -> Waterfall | Iterator[Event]:
    """Watch a machine (`follow(model, samples, ...)`), or, for a sequence of models, watch the error fall.

    `watch([model, extended], recordings, verify)` fits one model after the other to the same samples; so does
    `watch(model, extended, recordings, verify)`.
    """
    if isinstance(samples, (Model, Fit)):
        together = 1 + sum(isinstance(item, (Model, Fit)) for item in further)
        models: list[Any] = [model, samples, *further[: together - 1]]
        return fit_in_turn(models, *further[together - 1 :], **options)
    if isinstance(model, (Model, Fit, str, Path)):
        return follow(model, samples, *further, **options)
    return fit_in_turn(model, samples, *further, **options)
