"""Compiled models: regressor, inverse and forward dynamics, M, C, G and J at the speed of C.

The first use derives, generates and compiles; later ones load the library from the cache, without SymPy or
CasADi. Without a compiler the same CasADi functions run in CasADi's virtual machine.
"""

from __future__ import annotations

from ctypes import c_long, c_void_p
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from exoid.ground.errors import ExpressionError
from exoid.symbolic.codegen.cache import CompiledLibrary, GeneratedC, load_library
from exoid.symbolic.codegen.compiler import EXACT
from exoid.symbolic.codegen.fingerprint import equations_key, model_data
from exoid.symbolic.codegen.layout import widths
from exoid.symbolic.evaluation import apply_transforms, column_count, forces_of, vector
from exoid.symbolic.memory import memory_operations, memory_signals
from exoid.symbolic.motion import Float, Motion

if TYPE_CHECKING:
    from exoid.symbolic.model_structure import ModelStructure


@dataclass(frozen=True, eq=False)
class Compiled:
    """A model that runs fast; `entries` are the (joint, parameter) of its columns that are not zero."""

    model: ModelStructure
    entries: tuple[tuple[int, int], ...]
    needs_reference: bool
    library: CompiledLibrary | None
    machine: dict[str, Any]

    @property
    def backend(self) -> str:
        """Return "c", or "vm" for CasADi's virtual machine."""
        return "vm" if self.library is None else "c"

    def columns(self, motion: Motion, shape: Float | None = None, reference: Float | None = None) -> Float:
        """Return the regressor (J, N, P); arguments and refusals (ExpressionError) as of Model.columns."""
        shapes = vector(shape, self.model.typical_shape, "shape")
        linear = vector(reference, np.zeros(len(self.model.parameters)), "reference")
        out = self.pointwise(motion, linear, shapes, self._memory(motion, linear, shapes))
        apply_transforms(self.model, out, shapes, motion)
        self._refuse_what_is_not_finite(out)
        return out[:, :, : len(self.model.parameters)]

    def _refuse_what_is_not_finite(self, columns: Float) -> None:
        """Refuse as NumPy does (lower.py): C would hand on an infinity."""
        if np.isfinite(columns.sum()) or np.isfinite(columns).all():
            return
        joint, sample, parameter = (int(k) for k in np.argwhere(~np.isfinite(columns))[0])
        raise ExpressionError(
            f"the torque is not a finite number at sample {sample}",
            where=f"{self.model.parameters[parameter].name} at the {self.model.joint_names[joint]}",
            remedy="keep log, sqrt, exp and / away from where they have no value, for example with max(...)",
        )

    def inverse_dynamics(self, motion: Motion, linear: Any, shape: Float | None = None) -> Float:
        """Return the torque (N, J) in N·m that `motion` takes, for linear parameters (P,)."""
        values, shapes = self._numbers(linear, shape)
        memory = self._memory(motion, values, shapes)
        return self._run("inverse_dynamics", self._state(motion), values, shapes, memory, None)

    def forward_dynamics(
        self, motion: Motion, tau: Any, linear: Any, shape: Float | None = None, memory: Any = None
    ) -> Float:
        """Return the acceleration (N, J) in rad/s² under torque `tau` (N, J) at the states of `motion`.

        Its own accelerations are not used. `memory` (N, K) are values of the operators with memory, which
        states that need not follow each other cannot supply (default: zero).
        """
        values, shapes = self._numbers(linear, shape)
        whole = len(motion), len(self.model.joints)
        torque = np.ascontiguousarray(np.broadcast_to(np.asarray(tau, dtype=float), whole))
        signals = None if memory is None else np.ascontiguousarray(memory, dtype=float)
        return self._run("forward_dynamics", self._state(motion), values, shapes, signals, torque)

    def mass_matrix(self, motion: Motion, linear: Any, shape: Float | None = None) -> Float:
        """Return M (N, J, J) of the rigid leg."""
        return self._matrix("mass_matrix", motion, linear, shape)

    def coriolis(self, motion: Motion, linear: Any, shape: Float | None = None) -> Float:
        """Return the Christoffel C (N, J, J) of the rigid leg."""
        return self._matrix("coriolis", motion, linear, shape)

    def gravity(self, motion: Motion, linear: Any, shape: Float | None = None) -> Float:
        """Return G (N, J) of the rigid leg, N·m."""
        values, shapes = self._numbers(linear, shape)
        return self._run("gravity", self._state(motion), values, shapes, None, None)

    def jacobian(self, motion: Motion, reach: float, shape: Float | None = None) -> Float:
        """Return J (N, 2, J) of the point `reach` m down the last link (rows: forward, upward); of a spatial machine
        (N, 3, J) of the point `reach` m from the last joint's origin along its axis, in the frame of the base.
        """
        return self._matrix("jacobian", motion, np.zeros(len(self.model.parameters)), shape, float(reach))

    def pointwise(self, motion: Motion, linear: Float, shape: Float, memory: Float | None = None) -> Float:
        """Return the columns (J, N, P) without transforms, the operators with memory at `memory` (N, K) or zero; one
        more, (J, N, P + 1), where the model has measured forces: what they make without a number.
        """
        values = self._run("columns", self._state(motion), linear, shape, memory, None)
        out = np.zeros((len(self.model.joints), len(motion), column_count(self.model)))
        for k, (joint, parameter) in enumerate(self.entries):
            out[joint, :, parameter] += values[:, k]
        return out

    def columns_at(self, motion: Motion, linear: Float, shapes: Float, first: int) -> Float:
        """Return the columns of `pointwise` at each of `shapes` (V, S), time last and from parameter `first` on: (V, J,
        P - first, N).
        """
        state, memory = self._state(motion), np.zeros((len(motion), len(memory_operations(self.model))))
        out = np.zeros((len(shapes), len(self.model.joints), len(self.model.parameters) - first, len(motion)))
        for columns, shape in zip(out, shapes, strict=True):
            values = self._run("columns", state, linear, shape, memory, None)
            for k, (joint, parameter) in enumerate(self.entries):
                if first <= parameter < len(self.model.parameters):
                    columns[joint, parameter - first] += values[:, k]
        return out

    def _state(self, motion: Motion) -> Float:
        state = [motion.t, motion.q, motion.dq, motion.ddq, motion.sign]
        if self.model.moving_base:
            width = len(self.model.base_state)
            state.append(np.zeros((len(motion), width)) if motion.base is None else motion.base)
        if pushed := len(self.model.channels):
            state.append(forces_of(motion, pushed))
        return np.column_stack(state)

    def _matrix(self, name: str, motion: Motion, linear: Any, shape: Any, extra: float | None = None) -> Float:
        values, shapes = self._numbers(linear, shape)
        given = None if extra is None else np.full((len(motion), 1), extra)
        flat = self._run(name, self._state(motion), values, shapes, None, given)
        count = len(self.model.joints)
        return np.ascontiguousarray(flat.reshape(len(motion), count, -1).transpose(0, 2, 1))

    def _numbers(self, linear: Any, shape: Float | None) -> tuple[Float, Float]:
        default = np.zeros(len(self.model.parameters))
        return vector(linear, default, "linear"), vector(shape, self.model.typical_shape, "shape")

    def _memory(self, motion: Motion, linear: Float, shapes: Float) -> Float | None:
        return memory_signals(self.model, motion, shapes, linear, partial(self.pointwise, motion, linear, shapes))

    def _run(
        self, name: str, state: Float, linear: Float, shape: Float, memory: Float | None, extra: Float | None
    ) -> Float:
        """Evaluate one function at all samples; the result is (N, width)."""
        size = len(self.entries) if name == "columns" else widths(len(self.model.joints), self.model.spatial)[name]
        out = np.zeros((len(state), size))
        if not out.size:
            return out
        if memory is None:
            memory = np.zeros((len(state), len(memory_operations(self.model))))
        if self.library is not None:
            arrays = [np.ascontiguousarray(a) for a in (state, linear, shape, memory)]
            given = [None if a is None or not a.size else c_void_p(a.ctypes.data) for a in (*arrays, extra, out)]
            self.library.c[f"leg_{name}_many"](c_long(len(state)), *given)
            return out
        inputs = [state.T, linear, shape, memory.T, *([] if extra is None else [extra.T])]
        return np.ascontiguousarray(np.asarray(self.machine[name](*inputs)).T)


_RECENT: dict[tuple[str, str], Compiled] = {}


def compiled(model: ModelStructure, backend: str = "auto") -> Compiled:
    """Return the compiled form of `model`; `backend` "auto" takes C where there is a compiler, "vm" never
    does.
    """
    key = (equations_key(model), backend)
    if key not in _RECENT:
        while len(_RECENT) >= 128:
            _RECENT.pop(next(iter(_RECENT)))
        _RECENT[key] = _make(model, backend)
    found = _RECENT[key]
    return found if found.model is model else replace(found, model=model)


def _make(model: ModelStructure, backend: str) -> Compiled:
    library = None
    if backend != "vm":
        names = (f"leg_{name}_many" for name in ("columns", *widths(len(model.joints), model.spatial)))
        library = load_library("model", model_data(model), EXACT, lambda: _source(model), names)
    if library is not None:
        entries = tuple((int(j), int(p)) for j, p in library.record["entries"])
        return Compiled(model, entries, bool(library.record["needs_reference"]), library, {})
    from exoid.symbolic.codegen.code import functions, reference_needed
    from exoid.symbolic.codegen.equation import model_expressions

    expressions = model_expressions(model)
    entries = tuple((j, p) for j, p, _ in expressions.columns)
    return Compiled(model, entries, reference_needed(expressions), None, functions(expressions))


def _source(model: ModelStructure) -> GeneratedC:
    from exoid.symbolic.codegen.code import generate

    made = generate(model)
    record = {"entries": made.entries, "needs_reference": made.needs_reference}
    return GeneratedC(made.code, EXACT, record)
