"""Compare, diagnose, add, and again, until nothing that helps on unseen motion is left (`search`), and say so."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Unpack

from exoid.diagnosis.beside_recordings import answer_beside_recordings
from exoid.diagnosis.machine_answer import Asking, answer_of_machine
from exoid.diagnosis.question import Question
from exoid.diagnosis.results import Diagnosis, Step
from exoid.diagnosis.settings import DiagnosisOptions, DiagnosisSettings, DiscoveryOptions, DiscoverySettings
from exoid.ground.progress import Progress, silent
from exoid.measurement.forces import pushed_model
from exoid.measurement.reading.given import Given, question_of
from exoid.measurement.recording import Recording
from exoid.optimisation.fitting.fit import Fit
from exoid.optimisation.preparation.prepare import Prepared
from exoid.symbolic.model import Model


def discover(
    model: Model | Fit | Given | None = None,
    recordings: Given | None = None,
    verify: Given = (),
    settings: DiscoverySettings | None = None,
    *,
    progress: Progress | None = None,
    **changes: Unpack[DiscoveryOptions],
) -> Diagnosis:
    """Find which effects `model` (or the model of a Fit) is missing and add them.

    `verify` are recordings that are never fitted and must improve. The user's own effects that the model declares
    (`[[custom_effects]]` of its file) are suspected as those of the catalogue are. Recordings are what
    `exoid.measurement.reading.given` takes: recordings, paths, tables, one or many; alone they are of the standard
    leg. Refuses those that are too short, too slow or do not determine the model.
    """
    asked, recordings, verify = question_of(model, recordings, verify)
    machine = pushed_model(asked.model if isinstance(asked, Fit) else asked, (*recordings, *verify))
    question = Question(machine, DiscoverySettings.chosen(settings, changes))
    return answer_of(question, recordings, verify, progress or silent)


def answer_of(
    question: Question,
    recordings: Sequence[Recording],
    verify: Sequence[Recording],
    tick: Progress = silent,
    prepared: Prepared | None = None,
    found: Callable[[Sequence[Step]], None] | None = None,
) -> Diagnosis:
    """Answer of `discover`; `prepared` are the recordings where they are prepared already, `found` is called
    with the steps so far whenever the search has another one.

    What belongs to recordings (a zero of their own, a load) is a rival explanation of what the best model leaves: where
    it predicts clearly better, the answer is that beside it.
    """
    asking = Asking(question, recordings, verify, tick, found, time.perf_counter())
    base = asking.fitted(prepared)
    answer = answer_of_machine(asking, base)
    rival = None if base.prepared.misread else answer_beside_recordings(asking, base, answer)
    return replace(rival or answer, seconds=time.perf_counter() - asking.began)


def diagnose(
    model: Model | Fit | Given | None = None,
    recordings: Given | None = None,
    verify: Given = (),
    settings: DiagnosisSettings | None = None,
    *,
    progress: Progress | None = None,
    **changes: Unpack[DiagnosisOptions],
) -> Diagnosis:
    """Find the effect that `model` misses most: `discover` that stops after one step."""
    asked = vars(DiagnosisSettings.chosen(settings, changes))
    return discover(model, recordings, verify, DiscoverySettings(**asked | {"most": 1}), progress=progress)
