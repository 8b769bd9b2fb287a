"""Effects that no motion can distinguish: those whose torque is, at every state, a combination of others.

At many random states (any angle, velocity, acceleration, sign and instant, independent values of the operators with
memory) the derivatives of the torque by all numbers are laid side by side. Where one is a combination of others, the
two cannot be separated by any motion. A dependence found in double precision counts only if it persists in 40 digits.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from exoid.ground.cache import cache_folder, read_trusted, write_trusted
from exoid.ground.errors import EffectError
from exoid.ground.files import sha256
from exoid.ground.plain import SPOILT
from exoid.symbolic.codegen.equation import model_expressions
from exoid.symbolic.codegen.fingerprint import canonical_json, generator_key, library_versions, model_data, term_content
from exoid.symbolic.codegen.precise import evaluate_precisely, in_span
from exoid.symbolic.effect_catalogue import catalogue
from exoid.symbolic.language.writing import to_text
from exoid.symbolic.memory import memory_operations
from exoid.symbolic.motion import Float
from exoid.symbolic.quantity import JOINTS
from exoid.symbolic.term import Term, places_of

if TYPE_CHECKING:
    from exoid.symbolic.model_structure import ModelStructure

LARGEST_CACHE = 50_000_000
"""Bytes of what is kept of one model; it has some ten thousand."""
SEED = 20261
STATES = 240
PRECISE_STATES = 24
RANK = 1e-9
"""Relative remainder below which double precision suspects a dependence; true ones leave 1e-15."""
EXACT = 1e-13
"""Relative remainder allowed in 40 digits: the constants of a model (g / a_th) are doubles themselves."""


@dataclass(frozen=True)
class LookAlike:
    """Numbers `names` that no motion can distinguish; `relation` says how one is made of the others.

    `absorbed` is set where an effect is contained in the model as it is, so that adding it changes nothing.
    """

    names: tuple[str, ...]
    relation: str
    absorbed: bool

    def __str__(self) -> str:
        return f"{self.relation}: no motion can distinguish them"


@dataclass(frozen=True, eq=False)
class Tangents:
    """Derivatives of the torque by the numbers `names` (n,): `values` (J·STATES, n), and the function they are from."""

    names: tuple[str, ...]
    values: Float
    function: Any
    inputs: tuple[Float, ...]

    def precise(self) -> list[list[Any]]:
        """Return the columns (n of (J·PRECISE_STATES,)) in 40 digits."""
        rows: list[Any] = []
        for k in range(PRECISE_STATES):
            at = [part[:, k] if part.ndim == 2 else part for part in self.inputs]
            flat = evaluate_precisely(self.function, at)
            joints = len(self.inputs[1])
            rows += [flat[j::joints] for j in range(joints)]
        return [list(column) for column in zip(*rows, strict=True)]


def structural_look_alikes(model: ModelStructure, candidates: Sequence[Term] | None = None) -> tuple[LookAlike, ...]:
    """Numbers of `model` and of the `candidates` that no motion can distinguish.

    Default candidates: the whole catalogue at every joint, including joints where an entry says it is absorbed. Each is
    compared with the model; those that survive are compared with each other, two at a time.
    """
    base = tangents(model)
    found = [_relation(base, k, None) for k in range(1, len(base.names))]
    survivors: list[tuple[str, Tangents]] = []
    for term in every_candidate(model) if candidates is None else candidates:
        own = tangents(replace(model, terms=(*model.terms, term)), term.name)
        relations = [_relation(base, k, own) for k in range(len(own.names))]
        found += relations
        if own.names and not any(relations):
            survivors.append((term.name, own))
    for i, (first, item) in enumerate(survivors):
        found += [_pair(base, first, item, second, other) for second, other in survivors[i + 1 :]]
    return tuple(entry for entry in found if entry is not None)


def known_look_alikes(model: ModelStructure) -> tuple[LookAlike, ...]:
    """Return `structural_look_alikes(model)` for the whole catalogue, computed once and then read from the cache.

    Reading takes milliseconds and loads neither SymPy nor CasADi. A file that does not match its seal is made anew.
    """
    path = cache_folder() / f"look_alikes-{_content_key(model)[:40]}.json"
    found = _read(path)
    if found is None:
        found = structural_look_alikes(model)
        plain = [asdict(item) for item in found]
        try:
            content = canonical_json({"found": plain, "seal": sha256(canonical_json(plain))})
            write_trusted(path, content)
        except OSError:
            # A full disk costs the next caller the computation, not this one the answer.
            return found
    return found


def never_separable(names: Sequence[str], model: ModelStructure) -> Mapping[str, tuple[str, ...]]:
    """Return for each term name ("stribeck:knee") what imitates it at every state, so that no motion tells.

    The others are terms of the catalogue or the user's, compared with `model` without the terms named; where the model
    itself contains the term, they are its numbers ("Phi1"). A mapping is one way only: a spring with a free rest angle
    imitates an offset, not the reverse. EffectError for a name that is no term.
    """
    kept = tuple(term for term in model.terms if term.name not in names)
    base = model if len(kept) == len(model.terms) else replace(model, terms=kept)
    candidates = {term.name: term for term in every_candidate(base)}
    unknown = [name for name in names if name not in candidates]
    if unknown:
        what = f"no effect is called {', '.join(unknown)}; write ID:hip, ID:knee, or ID if it has both joints"
        raise EffectError(what)
    found = known_look_alikes(base)
    return {name: _imitators(candidates[name], found) for name in names}


def _imitators(term: Term, found: Sequence[LookAlike]) -> tuple[str, ...]:
    own = {f"{term.name}.{number}" for number in (*term.effect.coefficients, *term.effect.shape)}
    absorbed = [entry for entry in found if entry.absorbed and entry.names[0] in own]
    names = [n for element in absorbed for n in element.names[1:]] if own and len(absorbed) == len(own) else []
    for item in found:
        if not item.absorbed and len(item.names) == 2 and term.name in item.names:
            inner, outer = item.names
            if inner == term.name or "is the same as" in item.relation:
                names.append(outer if inner == term.name else inner)
    return tuple(dict.fromkeys(n for n in names if n not in own))


def _content_key(model: ModelStructure) -> str:
    candidates = [[term_content(term), repr(term.effect.shape)] for term in every_candidate(model)]
    shapes = [repr(entry.shape) for entry in model.shapes]
    parts = [model_data(model), shapes, candidates, library_versions(), generator_key(), SEED, STATES, PRECISE_STATES]
    return sha256(canonical_json(parts))


def _read(path: Path) -> tuple[LookAlike, ...] | None:
    try:
        content = json.loads(read_trusted(path, LARGEST_CACHE))
        if content["seal"] != sha256(canonical_json(content["found"])):
            return None
        return tuple(LookAlike(tuple(item["names"]), item["relation"], item["absorbed"]) for item in content["found"])
    except (OSError, *SPOILT):
        return None


def every_candidate(model: ModelStructure) -> tuple[Term, ...]:
    """Return every effect of the catalogue and of the user at every joint, except the terms the model has."""
    present = {term.name for term in model.terms}
    terms = []
    for effect in (*catalogue(model.joints).values(), *model.custom):
        if model.chain or effect.on_both:
            terms += [Term(effect, joint, model.joints) for joint in places_of(effect, model.joints)]
        else:
            everywhere = replace(effect, joints=tuple(j for j in JOINTS if j in (*effect.joints, *effect.absorbed_on)))
            terms += [Term(everywhere, joint) for joint in everywhere.joints]
    return tuple(term for term in terms if term.name not in present)


def tangents(model: ModelStructure, only: str | None = None) -> Tangents:
    """Return the derivatives of the torque by all numbers of the model, or by those of the term called `only`.

    Left out are choices, which have no derivative, and shapes that act through an operator's past alone.
    """
    import casadi

    x = model_expressions(model)
    torque = x.torque
    for k, entry in enumerate(model.shapes):
        if entry.shape.choices:  # what acts under another choice alone has no part in this one
            torque = casadi.substitute(torque, x.shape[k], casadi.SX(entry.typical))
    numbers = [(p.name, p.term, x.linear[k]) for k, p in enumerate(model.parameters)]
    numbers += [(s.name, s.term, x.shape[k]) for k, s in enumerate(model.shapes) if not s.shape.choices]
    chosen = [(name, symbol) for name, term, symbol in numbers if only is None or term == only]
    chosen = [(name, symbol) for name, symbol in chosen if casadi.depends_on(torque, symbol)]
    symbols = casadi.vertcat(casadi.SX(0, 1), *(symbol for _, symbol in chosen))
    slopes = casadi.vec(casadi.densify(casadi.jacobian(torque, symbols)))
    arguments = [x.t, x.q, x.dq, x.ddq, x.sign, x.base_motion, x.force, x.memory, x.linear, x.shape]
    function = casadi.Function("tangents", arguments, [slopes])
    states = random_states(STATES, len(model.joints))
    base, force = (np.random.default_rng(SEED).normal(size=(part.numel(), STATES)) for part in (x.base_motion, x.force))
    inputs = (*states, base, force, memory_values(model), generic_linear(model), model.typical_shape)
    values = np.asarray(function(*inputs)) if chosen else np.zeros((0, STATES))
    rows = len(model.joints)
    stacked = values.reshape(len(chosen), rows, STATES).transpose(2, 1, 0).reshape(rows * STATES, len(chosen))
    return Tangents(tuple(name for name, _ in chosen), stacked, function, inputs)


def random_states(count: int, joints: int = 2) -> tuple[Float, ...]:
    """Return t (1, N), q, dq, ddq, sign (J, N), drawn independently; velocities on all scales."""
    rng = np.random.default_rng(SEED)
    sign = rng.choice([-1.0, 1.0], size=(joints, count))
    return (
        rng.uniform(0.0, 30.0, size=(1, count)),
        rng.uniform(-np.pi, np.pi, size=(joints, count)),
        sign * 10.0 ** rng.uniform(-2.0, 0.5, size=(joints, count)),
        rng.normal(scale=3.0, size=(joints, count)),
        sign,
    )


def memory_values(model: ModelStructure) -> Float:
    """Return values (K, N) of the operators with memory: what they hold depends on a past that the state leaves open.

    Each signal of each term has its own, whichever model it stands in; a signal of two joints' texts has one.
    """
    rows = []
    written: dict[str, str] = {}
    for term, _, operation in memory_operations(model):
        text = f"{operation.operator}({to_text(operation.argument)}, {operation.parameter!r})"
        for name in sorted(operation.argument.names() & written.keys(), key=len, reverse=True):
            text = text.replace(name, written[name])
        written[operation.name] = text
        seed = int(sha256(f"{term.name} {text}")[:8], 16)
        rows.append(np.random.default_rng((SEED, seed)).normal(size=STATES))
    return np.array(rows).reshape(len(rows), STATES)


def generic_linear(model: ModelStructure) -> Float:
    """Return linear parameters (P,) without special relations; the first are the same for every model."""
    rng = np.random.default_rng(SEED + 1)
    return np.asarray(rng.uniform(0.5, 2.0, size=len(model.parameters)))


def _relation(base: Tangents, k: int, own: Tangents | None) -> LookAlike | None:
    """Return the relation of number k to what stands before it: the model's own, or the model and the candidate's."""
    if own is None:
        names, known = base.names[:k], base.values[:, :k]
        name, column = base.names[k], base.values[:, k]
    else:
        names, known = (*base.names, *own.names[:k]), np.column_stack([base.values, own.values[:, :k]])
        name, column = own.names[k], own.values[:, k]
    combination = _combination(known, column)
    if combination is None:
        return None
    precise = base.precise() if own is None else [*base.precise(), *own.precise()]
    if not in_span(precise[: len(names)], precise[len(names)], EXACT):
        return None
    used = [(n, c) for n, c in zip(names, combination, strict=True) if c != 0.0]
    return LookAlike((name, *(n for n, _ in used)), f"{name} = {_written(used)}", own is not None)


def _pair(base: Tangents, first: str, one: Tangents, second: str, other: Tangents) -> LookAlike | None:
    """Relation in which two candidates coincide once the model has taken its part of each."""
    for (outer, big), (inner, small) in (((first, one), (second, other)), ((second, other), (first, one))):
        known = np.column_stack([base.values, big.values])
        if any(_combination(known, column) is None for column in small.values.T):
            continue
        precise = [*base.precise(), *big.precise()]
        if not all(in_span(precise, column, EXACT) for column in small.precise()):
            continue
        how = "is the same as" if len(big.names) == len(small.names) else "is contained in"
        return LookAlike((inner, outer), f"{inner} {how} {outer}, up to numbers of the model", False)
    return None


def _combination(known: Float, column: Float) -> Float | None:
    """Return the coefficients with which `known` columns give `column`, or None where they do not."""
    size = float(np.linalg.norm(column))
    if size == 0.0:  # it changes nothing at all on this machine
        return np.zeros(known.shape[1])
    scale = np.linalg.norm(known, axis=0)
    scale = np.where(scale > 0.0, scale, 1.0)
    solution, *_ = np.linalg.lstsq(known / scale, column / size, rcond=1e-12)
    if np.linalg.norm(known / scale @ solution - column / size) > RANK:
        return None
    solution = solution * size / scale
    return np.where(np.abs(solution) > 1e-9 * np.abs(solution).max(), solution, 0.0)


def _written(used: Sequence[tuple[str, float]]) -> str:
    if not used:
        return "0"
    text = " ".join(f"{'-' if c < 0 else '+'} {_number(abs(c))}{name}" for name, c in used)
    return text.removeprefix("+ ")


def _number(value: float) -> str:
    """Return a factor as a small fraction where it is one."""
    exact = Fraction(value).limit_denominator(1000)
    if abs(float(exact) - value) < 1e-9 * value:
        return "" if exact == 1 else f"{exact} "
    return f"{value:.6g} "
