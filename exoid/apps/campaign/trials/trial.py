"""One blind trial: draw and record the machine, let `discover` look for what is hidden, and note what it said."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from typing import Any

import numpy as np

from exoid.apps.campaign.trials.cases import SHOWN_SUSPECTS, Case, simulated, subject, visible
from exoid.apps.campaign.trials.people import UNMEASURED, as_measured, as_read
from exoid.apps.campaign.trials.shown import true_fit
from exoid.diagnosis.discovery import discover
from exoid.diagnosis.results import Diagnosis
from exoid.measurement.bench.blind import relative_size
from exoid.measurement.bench.hidden import Hidden
from exoid.measurement.bench.simulation import BenchRun
from exoid.measurement.recording import Recording
from exoid.symbolic.model import Model


def run_case(name: str) -> dict[str, Any]:
    """Return the outcome of the case called `name`, as plain data."""
    case = Case.named(name)
    rng = np.random.default_rng(case.number)
    model, leg = subject(case, rng)
    hidden, runs = simulated(case, model, leg, rng)
    recordings = as_read(runs)
    began = time.perf_counter()
    found = discover(model, recordings[:3], recordings[3:])
    seconds = time.perf_counter() - began
    best, covered = _true_structure(model, runs, as_measured(runs) if case.kind in UNMEASURED else recordings)
    first, last = found.steps[0].verify_rms, found.steps[-1].verify_rms
    assert first is not None and last is not None  # a recording is held out
    return {
        "case": case.name,
        "kind": case.kind,
        "hidden": {h.name: {k: float(v) for k, v in h.values.items()} for h in hidden},
        "size": [relative_size(h, leg, model) for h in hidden],
        "visible": [visible(h, model, leg) for h in hidden],
        "verdict": found.verdict,
        "says": found.sentence,
        "next": found.next_experiment,
        "accepted": [_accepted(a) for a in found.accepted],
        "unexplained": found.to_json()["unexplained"],
        "suspects": [
            [s.name, s.explained_share, s.p_value, s.caution]
            for k, s in enumerate(found.suspects)
            if k < SHOWN_SUSPECTS or s.name in case.variants
        ],
        "rms": {"base": first.tolist(), "found": last.tolist(), "true": best},
        "floor": found.noise_floor.tolist(),
        "covered_true": covered,
        "covered_found": _covered(found.fit.estimates, runs[0]) if _exactly(found, hidden) else None,
        "saturated": max(run.saturated for run in runs),
        "seconds": seconds,
    }


def _accepted(one: Any) -> dict[str, Any]:
    alike = sorted({*one.look_alikes, *one.never_separable})
    numbers = {name: e.value for name, e in one.parameters.items()}
    return {"name": one.name, "look_alikes": alike, "p": one.p_value, "numbers": numbers}


def _exactly(found: Diagnosis, hidden: tuple[Hidden, ...]) -> bool:
    return {a.name for a in found.accepted} == {h.name for h in hidden}


def _true_structure(
    model: Model, runs: tuple[BenchRun, ...], recordings: Sequence[Recording]
) -> tuple[list[float], list[bool]]:
    """Return the error on unseen motion when the structure is known, and which intervals then cover the truth."""
    known = true_fit(model, runs, recordings)
    rms = known.verify_rms
    assert rms is not None
    return rms.tolist(), _covered(known.fit.estimates, runs[0])


def _covered(estimates: Any, run: BenchRun) -> list[bool]:
    """Return for every number that has an interval whether it contains the truth."""
    truth = run.true.numbers()
    known = [e for e in estimates if e.name in truth and math.isfinite(e.low) and math.isfinite(e.high)]
    return [bool(e.low <= truth[e.name] <= e.high) for e in known]
