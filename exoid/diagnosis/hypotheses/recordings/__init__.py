"""Hypotheses of what belongs to recordings: one file each, found by reading the folder.

A hypothesis changes the *prediction*, never the measured torque: it proposes columns that are added to the model's
torque, each times a number that belongs to a recording (the zero of its torque sensor) or to some recordings together
(a load that they carry). What they are worth is judged where they were not learnt
(`exoid.diagnosis.own_numbers`).
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from types import ModuleType

import numpy as np

from exoid.ground.folder import modules_in
from exoid.measurement.logged import Logged
from exoid.optimisation.linear.loss import Bool
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Float

OTHERS = "the others"
"""What recordings are called that are told together."""
TINY = 1e-6
"""Number by which times are moved for a derivative."""


@dataclass(frozen=True, eq=False)
class Seen:
    """A model on one recording: its `columns` (J, K, P) at its `linear` numbers (P,), its `torque` (J, K) N·m, at the
    times `t` (K,) s; filtered like the measured torque, or before the filter. `logged` are further columns, the
    recording `began` at so many s. `number` is that of a claim, where its pieces bend with it: 0 at first. `rising` is
    the slope (J, K) of the torque over time as it passes the filter; None where that of the torque itself is it.
    `elsewhere` is the torque (J, M) at other times (M,), which a number that is known asks for; `by_angle` its
    derivative (J, K) by the angle of a joint (index).
    """

    model: Model
    linear: Float
    columns: Float
    torque: Float
    t: Float
    logged: Mapping[str, Logged]
    began: float
    number: float = 0.0
    rising: Float | None = None
    elsewhere: Callable[[Float], Float] | None = None
    by_angle: Callable[[int], Float] | None = None


Node = tuple[float, ...]
"""Where something is, m: a place along a link, or three numbers in space; () for what is nowhere."""


def _alone(at: Node) -> Float:
    return np.ones(1)


@dataclass(frozen=True)
class StateColumn:
    """A further column that all recordings have, in `unit`: its `middle`, how far it goes from there (`reach`), and the
    joint (index) that its name says; None for none.
    """

    name: str
    unit: str
    middle: float
    reach: float
    joint: int | None


def nothing(seen: Seen) -> Float:
    """No torque (J, K, 1)."""
    return np.zeros((*seen.torque.shape, 1))


@dataclass(frozen=True, eq=False)
class Claim:
    """One thing that may belong to recordings: `what` at a `place` (a joint or link; None for all), in `unit`.

    The prediction gains its number times `pieces(seen)` (J, K, m) mixed by `mix(node)` (m,), at one of the `nodes`
    (V,). The number lies within `bounds`, and is told from `usual` on. It is a `factor` where it multiplies a torque of
    the model: its pieces are linear in the model's numbers; where it `moves` that in time, it says to which times (K,),
    and the last piece is added whatever its number; where it `turns` a joint (index), by its number from where it was
    read. Friction that grows with the load feels it where it is `borne` by the drives; what is of a `drive`, or of its
    sensor, no joint without one has. `everyone`: each recording has one of its own; `common`: all have the same;
    otherwise those have one that differ from the others, and may have the same where it is `shared`; it may begin
    within a recording, unless it is of the `whole`. What is `unlike` a hypothesis, another or itself, must beat it
    where all have the same number of that, which is the machine's. `of` is what else its sentence tells, `shown` how
    many of another unit its own is, in which it is said.
    """

    what: str
    place: str | None
    unit: str
    pieces: Callable[[Seen], Float]
    bounds: tuple[float, float]
    usual: float = 0.0
    factor: bool = False
    moves: Callable[[Seen], Float] | None = None
    turns: int | None = None
    borne: bool = False
    drive: bool = False
    everyone: bool = False
    shared: bool = False
    common: bool = False
    whole: bool = False
    unlike: str = ""
    nodes: tuple[Node, ...] = ((),)
    mix: Callable[[Node], Float] = _alone
    of: str = ""
    shown: tuple[float, str] | None = None

    @property
    def subject(self) -> tuple[str, str | None, str]:
        """Quantity that it is about: the hypothesis, the place, and what else its sentence tells."""
        return self.what, self.place, self.of

    @property
    def key(self) -> tuple[str, str | None, str, bool]:
        """Key by which a claim is known in other fits: all recordings may have a number, and one of them another."""
        return *self.subject, self.common

    @property
    def bends(self) -> bool:
        """True if what it adds is not proportional to its number."""
        return self.moves is not None or self.turns is not None

    @property
    def multiplies(self) -> bool:
        """True if it multiplies a torque of the model by a number."""
        return self.factor and self.moves is None

    @property
    def of_motion(self) -> bool:
        """True if the torques, all of them, are those of another motion than the one recorded."""
        return self.bends and (self.place is None or self.turns is not None)


@cache
def hypotheses() -> dict[str, ModuleType]:
    """Return the modules of this folder by name. Each has `claims(model, columns)`, what it proposes for a model's
    machine and further columns of its recordings, and `said(claim, values, where, when)`, a sentence about the numbers
    {recording: words} of one claim (of `everyone` those alike may be OTHERS together); `where` is the place of a load
    in words, `when` since when or until when that is so, or "".
    """
    return modules_in(sys.modules[__name__])


def claims_of(model: Model, driven: Bool | None = None, columns: Sequence[StateColumn] = ()) -> tuple[Claim, ...]:
    """Claims of all hypotheses for a machine whose joints `driven` (J,) have a drive (None: all), and its columns."""
    found: Sequence[Sequence[Claim]] = [hypothesis.claims(model, columns) for hypothesis in hypotheses().values()]
    passive: set[str | None] = {model.joint_names[k] for k in np.flatnonzero(~driven)} if driven is not None else set()
    if len(model.joints) - len(passive) < 2:  # what all drives have is what the only one has
        passive.add(None)
    return tuple(claim for some in found for claim in some if not (claim.drive and claim.place in passive))


def sentence_on(claim: Claim, values: dict[str, str], where: str = "", when: str = "") -> str:
    """Sentence of its hypothesis on the numbers {recording: words} of a claim."""
    return str(hypotheses()[claim.what.partition(":")[0]].said(claim, values, where, when))


def at_joint(joint: int, torque: Callable[[Seen], Float]) -> Callable[[Seen], Float]:
    """Return pieces (J, K, 1) that are `torque` (K,) at one joint (index) and nothing at the others."""

    def pieces(seen: Seen) -> Float:
        out = np.zeros((*seen.torque.shape, 1))
        out[joint, :, 0] = torque(seen)
        return out

    return pieces


def moving(
    what: str, unit: str, when: Callable[[Seen], Float], most: float, shown: tuple[float, str],
    joint: tuple[int, str] | None = None,
) -> Claim:  # fmt: skip
    """Claim that all torques are those of other times (K,), or that of one `joint` (index, name), by a number of at
    most `most`.
    """
    index, place = joint or (None, None)
    pieces, bounds = partial(_moved, when, index), (-most, most)
    return Claim(
        what, place, unit, pieces, bounds, factor=True, moves=when, drive=place is not None, mix=_first, shown=shown
    )


def _first(at: Node) -> Float:
    return np.array([1.0, 0.0])


def _moved(when: Callable[[Seen], Float], joint: int | None, seen: Seen) -> Float:
    """Return by what the torque changes with the number, at that known already, and what that change lacks so far."""
    slope = (when(replace(seen, number=seen.number + TINY)) - when(seen)) / TINY
    if not seen.number:
        rises = slope * (np.gradient(seen.torque, seen.t, axis=1) if seen.rising is None else seen.rising)
        lacking = np.zeros(rises.shape)
    else:
        assert seen.elsewhere is not None
        times = when(seen)
        then = seen.elsewhere(times)
        rises = np.gradient(then, times, axis=1, edge_order=2) * slope
        lacking = then - seen.torque - seen.number * rises
    both = np.stack([rises, lacking], axis=2)
    return both if joint is None else np.where(np.arange(len(both))[:, None, None] == joint, both, 0.0)


def each_said(values: dict[str, str]) -> str:
    """Return "run_0 0.91 ± 0.02, run_2 0.2 ± 0.02"."""
    return ", ".join(f"{name} {text}" for name, text in values.items())


def sides(values: dict[str, str], above: str, below: str) -> dict[str, str]:
    """Return words on numbers without their sign, and `above` or `below` for it."""
    return {name: f"{text.lstrip('-')} {below if text.startswith('-') else above}" for name, text in values.items()}


def listed(names: Iterable[str]) -> str:
    """ "run_0, run_1 and run_2"."""
    *first, last = names
    return f"{', '.join(first)} and {last}" if first else last


def than_usual(what: str, when: str) -> str:
    """Words such as "The ... than in the other recordings" or "From 12.0 s on the ... than before"."""
    if not when:
        return f"The {what} than in the other recordings"
    return f"{when} the {what} than {'before' if when.startswith('From') else 'later'}"
