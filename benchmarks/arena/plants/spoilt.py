"""Recordings of our bench that are mislabelled or spoilt, with an effect hidden or nothing.

KIND/WHAT/SEED: what is wrong with them, of SPOILT, and what is hidden, or nothing

Where all recordings are wrong no effect can be named, and the answer is to look at the channels; where one of them is,
the others still say what is hidden.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from benchmarks.arena.plants import bench
from benchmarks.arena.task import Run, Sealed, number_of
from exoid.measurement.recording import Recording
from exoid.measurement.signals.conditioning import low_pass
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Float

SEED = 7300
"""First seed: other machines than those of the bench."""
HIDDEN = ("nothing", "load_friction:knee", "stribeck:hip", "torque_ripple:knee", "end_stop:hip")
"""What is hidden, with each kind: nothing, and two of the others by turns; nothing where somebody pushes, since either
may be told.
"""
CHANNELS, OUTSIDE = "check_channels", "unexplained"

Spoiler = Callable[[Sequence[Run], np.random.Generator], list[Run]]


def _every(change: Callable[[Run, np.random.Generator], Run]) -> Spoiler:
    return lambda runs, rng: [change(run, rng) for run in runs]


def _second(change: Callable[[Run, np.random.Generator], Run]) -> Spoiler:
    return lambda runs, rng: [change(run, rng) if k == 1 else run for k, run in enumerate(runs)]


def _tau(run: Run, tau: Float) -> Run:
    return replace(run, recording=replace(run.recording, tau=tau))


def _q(run: Run, q: Float) -> Run:
    return replace(run, recording=replace(run.recording, q=q))


def _negated(run: Run, rng: np.random.Generator) -> Run:
    return _tau(run, run.recording.tau * np.array([1.0, -1.0]))


def _swapped(run: Run, rng: np.random.Generator) -> Run:
    return _tau(run, run.recording.tau[:, ::-1])


def _late(run: Run, rng: np.random.Generator) -> Run:
    shift = round(0.15 * run.recording.rate)
    return _tau(run, np.concatenate([np.repeat(run.recording.tau[:1], shift, axis=0), run.recording.tau[:-shift]]))


def _slow(run: Run, rng: np.random.Generator) -> Run:
    """Return the torque behind a filter of first order of 0.8 Hz."""
    out = np.array(run.recording.tau)
    part = 1.0 - np.exp(-2.0 * np.pi * 0.8 / run.recording.rate)
    for k in range(1, len(out)):
        out[k] = out[k - 1] + part * (out[k] - out[k - 1])
    return _tau(run, out)


def _by_hand(run: Run, rng: np.random.Generator) -> Run:
    """Return the torque of drives that carry the weight of a leg that a hand moves."""
    q = np.asarray(run.recording.q)
    knee = 6.0 * np.sin(q.sum(axis=1))
    tau = np.column_stack([18.0 * np.sin(q[:, 0]) + knee, knee])
    return _tau(run, tau + 1e-3 * rng.standard_normal(tau.shape))


def _idle(run: Run, rng: np.random.Generator) -> Run:
    """Return noise alone where the torque should be."""
    return _tau(run, 0.05 * rng.standard_normal(run.recording.tau.shape))


def _of_another_run(runs: Sequence[Run], rng: np.random.Generator) -> list[Run]:
    """Return every motion with the torque of the next run."""
    return [_tau(run, other.recording.tau) for run, other in zip(runs, [*runs[1:], runs[0]], strict=True)]


def _noisy(run: Run, rng: np.random.Generator) -> Run:
    return _q(run, run.recording.q + 0.03 * rng.standard_normal(run.recording.q.shape))


def _pushed(run: Run, rng: np.random.Generator) -> Run:
    """Return the torque beside somebody who pushes for about a third of the time."""
    count, rate = run.recording.tau.shape[0], run.recording.rate
    slow = low_pass(rng.standard_normal((count, 2)), 0.4, rate)
    fine = low_pass(rng.standard_normal((count, 2)), 1.5, rate)
    on = np.clip(4.0 * (slow[:, :1] / slow[:, :1].std() - 0.5), 0.0, 1.0)
    return _tau(run, run.recording.tau + 8.0 * on * fine / fine.std(axis=0))


def _stuck(run: Run, rng: np.random.Generator) -> Run:
    tau = np.array(run.recording.tau)
    half = len(tau) // 2
    tau[half:, 1] = tau[half, 1]
    return _tau(run, tau)


def _gain(run: Run, rng: np.random.Generator) -> Run:
    return _tau(run, run.recording.tau * np.array([1.5, 1.0]))


def _zero(run: Run, rng: np.random.Generator) -> Run:
    return _q(run, run.recording.q + np.array([0.0, 0.4]))


def _brief(run: Run, rng: np.random.Generator) -> Run:
    keep = slice(0, round(3.0 * run.recording.rate))
    one, motion = run.recording, run.motion
    cut = Recording(one.name, one.t[keep], one.q[keep], one.tau[keep], joints=one.joints)
    parts = {key: getattr(motion, key)[keep] for key in ("t", "q", "dq", "ddq", "sign")}
    return Run(cut, replace(motion, **parts), run.torque[keep])


def _other_length(sealed: Sealed) -> Sealed:
    """Return the case with a model whose thigh is a quarter longer than it is."""
    return replace(sealed, model=Model.standard(thigh_length=1.25 * sealed.model.thigh_length))


SPOILT: dict[str, tuple[Spoiler, str, bool]] = {
    "negated": (_every(_negated), CHANNELS, False),
    "swapped": (_every(_swapped), CHANNELS, False),
    "late": (_every(_late), CHANNELS, False),
    "slow": (_every(_slow), CHANNELS, False),
    "hand": (_every(_by_hand), CHANNELS, False),
    "idle": (_every(_idle), CHANNELS, False),
    "of_another_run": (_of_another_run, CHANNELS, False),
    "noisy": (_every(_noisy), CHANNELS, False),
    "pushed": (_every(_pushed), OUTSIDE, False),
    "length": (_every(lambda run, rng: run), CHANNELS, False),
    "brief": (_every(_brief), "", False),
    "one_negated": (_second(_negated), "", True),
    "one_swapped": (_second(_swapped), "", True),
    "one_stuck": (_second(_stuck), "", True),
    "one_gain": (_second(_gain), "", True),
    "one_zero": (_second(_zero), "", True),
}
"""Kind -> what becomes of the runs, the verdict to be given (any), and whether what is hidden can still be named."""


def names(other: int = 0) -> list[str]:
    """Return every case of this plant, kind by kind; with `other`, of other machines."""
    out = []
    for k, kind in enumerate(SPOILT):
        others = [HIDDEN[0] if kind == "pushed" else HIDDEN[1 + (2 * k + n) % (len(HIDDEN) - 1)] for n in range(2)]
        out += [f"{kind}/{what}/{SEED + other + n}" for n, what in enumerate((HIDDEN[0], HIDDEN[0], *others))]
    return out


def draw(name: str) -> Sealed:
    """Return the case of this name."""
    kind, what, seed = name.split("/")
    spoil, told, answered = SPOILT[kind]
    sealed = bench.draw(f"{'none' if what == HIDDEN[0] else 'single'}@0.5/{what}/{seed}")
    runs = tuple(spoil(sealed.runs, np.random.default_rng(number_of(name))))
    sealed = _other_length(sealed) if kind == "length" else sealed
    hidden = sealed.hidden if answered else ()
    return replace(sealed, runs=runs, hidden=hidden, judged=answered, told=told)
