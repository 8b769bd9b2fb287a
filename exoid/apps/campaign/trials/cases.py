"""Blind trials: machines of the virtual bench with effects hidden in them, drawn at random, sized so that they can be
seen.

Each case is a leg of its own: three 30 s runs to fit, one to verify, 100 Hz, the bench's usual instruments. Kinds:

    single    one effect of the catalogue at one joint. Its size is set by what a refitted base model cannot imitate:
              0.25-1.2 N·m RMS at the joint that shows it most, where the torque sensor leaves 0.15-0.25 N·m of noise
    small     the same case at 0.4 times its size
    pair      two different effects, each as in `single`
    none      nothing
    outside   an effect that the catalogue does not have

and those of `machines.py`: what real machines have, with one effect hidden; and of `chains.py`: other machines than the
leg, with one effect hidden or nothing. Their sizes are compared with the noise of the joint's own torque sensor. In
those of `people.py` a person or the ground pushes too, with one effect hidden or nothing; there an effect is as large
as it must be to show in what was recorded (`shown.py`).
"""

from __future__ import annotations

import math
import zlib
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from exoid.apps.campaign.trials.chains import CHAINS
from exoid.apps.campaign.trials.machines import (
    CONVENTION,
    CONVENTIONS,
    MACHINES,
    PASSIVE,
    kept_in,
    without_knee_drive,
)
from exoid.apps.campaign.trials.people import PEOPLE, UNMEASURED, as_measured, as_read, bench_of
from exoid.apps.campaign.trials.shown import shows
from exoid.measurement.bench.blind import draw_hidden, relative_size
from exoid.measurement.bench.hidden import Hidden, true_model
from exoid.measurement.bench.leg import Leg, random_leg
from exoid.measurement.bench.machine import Machine, random_machine
from exoid.measurement.bench.simulation import Bench, BenchError, BenchRun, simulate_runs
from exoid.measurement.signals.conditioning import low_pass
from exoid.measurement.signals.masks import widen
from exoid.measurement.trajectories.trajectory import random_trajectory
from exoid.optimisation.preparation.filtering import reaches
from exoid.optimisation.preparation.sticking import STICK
from exoid.symbolic.effect import Coefficient, Effect, Shape
from exoid.symbolic.effect_catalogue import catalogue
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Motion
from exoid.symbolic.term import Term, places_of

KINDS = ("single", "small", "pair", "none", "outside", *MACHINES, PASSIVE, CONVENTION, *CHAINS, *PEOPLE)
VISIBLE = (0.25, 1.2)
"""RMS in N·m that a hidden effect leaves after the base model was refitted to it."""
RATE, BAND = 200.0, 5.0
"""Sampling and band in Hz in which that is judged."""
USUAL = {"torque_ripple": ("n", 8.0, 120.0), "stribeck": ("v_s", 0.05, 0.3)}
"""Ranges a shape is drawn from where the catalogue's is wider than what can be seen at all: a faster ripple is outside
the band but at creeping speed, a narrower Stribeck peak is inside the speeds at which a joint may stick."""
MOST_SHARE = 0.6
"""Largest effect against the torque of the leg, as standard deviations: an effect that the base model nearly contains
(a spring at the hip) would have to be absurd to be visible."""
SMALL = 0.4
LEGS_WITH_NOTHING = 6
"""Legs of kind `none` per seed, so that false alarms are counted on enough of them."""
PAIRS = 12
"""Pairs per seed, drawn from all there are."""
MACHINES_PER_SEED = 4
"""Effects per seed and kind of `machines.py`."""
CHAINS_PER_SEED = 4
"""Effects per seed and kind of `chains.py` and `people.py`; beside them, one machine with nothing hidden."""
SENSIBLE, SENSIBLE_SHARE = 10.0, 0.3
"""Times its typical size, and share of the torque of the machine, that an effect has at most where it is no leg's: what
would have to be larger to be seen is not hidden there."""
SHOWN_SUSPECTS = 6
GROWN = 3
"""Times that an effect is made half as large again, until it shows on a motion of its own."""


_BUMP, _AT_SPEED = "c * exp(-((theta - m)/w)**2)", "c * exp(-((dtheta - m)/w)**2)"


def _ranges(unit: str, *ends: tuple[float, float, float]) -> dict[str, Shape]:
    """Return place and width of a bump, each (min, max, typical)."""
    return {key: Shape(unit, low, high, typical=usual) for key, (low, high, usual) in zip("mw", ends, strict=True)}


OUTSIDE: dict[str, tuple[Effect, tuple[str, ...]]] = {
    f"{name}:{joint}": (
        Effect(
            name, f"an effect that the catalogue does not have: {torque}", torque, None, (joint,),
            {"c": Coefficient(unit)}, shape, custom=True,
        ),
        variables,
    )
    for name, joint, torque, unit, shape, variables in (
        ("angle_bump", "hip", _BUMP, "N·m", _ranges("rad", (0.4, 0.8, 0.6), (0.12, 0.25, 0.2)), ("q1",)),
        ("angle_bump", "knee", _BUMP, "N·m", _ranges("rad", (-1.2, -0.6, -0.9), (0.12, 0.25, 0.2)), ("q2",)),
        ("speed_bump", "knee", _AT_SPEED, "N·m", _ranges("rad/s", (0.3, 0.7, 0.5), (0.1, 0.3, 0.2)), ("dq2",)),
        ("speed_bump", "hip", _AT_SPEED, "N·m", _ranges("rad/s", (0.3, 0.7, 0.5), (0.1, 0.3, 0.2)), ("dq1",)),
        ("angle_times_speed", "hip", "c * theta1 * dtheta2", "N·m·s/rad", {}, ("q1", "dq2")),
        ("angle_wave", "knee", "c * sin(3*theta + 0.5) * dtheta", "N·m·s/rad", {}, ("q2", "dq2")),
    )
}  # fmt: skip
"""Effects beyond the catalogue, and the variables of which one must be named."""


@dataclass(frozen=True)
class Case:
    """One leg of the campaign: `variants` are the names of the hidden terms (`stribeck:knee`)."""

    kind: str
    variants: tuple[str, ...]
    seed: int

    @classmethod
    def named(cls, name: str) -> Case:
        """Return the case with this `name`."""
        kind, variants, seed = name.split("/")
        return cls(kind, () if variants == "nothing" else tuple(variants.split("+")), int(seed))

    @property
    def name(self) -> str:
        """Name of the case, e.g. "single/stribeck:knee/3"."""
        return f"{self.kind}/{'+'.join(self.variants) or 'nothing'}/{self.seed}"

    @property
    def number(self) -> int:
        """Seed of every random number; the same for `single` and `small`, so that only the size differs."""
        kind = "single" if self.kind == "small" else self.kind
        return zlib.crc32(f"{kind}/{self.variants}/{self.seed}".encode())


def singles(model: Model | None = None) -> list[str]:
    """Return the name of every term of a machine (the leg) that its base model does not contain already."""
    model = Model.standard() if model is None else model
    joints = model.joints
    return [
        Term(effect, joint, joints).name
        for effect in catalogue(joints, model.wearer is not None).values()
        for joint in places_of(effect, joints)
        if joint not in effect.absorbed_on
    ]


def subject(case: Case, rng: np.random.Generator) -> tuple[Model, Leg | Machine]:
    """Return the machine of a case: the model without what is hidden in it, and what it is made of."""
    if case.kind in CHAINS:
        model = CHAINS[case.kind](rng)
        return model, random_machine(model, rng)
    leg = random_leg(rng)
    return Model.standard(thigh_length=leg.thigh_length), leg


def _chain_variants(kind: str, rng: np.random.Generator) -> list[str]:
    """Return the names to hide in machines of a kind of `chains.py`: effects that show on usual motions of one of them.
    """
    usual = np.random.default_rng(0)
    model, machine = subject(Case(kind, (), 0), usual)
    names: list[str] = []
    for name in rng.permutation(singles(model)):
        hidden = _drawn(str(name), model, machine, usual)
        small = _scaled(hidden, min(VISIBLE[0] / visible(hidden, model, machine), _largest(hidden, model, machine)))
        if visible(_possible(small, model, machine), model, machine) > 0.9 * VISIBLE[0]:
            names.append(str(name))
        if len(names) == CHAINS_PER_SEED:
            break
    return names


def cases(kinds: Sequence[str], seeds: int, first: int = 0) -> list[Case]:
    """Return the campaign, seed by seed, so that an interrupted one has seen every kind."""
    out = []
    for seed in range(first, first + seeds):
        rng = np.random.default_rng([seed, 7])
        names = singles()
        by_kind = {
            "single": [Case("single", (n,), seed) for n in names],
            "small": [Case("small", (n,), seed) for n in names],
            "pair": [Case("pair", _pair(rng, names), seed) for _ in range(PAIRS)],
            "none": [Case("none", (), LEGS_WITH_NOTHING * seed + k) for k in range(LEGS_WITH_NOTHING)],
            "outside": [Case("outside", (n,), seed) for n in OUTSIDE],
        }
        for kind in MACHINES:
            by_kind[kind] = [Case(kind, (str(n),), seed) for n in rng.choice(names, MACHINES_PER_SEED, replace=False)]
        for kind, choice in ((PASSIVE, [n for n in names if n.endswith(":hip")]), (CONVENTION, CONVENTIONS)):
            by_kind[kind] = [Case(kind, (str(n),), seed) for n in rng.choice(choice, MACHINES_PER_SEED, replace=False)]
        for kind in [kind for kind in kinds if kind in CHAINS]:
            by_kind[kind] = [*(Case(kind, (n,), seed) for n in _chain_variants(kind, rng)), Case(kind, (), seed)]
        for kind in [kind for kind in kinds if kind in PEOPLE]:
            drawn = np.random.default_rng([seed, 8]).choice(names, CHAINS_PER_SEED, replace=False)
            by_kind[kind] = [*(Case(kind, (str(n),), seed) for n in drawn), Case(kind, (), seed)]
        out += [case for kind in kinds for case in by_kind[kind]]
    return out


def _pair(rng: np.random.Generator, names: list[str]) -> tuple[str, str]:
    """Return two terms of different effects."""
    while True:
        first, second = (names[int(k)] for k in rng.choice(len(names), 2, replace=False))
        if first.partition(":")[0] != second.partition(":")[0]:
            return first, second


def hide(case: Case, model: Model, leg: Leg | Machine, rng: np.random.Generator) -> tuple[Hidden, ...]:
    """Return the effects hidden in the machine of `case`, with their numbers drawn."""
    out = []
    for name in case.variants if case.kind != CONVENTION else ():
        hidden = _drawn(name, model, leg, rng)
        wanted = math.exp(float(rng.uniform(*np.log(VISIBLE))))
        hidden = _scaled(hidden, min(wanted / visible(hidden, model, leg), _largest(hidden, model, leg)))
        out.append(_possible(_scaled(hidden, SMALL if case.kind == "small" else 1.0), model, leg))
    return tuple(out)


def _largest(hidden: Hidden, model: Model, leg: Leg | Machine) -> float:
    """Return by what an effect may be multiplied at most."""
    assert isinstance(hidden.effect, Effect)
    share = max(relative_size(hidden, leg, model), 1e-12)
    if not model.chain:
        return MOST_SHARE / share
    sizes = {p.name.rpartition(".")[2]: p.typical for p in Term(hidden.effect, hidden.joint, model.joints).parameters}
    most = [SENSIBLE * abs(size) / max(abs(hidden.values[key]), 1e-12) for key, size in sizes.items() if size]
    return min([*most, SENSIBLE_SHARE / share])


def _drawn(name: str, model: Model, leg: Leg | Machine, rng: np.random.Generator) -> Hidden:
    """Return the term called `name` with numbers drawn, of any size."""
    identifier, _, joint = name.partition(":")
    effect = OUTSIDE[name][0] if name in OUTSIDE else catalogue(model.joints)[identifier]
    (drawn,) = draw_hidden(rng, [effect], leg=leg, model=model, nothing=0.0, joint=joint or None)
    return _placed(drawn, model, rng)


def motions(model: Model) -> list[Motion]:
    """Return three usual motions, 10 s each, on which sizes are assessed."""
    t, limits = np.arange(0.0, 10.0, 1.0 / RATE), model.motion_limits
    return [random_trajectory(np.random.default_rng(k), limits).at(t) for k in range(3)]


def visible(hidden: Hidden, model: Model, leg: Leg | Machine) -> float:
    """Return the RMS in N·m or N of what a refitted base model cannot imitate, at the joint that shows it most among
    its noise; that of a finer torque sensor counts as much more as the sensor is finer.

    Only below the band in which accelerations are usually clean: faster torque is beyond any model fitted to these.
    """
    plain, full = true_model(model, leg.base, ()), true_model(model, leg.base, (hidden,))
    columns = [low_pass(np.moveaxis(model.columns(m), 1, 0), BAND, RATE) for m in motions(model)]
    added = [low_pass(full.torque(m) - plain.torque(m), BAND, RATE) for m in motions(model)]
    x, y = np.concatenate(columns).reshape(-1, model.base_count), np.concatenate(added).ravel()
    if model.chain:  # where a joint may stick nothing is fitted; sizes in legs stay as they were always drawn
        slow = np.concatenate([np.abs(m.dq) < STICK * reaches(model.joints) for m in motions(model)])
        moving = ~np.column_stack([widen(joint, int(RATE / BAND)) for joint in slow.T]).ravel()
        x, y = x * moving[:, None], y * moving
    left = (y - x @ np.linalg.lstsq(x, y, rcond=None)[0]).reshape(-1, len(model.joints)) / leg.sensor_scale
    return float(np.sqrt(np.mean(left**2, axis=0)).max()) + 1e-12


def _placed(hidden: Hidden, model: Model, rng: np.random.Generator) -> Hidden:
    """Put what sits at an angle (an end stop) where the joint gets to, near its end; give others a usual shape."""
    assert isinstance(hidden.effect, Effect)
    term = Term(hidden.effect, hidden.joint, model.joints)
    if hidden.effect.id in USUAL:
        key, low, high = USUAL[hidden.effect.id]
        scale = term.placed_shape[key].max / hidden.effect.shape[key].max
        usual = scale * math.exp(float(rng.uniform(*np.log((low, high)))))
        return replace(hidden, values={**hidden.values, key: usual})
    places = [key for key, shape in term.placed_shape.items() if shape.spacing == "position"]
    if not places or hidden.joint is None:
        return hidden
    angle = np.concatenate([m.q[:, term.first] for m in motions(model)])
    part = float(rng.uniform(0.75, 0.92))
    part = 1.0 - part if hidden.values.get("side", 1.0) < 0.0 else part
    return replace(hidden, values={**hidden.values, **dict.fromkeys(places, float(np.quantile(angle, part)))})


def _scaled(hidden: Hidden, factor: float) -> Hidden:
    """Return the effect `factor` times as large: its coefficients, or its only number where it has none."""
    assert isinstance(hidden.effect, Effect)
    size = hidden.effect.coefficients or hidden.effect.shape
    return replace(hidden, values={k: v * (factor if k in size else 1.0) for k, v in hidden.values.items()})


def _possible(hidden: Hidden, model: Model, leg: Leg | Machine) -> Hidden:
    """Keep numbers within their bounds, and presliding friction within the dry friction that it takes the place of."""
    assert isinstance(hidden.effect, Effect)
    term = Term(hidden.effect, hidden.joint, model.joints)
    bounds = term.placed_shape
    values = {k: min(max(v, bounds[k].min), bounds[k].max) if k in bounds else v for k, v in hidden.values.items()}
    if hidden.effect.id in ("friction_drift", "viscous_drift", "joint_elasticity"):
        values["c"] = abs(values["c"])  # more friction while cold, or it would drive the joint; a spring that yields
    if hidden.effect.id == "hysteresis":
        values["c"] = min(values["c"], leg.base[len(model.inertial) + 2 * term.first])
    return replace(hidden, values=values)


def simulated(
    case: Case, model: Model, leg: Leg | Machine, rng: np.random.Generator
) -> tuple[tuple[Hidden, ...], tuple[BenchRun, ...]]:
    """Return the hidden effects and their four runs; smaller where the machine could not be moved otherwise."""
    hidden = hide(case, model, leg, rng)
    worse = MACHINES.get(case.kind, lambda runs, _: runs)
    if case.kind == CONVENTION:
        return hidden, tuple(kept_in(case.variants[0], simulate_runs(4, model, leg, seed=case.number)))
    bench = bench_of(case.kind, rng) if case.kind in PEOPLE else None
    if case.kind == PASSIVE and isinstance(leg, Leg):
        leg = without_knee_drive(leg)
    for _ in range(8):
        try:
            runs = simulate_runs(4, model, leg, effects=hidden, seed=case.number, bench=bench)
            break
        except BenchError:
            hidden = tuple(_scaled(effect, 0.7) for effect in hidden)
    else:
        runs = simulate_runs(4, model, leg, effects=hidden, seed=case.number, bench=bench)
    if bench is not None:
        return _beside_what_pushes(case, model, leg, hidden, runs, bench)
    return hidden, tuple(worse(runs, rng))


def _beside_what_pushes(
    case: Case, model: Model, leg: Leg | Machine, hidden: tuple[Hidden, ...], runs: tuple[BenchRun, ...], bench: Bench
) -> tuple[tuple[Hidden, ...], tuple[BenchRun, ...]]:
    """Return the effects hidden in a leg that a person or the ground pushes, and its four runs. Sizes are drawn on
    another motion: what does not show on this one, beside the noise of what measures the pushes, is made larger.
    """
    for _ in range(GROWN):
        told = as_measured(runs) if case.kind in UNMEASURED else as_read(runs)
        if not hidden or shows(model, runs, told):
            break
        larger = tuple(_possible(_scaled(effect, 1.5), model, leg) for effect in hidden)
        try:
            runs, hidden = simulate_runs(4, model, leg, effects=larger, seed=case.number, bench=bench), larger
        except BenchError:
            break
    return hidden, runs
