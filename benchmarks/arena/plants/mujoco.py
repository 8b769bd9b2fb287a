"""MuJoCo: its solver decides about stick and slip, its bodies are soft, stopped and loose. Needs the extra `peers`.

leg@NOISE/WHAT/SEED and chain@NOISE/WHAT/SEED: what `mujoco_leg.py` and `mujoco_chains.py` build
"""

from __future__ import annotations

import importlib.util

import numpy as np

from benchmarks import mujoco_chains, mujoco_leg
from benchmarks.arena.task import Left, Run, Sealed, measured, number_of
from exoid.measurement.signals.conditioning import derivatives
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Motion

SECONDS = 20.0
NOISES = (0.4, 0.1)


def names(other: int = 0) -> list[str]:
    """Return every case of this plant; with `other`, of other motions and machines."""
    legs = [f"leg@{noise:g}/{case}/{1 + other}" for case in mujoco_leg.CASES for noise in NOISES]
    chains = [f"chain@{NOISES[k % 2]:g}/{case}/{1 + other}" for k, case in enumerate(mujoco_chains.CASES)]
    return [*legs, *chains]


def draw(name: str) -> Sealed:
    """Return the case of this name; Left where MuJoCo is not installed."""
    if importlib.util.find_spec("mujoco") is None:
        raise Left("MuJoCo is not installed; pip install 'exoid[peers]'")
    head, what, seed = name.split("/")
    kind, _, size = head.partition("@")
    rng = np.random.default_rng(number_of(name))
    if kind == "leg":
        leg, answers = mujoco_leg.CASES[what]
        made = [mujoco_leg.simulate(leg, int(seed), k, SECONDS, noise=False) for k in range(5)]
        model, noise = Model.standard(), np.full(2, float(size))
        hidden = tuple(one for one in answers if one not in ("unexplained", "check_channels"))
        clean = [(seen, Motion(seen.t, *kept[:3])) for seen, kept in made]
    else:
        chain = mujoco_chains.Chain.of(what, rng)
        model = Model("chain", limits={}, joints=chain.joints)
        noise = float(size) * np.array([link.noise for link in chain.links]) / 0.5
        hidden = _hidden(chain, what)
        clean = [mujoco_chains.simulate(chain, rng, f"run_{k}", SECONDS, noise=False) for k in range(5)]
    runs = []
    for seen, motion in clean:
        dq, ddq = derivatives(np.asarray(seen.q), seen.rate)
        read = Motion(seen.t, seen.q, dq, ddq) if kind == "chain" else motion
        runs.append(measured(Run(seen, read, np.asarray(seen.tau)), noise, rng))
    return Sealed(model, tuple(runs), hidden, noise)


def _hidden(chain: mujoco_chains.Chain, what: str) -> tuple[str, ...]:
    if chain.built is None:
        return ()
    return (what.split(":")[0] if chain.built.where == "tilt" else what,)
