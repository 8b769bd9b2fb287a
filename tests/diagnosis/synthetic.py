"""Prepared recordings made of sums of sines and a known torque, and a search over a few candidates."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from exoid.diagnosis.evidence.library import Library, build_library
from exoid.diagnosis.rules import RULES, Rules
from exoid.diagnosis.search.context import SearchContext
from exoid.diagnosis.search.state import State
from exoid.measurement.signals.conditioning import low_pass_at
from exoid.optimisation.preparation.cutoff import CutoffChoice
from exoid.optimisation.preparation.filtering import PreparedRecording
from exoid.optimisation.preparation.prepare import Prepared
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Motion

RATE, SECONDS, CUTOFF = 40.0, 12.0, 5.0
BASE = np.array([2.5, 0.9, 0.35, -0.6, 0.8, 0.5, 0.6, 0.4])
"""Parameters of the eight-parameter model, N·m and SI."""
Hidden = Mapping[str, tuple[Sequence[float], Sequence[float]]]
"""Effect name to its coefficients and shape values."""


def motion(seed: int) -> Motion:
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, SECONDS, 1.0 / RATE)
    w = 2.0 * np.pi * np.array([0.1, 0.2, 0.3, 0.5, 0.7])
    q, dq, ddq = (np.zeros((t.size, 2)) for _ in range(3))
    for joint, middle in enumerate((0.5, -0.9)):
        a, b = rng.normal(scale=0.25 / np.sqrt(w), size=(2, w.size))
        q[:, joint] = middle + np.sin(np.outer(t, w)) @ a + np.cos(np.outer(t, w)) @ b
        dq[:, joint] = np.cos(np.outer(t, w)) @ (a * w) - np.sin(np.outer(t, w)) @ (b * w)
        ddq[:, joint] = -np.sin(np.outer(t, w)) @ (a * w**2) - np.cos(np.outer(t, w)) @ (b * w**2)
    return Motion(t, q, dq, ddq, np.tanh(dq / 1e-3))


def recording(name: str, seed: int, hidden: Hidden, noise: float = 0.1, scale: float = 1.0) -> PreparedRecording:
    """Return a recording of the base model with `hidden` effects, their torque times `scale`."""
    path = motion(seed)
    model, linear, shape = Model.standard(), list(BASE), []
    still = model.torque(path, BASE)
    for effect, (coefficients, shapes) in hidden.items():
        identifier, _, joint = effect.partition(":")
        model = model.with_effect(identifier, joint or None)
        linear += coefficients
        shape += shapes
    extra = model.torque(path, np.array(linear), np.array(shape)) - still
    tau = still + scale * extra + noise * np.random.default_rng(1000 + seed).standard_normal(path.q.shape)
    kept = np.arange(20, path.t.size - 20)
    stuck = np.zeros(path.q.shape, bool)
    return PreparedRecording(
        name=name,
        motion=path,
        torque=low_pass_at(np.ascontiguousarray(tau.T), CUTOFF, RATE, kept),
        used=np.ones((2, kept.size), bool),
        kept=kept,
        cutoff=CUTOFF,
        rate=RATE,
        outliers=np.zeros(2),
        wide_tau=tau,
        angle_noise=np.full(2, 1e-14),
        band=2.0 * CUTOFF,
        stuck=stuck,
        hidden=stuck,
        standing=np.zeros(2, bool),
        driven=np.ones(2, bool),
        full_rate=RATE,
        reach=np.ones(2),
    )


def search(
    hidden: Hidden,
    candidates: Sequence[str],
    *,
    scales: Sequence[float] = (1.0, 1.0, 1.0, 1.0),
    verify: int = 1,
    noise: float = 0.1,
    rules: Rules = RULES,
) -> SearchContext:
    """Return a search over `candidates` on recordings with `hidden`, one for each of `scales`, the last to verify."""
    made = [recording(f"run_{k}", k, hidden, noise, scale) for k, scale in enumerate(scales)]
    count = len(made) - verify
    floor = np.full(2, noise * np.sqrt(2.0 * CUTOFF / RATE))
    prepared = Prepared(
        tuple(made[:count]),
        tuple(made[count:]),
        CutoffChoice(CUTOFF, "fixed"),
        floor,
        filter_error=np.zeros(2),
        acceleration_noise=0.0,
    )
    library = build_library(Model.standard(), prepared.all)
    few = Library(tuple(library.find(name) for name in candidates))
    return SearchContext(prepared, few, seed=0, rules=replace(rules, placebos=199, least_periods=5.0))


def state_with(context: SearchContext, *names: str) -> State:
    """Return the state that has accepted `names` one after the other, whatever speaks against them."""
    extensions = [context.fit(Model.standard())]
    for name in names:
        evidence = context.evidence(extensions[-1], draws=0)
        score = context.weighed(extensions[-1], evidence, context.library.find(name))
        extensions.append(context.with_term(extensions[-1], score))
    return State(tuple(extensions))
