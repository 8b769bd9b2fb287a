"""A model's equation of motion as CasADi expressions: what C is generated from and integrators are built on.

The path of every term is torque text -> SymPy -> derivative by each coefficient -> CasADi; the rigid part
comes from Lagrange through SymPy as well. Operators with memory (play, dahl, delay, lag, ddt) need more than an
instant: each becomes an input `memory[k]`, and `memories[k]` says what feeds it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from exoid.ground.errors import EffectError
from exoid.symbolic.codegen.layout import BASE_STATE, STEMS, force_names, state_names
from exoid.symbolic.codegen.spatial_columns import spatial_columns
from exoid.symbolic.codegen.translate import casadi_from_sympy
from exoid.symbolic.codegen.tree_columns import AS_THEY_ARE, LONGEST_SYMBOLIC, AlteredLinks, tree_columns
from exoid.symbolic.language.deflection import STATES
from exoid.symbolic.language.instant import split_memory
from exoid.symbolic.language.lower import to_casadi, to_sympy
from exoid.symbolic.language.torque import by_stage, torques, uses_slopes
from exoid.symbolic.mechanics.friction import friction
from exoid.symbolic.mechanics.lagrange import christoffel, mechanics
from exoid.symbolic.mechanics.mechanism import machine, real
from exoid.symbolic.mechanics.newton_euler import STILL, BaseMotion, point
from exoid.symbolic.mechanics.rigid import changed, leg_columns, symbols_of
from exoid.symbolic.mechanics.spatial import end_point
from exoid.symbolic.mechanics.tree import offset_changes, tree_changes
from exoid.symbolic.mechanics.virtual_work import force_torques, space_force_torques

if TYPE_CHECKING:
    from exoid.symbolic.model_structure import ModelStructure
    from exoid.symbolic.term import Term

@dataclass(frozen=True, eq=False)
class MemorySignal:
    """Source of an input `memory[k]`: `operator` (its word), `argument` and `parameter` (SX; None for ddt).

    Both may hold earlier memory inputs.
    """

    operator: str
    argument: Any
    parameter: Any | None


@dataclass(frozen=True, eq=False)
class Expressions:
    """A model in CasADi SX.

    Inputs: `t`, `q`, `dq`, `ddq`, `sign` (J,), `base_motion` (5, 12 in space, or 0 where it stands), `force` (C,),
    `linear` (P,), `shape` (S,), `memory` (K,). `columns` holds
    (joint, parameter, expression) of every entry of the regressor that is not zero everywhere; `linear`
    serves there as reference, and P stands for what measured forces make without a number. `rigid`, `base`
    (rigid, friction and measured forces) and `torque` (all) are torques (J,) in N·m, `terms` the torque (J,) of each
    term, transforms included (they have no columns). M, C (J, J) and G (J,) belong to `rigid`.
    """

    t: Any
    q: Any
    dq: Any
    ddq: Any
    sign: Any
    base_motion: Any
    force: Any
    linear: Any
    shape: Any
    memory: Any
    columns: tuple[tuple[int, int, Any], ...]
    rigid: Any
    base: Any
    torque: Any
    terms: Mapping[str, Any]
    memories: tuple[MemorySignal, ...]
    M: Any
    C: Any
    G: Any
    J: Any
    reach: Any


def model_expressions(model: ModelStructure, symbols: Mapping[str, Any] | None = None) -> Expressions:
    """Return the model's equation of motion in CasADi; EffectError where a torque is not linear in a
    coefficient.

    With `symbols` it is one to be read rather than computed: Lagrange's for any number of joints, and with the SX
    symbols `a_th` and `g` among them for the leg's thigh length and gravity, which are numbers otherwise.
    """
    return _Builder(model, symbols).expressions()


class _Builder:
    """Collects symbols, columns and memories while walking over the terms once."""

    def __init__(self, model: ModelStructure, symbols: Mapping[str, Any] | None = None) -> None:
        import casadi

        self.ca = casadi
        self.model = model
        self.count = len(model.joints)
        self.state = {name: casadi.SX.sym(name) for name in self._state_names()}
        self.linear = casadi.SX.sym("linear", len(model.parameters))
        self.shape = casadi.SX.sym("shape", len(model.shapes))
        self.numbers = {p.name: self.linear[k] for k, p in enumerate(model.parameters)}
        self.numbers |= {s.name: self.shape[k] for k, s in enumerate(model.shapes)}
        self.place = {p.name: k for k, p in enumerate(model.parameters)}
        self.turned: list[Any] = []
        self.inputs: list[Any] = []
        self.memories: list[MemorySignal] = []
        self.columns: list[tuple[int, int, Any]] = []
        self.words: dict[str, Any] = dict(self.state)
        self.sizes = {"a_th": casadi.SX(model.thigh_length), "g": casadi.SX(model.gravity), **(symbols or {})}
        self.longest = LONGEST_SYMBOLIC if symbols is None else len(model.joints)

    def _state_names(self) -> tuple[str, ...]:
        return state_names(self.count, self.model.base_state, len(self.model.channels))

    def expressions(self) -> Expressions:
        ca = self.ca
        rigid_torque = self._rigid({**self.state, **self.numbers, **self.sizes})
        inertial = len(self.columns)
        for term in friction(self.model.joints):
            self._text(term, {"c": term.name})
        self._forces({**self.state, **self.numbers, **self.sizes})
        # In space the columns of a whole arm are many times longer than its torque.
        spatial = self.model.spatial
        base = rigid_torque + self._sum(self.columns[inertial:]) if spatial else self._sum(self.columns)
        for j in range(self.count):
            self.words |= {f"tau_rigid{j + 1}": rigid_torque[j], f"tau_model{j + 1}": base[j]}
        if any(uses_slopes(term) for term in self.model.terms):
            numbers = range(1, self.count + 1)
            for n in numbers:
                for state in STATES:
                    slope = ca.jacobian(rigid_torque, self.state[f"{state}{n}"])
                    self.words |= {f"tau{i}_by_{state}{n}": slope[i - 1] for i in numbers}
        torque, terms = base, {}
        plain, transforms = by_stage(self.model.terms)
        for term in plain:
            if term.effect.derive is not None:
                own = [entry for entry in self.columns if self._term_of(entry[1]) == term.name]
                terms[term.name] = self._sum(own)
            else:
                before = len(self.columns)
                self._text(term, {key: f"{term.name}.{key}" for key in term.effect.coefficients})
                terms[term.name] = self._sum(self.columns[before:])
                torque = torque + terms[term.name]
        self.words |= {f"tau_model{j + 1}": torque[j] for j in range(self.count)}
        for term in transforms:
            terms[term.name] = self._transform(term)
        for term in transforms:
            torque = torque + terms[term.name]
        return self._result(rigid_torque, base, torque, terms)

    def _term_of(self, parameter: int) -> str | None:
        """Return the term a column belongs to; None for one of the base model."""
        return self.model.parameters[parameter].term if parameter < len(self.model.parameters) else None

    def _sum(self, entries: list[tuple[int, int, Any]]) -> Any:
        total = self.ca.SX(self.count, 1)
        for joint, parameter, expression in entries:
            total[joint] += expression * (self.linear[parameter] if parameter < self.linear.numel() else 1.0)
        return total

    def _forces(self, symbols: dict[str, Any]) -> None:
        """Add the columns of measured forces, and, as one more than there are parameters, what needs no number."""
        model = self.model
        if not model.forces:
            return
        mechanism = replace(model.mechanism, leaning=real("base") if model.moving_base else 0)
        known: list[Any] = [self.ca.SX(0)] * self.count
        names, first = force_names(len(model.channels)), 0
        for force in model.forces:
            called = names[first : first + len(force.columns)]
            first += len(called)
            index = force.index(model.joints)
            if force.in_space:
                torques = space_force_torques(model.joints, self.turned, force, [self.state[item] for item in called])
                parts = [torques, [self.ca.SX(0)] * self.count]
            else:
                own = [real(name) for name in called]
                parts = [casadi_from_sympy(part, symbols) for part in force_torques(mechanism, force, index, own)]
            for joint, (origin, along) in enumerate(zip(*parts, strict=True)):
                at, gain = (None if isinstance(force.at, tuple) else force.at), force.gain
                origin, along = force.sign * origin, force.sign * along
                weights = {
                    f"{force.name}.at": (gain or 0.0) * along,
                    f"{force.name}.gain": origin + (0.0 if at is None else at * along),
                    f"{force.name}.gain_at": along,
                }
                for name in weights.keys() & self.place.keys():
                    if not (entry := self.ca.SX(weights[name])).is_zero():
                        self.columns.append((joint, self.place[name], entry))
                if gain is not None:
                    known[joint] = known[joint] + gain * (origin + (0.0 if at is None else at * along))
        count = len(model.parameters)
        self.columns += [(joint, count, entry) for joint, entry in enumerate(known) if not self.ca.SX(entry).is_zero()]

    def _rigid(self, symbols: dict[str, Any]) -> Any:
        if self.model.chain:
            return self._space(symbols) if self.model.spatial else self._tree(symbols)
        names, matrix = leg_columns(self.model.derived)
        for k, name in enumerate(names):
            for joint, value in enumerate(casadi_from_sympy(list(matrix[:, k]), symbols)):
                if matrix[joint, k] != 0:
                    self.columns.append((joint, self.place[name], value))
        jacobian = mechanics(self.model.mechanism).J
        self.reach = self.ca.SX.sym("reach")
        entries = casadi_from_sympy(list(jacobian), {**symbols, "reach": self.reach})
        self.jacobian = self.ca.reshape(self.ca.vertcat(*entries), 2, 2).T
        return self._sum(self.columns)

    def _tree(self, symbols: dict[str, Any]) -> Any:
        """Add the columns of a machine that is not the leg; what Lagrange gives is compared with Newton and Euler."""
        ca, model, joints = self.ca, self.model, self.model.chain
        q, dq, ddq = ([self.state[f"{stem}{k + 1}"] for k in range(self.count)] for stem in STEMS[:3])
        inertial, self.reach = len(model.inertial), ca.SX.sym("reach")
        base, aside, added, altered = STILL, [], [ca.SX(0)] * self.count, AS_THEY_ARE
        if model.derived:
            mechanism, torques_added, _ = changed(machine(joints), model.derived)
            changes = tree_changes(mechanism)
            q = [angle + more for angle, more in zip(q, casadi_from_sympy([*changes.offset], symbols), strict=True)]
            aside, lengths = (
                casadi_from_sympy([*some.values()], symbols) for some in (changes.moments, changes.lengths)
            )
            altered = AlteredLinks(tuple(changes.moments), dict(zip(changes.lengths, lengths, strict=True)))
            forward, downward = casadi_from_sympy([*changes.pull], symbols)
            base = BaseMotion(forward=forward, upward=downward - model.gravity)
            added = casadi_from_sympy([*torques_added], symbols)
        if model.moving_base:
            angle, rate, turning, ax, az = (self.state[name] for name in BASE_STATE)
            base = BaseMotion(angle, rate, turning, base.forward + ax, base.upward + az)
        found = tree_columns(joints, model.gravity, q, dq, ddq, base, altered, model.moving_base, self.longest)
        own = self._own_numbers()
        for p, column in enumerate(found[:inertial]):
            rest = [self._without(entry, own) for entry in column]
            self.columns += [(joint, p, entry) for joint, entry in enumerate(rest) if not entry.is_zero()]
        weights = [self.linear[p] for p in range(inertial)] + aside
        for joint in range(self.count):
            torque = added[joint]
            for weight, column in zip(weights, found, strict=True):
                torque += weight * column[joint]
            self._add_slopes(joint, torque, own)
        end = ca.vertcat(*point(joints, q, self.count - 1, self.reach, ca, base))
        self.jacobian = ca.jacobian(end, ca.vertcat(*(self.state[f"theta{k + 1}"] for k in range(self.count))))
        return self._sum(self.columns)

    def _space(self, symbols: dict[str, Any]) -> Any:
        """Add the columns of a spatial machine, Newton and Euler's; Lagrange confirms them."""
        ca, model, joints = self.ca, self.model, self.model.chain
        q, dq, ddq = ([self.state[f"{stem}{k + 1}"] for k in range(self.count)] for stem in STEMS[:3])
        added = [ca.SX(0)] * self.count
        angles, own = q, self._own_numbers()
        if model.derived:
            mechanism, torques_added, _ = changed(machine(joints), model.derived)
            offset = casadi_from_sympy(offset_changes(mechanism), symbols)
            q = [angle + more for angle, more in zip(q, offset, strict=True)]
            added = casadi_from_sympy([*torques_added], symbols)
        self.turned = q
        columns, rigid = spatial_columns(
            model, q, dq, ddq, self.linear, [self.state[name] for name in model.base_state]
        )
        first = len(self.columns)
        for p, column in enumerate(columns):
            rest = [self._without(entry, own) for entry in column]
            self.columns += [(joint, p, entry) for joint, entry in enumerate(rest) if not entry.is_zero()]
        for joint in range(self.count):
            self._add_slopes(joint, rigid[joint] + added[joint], own)
        self.reach = ca.SX.sym("reach")
        self.jacobian = ca.jacobian(ca.vertcat(*end_point(joints, q, self.reach, ca)), ca.vertcat(*angles))
        slopes = [entry for entry in self.columns[first:] if entry[1] >= len(columns)]
        return ca.vertcat(*(self._without(entry, own) for entry in rigid)) + self._sum(slopes)

    def _own_numbers(self) -> list[Any]:
        """Return the linear numbers of the terms that change the mechanism."""
        own = {term.name for term in self.model.derived}
        return [self.numbers[p.name] for p in self.model.parameters if p.term in own]

    def _without(self, expression: Any, symbols: list[Any]) -> Any:
        """Return an expression with `symbols` at zero."""
        if not symbols:
            return expression
        zeros = self.ca.SX.zeros(len(symbols))
        return self.ca.simplify(self.ca.substitute(expression, self.ca.vertcat(*symbols), zeros))

    def _add_slopes(self, joint: int, torque: Any, own: list[Any]) -> None:
        """Add the columns of numbers that change the mechanism: ∂τ/∂k with later ones at zero, so that products of two
        count once.
        """
        ca = self.ca
        for k, symbol in enumerate(own):
            slope = self._without(ca.jacobian(self._without(torque, own[k + 1 :]), symbol), [])
            parameter = next(p for p in range(len(self.model.parameters)) if ca.is_equal(self.linear[p], symbol))
            if ca.depends_on(slope, symbol):
                what = f"the torque is not linear in {self.model.parameters[parameter].name}"
                remedy = "declare it as a shape with bounds instead of a coefficient"
                raise EffectError(what, where=str(self.model.parameters[parameter].term), remedy=remedy)
            if not ca.SX(slope).is_zero():
                self.columns.append((joint, parameter, ca.SX(slope)))

    def _text(self, term: Term, names: Mapping[str, str]) -> None:
        """Add the columns of a text: its derivative by each coefficient, in which `check_effect` found it linear."""
        local = symbols_of(term)
        for torque in torques(term):
            form, words = self._lowered(term, torque)
            for key, full in names.items():
                slope = form.diff(local[key])
                if slope != 0:
                    self.columns.append((torque.joint, self.place[full], casadi_from_sympy([slope], words)[0]))

    def _transform(self, term: Term) -> Any:
        total = self.ca.SX(self.count, 1)
        for torque in torques(term):
            form, words = self._lowered(term, torque)
            total[torque.joint] += casadi_from_sympy([form], words)[0]
        return total

    def _lowered(self, term: Term, torque: Any) -> tuple[Any, dict[str, Any]]:
        """Return the text in SymPy, and the CasADi symbol behind each of its words; operators become
        memories.
        """
        local = symbols_of(term)
        words = {
            **self.words,
            **{s.name: self.numbers[s.name] for s in local.values() if s.name in self.numbers},
        }
        shapes = {key: self.numbers[f"{term.name}.{key}"] for key in term.effect.shape}
        node, operations = split_memory(torque.node, len(self.memories))
        for operation in operations:
            inside = {**words, **shapes}
            argument = to_casadi(operation.argument, inside)
            parameter = None if operation.parameter is None else to_casadi(operation.parameter, inside)
            self.memories.append(MemorySignal(operation.operator, argument, parameter))
            signal = self.ca.SX.sym(operation.name)
            self.inputs.append(signal)
            words[operation.name] = self.words[operation.name] = signal
        symbols = {name: real(name) for name in words}
        return to_sympy(node, {**symbols, **local}), words

    def _result(self, rigid_torque: Any, base: Any, torque: Any, terms: dict[str, Any]) -> Expressions:
        ca = self.ca
        q, dq, ddq, sign = (ca.vertcat(*(self.state[f"{s}{k + 1}"] for k in range(self.count))) for s in STEMS)
        rest = ca.SX.zeros(self.count)
        still = ca.substitute(rigid_torque, ddq, rest)
        mass = ca.jacobian(rigid_torque, ddq)
        slopes = [ca.reshape(ca.jacobian(ca.vec(mass), angle), mass.shape) for angle in ca.vertsplit(q)]
        return Expressions(
            t=self.state["t"],
            q=q,
            dq=dq,
            ddq=ddq,
            sign=sign,
            base_motion=ca.vertcat(ca.SX(0, 1), *(self.state[n] for n in self.model.base_state)),
            force=ca.vertcat(ca.SX(0, 1), *(self.state[n] for n in force_names(len(self.model.channels)))),
            linear=self.linear,
            shape=self.shape,
            memory=ca.vertcat(ca.SX(0, 1), *self.inputs),
            columns=tuple(self.columns),
            rigid=rigid_torque,
            base=base,
            torque=torque,
            terms=MappingProxyType(terms),
            memories=tuple(self.memories),
            M=mass,
            C=ca.blockcat(christoffel(slopes, ca.vertsplit(dq), 0.5)),
            G=ca.substitute(still, dq, rest),
            J=self.jacobian,
            reach=self.reach,
        )
