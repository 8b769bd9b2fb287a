"""Information in periodic motions: Σ over samples of YᵀY, for a whole population of Fourier motions at once, in C.

    θ_i = θ_i0 + f_i Σ_k a_ik sin(kωt) + b_ik cos(kωt),        G_j = Σ_n y_jn y_jnᵀ / N

y_jn (M,) is the derivative of joint j's torque at sample n by every number of the model: the regressor's row for a
model that is linear in its numbers, with one more entry per shape parameter where there are some. CasADi derives
the products of one sample, a loop over the grid sums them, and the compiler vectorises it. What bounds the motion (f)
is found in the same pass, because it needs the same angles.
"""

from __future__ import annotations

import ctypes
from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np

from exoid.symbolic.codegen.cache import CompiledLibrary, load_library
from exoid.symbolic.codegen.compiler import FAST
from exoid.symbolic.codegen.fingerprint import model_data
from exoid.symbolic.codegen.information_code import Entries, information_code, sensitivity_function
from exoid.symbolic.columns import model_columns, model_torque, needs_reference
from exoid.symbolic.memory import memory_operations
from exoid.symbolic.motion import Float, Motion

if TYPE_CHECKING:
    from exoid.symbolic.model_structure import ModelStructure


@dataclass(frozen=True, eq=False)
class Sums:
    """For I motions: `gram` (I, J, M, M), and `factor` (I, J) by which each swing may grow until it meets a limit."""

    gram: Float
    factor: Float


@dataclass(frozen=True, eq=False)
class Information:
    """The sums of one `model` at its numbers `linear` (P,), `shape` (S,), over a `grid` of one `period` (s).

    `names` (M,) are the numbers, `rates` (K,) the harmonics' kω in rad/s, `limits` (J, 4) what a motion may reach: low
    and high angle, speed, acceleration.
    """

    model: ModelStructure
    names: tuple[str, ...]
    linear: Float
    shape: Float
    period: float
    grid: int
    rates: Float
    limits: Float
    library: CompiledLibrary | None
    entries: Entries
    pointwise: bool
    """Whether an instant tells the torque: no operator needs the motion's past."""

    @property
    def backend(self) -> str:
        """Return "c", "vm" for CasADi's virtual machine, or "python" where operators need a motion's past."""
        return "c" if self.library is not None else "vm" if self.pointwise else "python"

    @property
    def times(self) -> Float:
        """The grid (N,) in s, one period without its end."""
        return np.asarray(np.arange(self.grid) * (self.period / self.grid), dtype=float)

    def sums(self, swings: Any, offsets: Any, *, rescale: bool, doublings: int = 0) -> Sums:
        """Return the sums of motions with `swings` (I, J, 2K: sines, then cosines) about `offsets` (I, J) in rad.

        `rescale` stretches or shrinks every swing to the first limit it meets, before the sums are made. With
        `doublings` the largest use of a limit is replaced by the norm of order 2^doublings over all samples and limits,
        which has no kinks where another sample becomes the largest (and may leave the limits a little).
        """
        swing = np.ascontiguousarray(swings, dtype=float)
        centre = np.ascontiguousarray(offsets, dtype=float)
        wanted = (len(centre), len(self.limits), 2 * len(self.rates))
        if swing.shape != wanted or centre.shape != wanted[:2]:
            raise ValueError(f"swings {swing.shape} and offsets {centre.shape} do not fit, expected {wanted}")
        if self.library is None:
            return self._slowly(swing, centre, rescale, doublings)
        return self._in_c(self.library.c, swing, centre, rescale, doublings)

    def _in_c(self, library: ctypes.CDLL, swing: Float, centre: Float, rescale: bool, doublings: int) -> Sums:
        count, size = len(swing), len(self.names)
        factor, packed = np.empty((count, len(self.limits))), np.zeros((count, len(self.entries)))
        angle = np.outer(self.rates, self.times)
        table = np.ascontiguousarray(np.concatenate([np.sin(angle), np.cos(angle)]))
        numbers = np.concatenate([self.linear, self.shape])
        scratch = np.empty(3 * len(self.limits) * self.grid)
        arrays = (self.times, table, self.rates, swing, centre, self.limits, numbers, scratch, factor, packed)
        held = [np.ascontiguousarray(a) for a in arrays]
        library.exoid_gram(
            ctypes.c_long(count), ctypes.c_long(self.grid), ctypes.c_int(int(rescale)), ctypes.c_int(doublings),
            *(a.ctypes.data_as(_DOUBLES) for a in held),
        )  # fmt: skip
        gram = np.zeros((count, len(self.limits), size, size))
        for k, (joint, p, r) in enumerate(self.entries):
            gram[:, joint, p, r] = gram[:, joint, r, p] = held[-1][:, k]
        return Sums(gram / self.grid, held[-2])

    def _slowly(self, swing: Float, centre: Float, rescale: bool, doublings: int) -> Sums:
        """Do the same in NumPy, one motion at a time."""
        angle = np.outer(self.times, self.rates)
        sine, cosine, count = np.sin(angle), np.cos(angle), len(self.rates)
        factors, grams = [], []
        for item, about in zip(swing, centre, strict=True):
            a, b = item[:, :count].T, item[:, count:].T
            rate = self.rates[:, None]
            swung = sine @ a + cosine @ b
            speed = cosine @ (rate * a) - sine @ (rate * b)
            pull = -sine @ (rate**2 * a) - cosine @ (rate**2 * b)
            factor = largest_factor(swung, speed, pull, about, self.limits)
            if doublings:
                factor = _softer(factor, swung, speed, pull, about, self.limits, doublings)
            scale = factor if rescale else np.ones(len(self.limits))
            q, dq, ddq = about + scale * swung, scale * speed, scale * pull
            grams.append(self._gram(q, dq, ddq))
            factors.append(factor)
        return Sums(np.array(grams), np.array(factors))

    def _gram(self, q: Float, dq: Float, ddq: Float) -> Float:
        """Return the sums (J, M, M) of one motion, a sample with a reversal in its cell counted with both signs."""
        sign = mean_sign(dq, ddq, self.period / self.grid)
        joints = len(self.limits)
        out = np.zeros((joints, len(self.names), len(self.names)))
        if not self.pointwise:  # an operator's past cannot be cut into cells
            rows = self.sensitivities(Motion(self.times, q, dq, ddq))
            return np.asarray(np.einsum("jnp,jnr->jpr", rows, rows) / self.grid)
        for way in product((1.0, -1.0), repeat=joints):
            weight = 0.5**joints * np.prod(1.0 + np.array(way) * sign, axis=1)
            live = weight > 0.0
            if live.any():
                signs = np.tile(way, (int(live.sum()), 1))
                rows = self.sensitivities(Motion(self.times[live], q[live], dq[live], ddq[live], signs))
                out += np.einsum("jnp,jnr,n->jpr", rows, rows, weight[live])
        return out / self.grid

    def sensitivities(self, motion: Motion) -> Float:
        """Return the derivatives (J, N, M) of the torque along `motion` by every number."""
        if not self.pointwise:
            return central_differences(self.model, motion, self.linear, self.shape)
        return _evaluated(sensitivity_function(self.model), motion, self.linear, self.shape, len(self.names))


_DOUBLES = ctypes.POINTER(ctypes.c_double)


def information(
    model: ModelStructure,
    linear: Any,
    shape: Any,
    limits: Any,
    *,
    period: float,
    harmonics: int,
    grid: int,
    backend: str = "auto",
) -> Information:
    """Information matrices of `model` for motions of `period` s; arguments as in Information.

    `backend` "auto" takes C where there is a compiler and the model has no operator with memory; "vm" never does.
    """
    names = number_names(model)
    rates = np.asarray(np.arange(1, harmonics + 1) * (2.0 * np.pi / period), dtype=float)
    linear, shape = np.asarray(linear, dtype=float), np.asarray(shape, dtype=float)
    library: CompiledLibrary | None = None
    entries: Entries = ()
    pointwise = not memory_operations(model)
    if pointwise and backend == "auto":
        content = [model_data(model), harmonics]
        library = load_library("gram", content, FAST, lambda: information_code(model, harmonics), ("exoid_gram",))
    if library is not None:
        entries = tuple((int(j), int(p), int(r)) for j, p, r in library.record["entries"])
    return Information(
        model, names, linear, shape, float(period), int(grid), rates, np.asarray(limits, dtype=float), library, entries,
        pointwise,
    )  # fmt: skip


def number_names(model: ModelStructure) -> tuple[str, ...]:
    """Return the names (M,) of what a motion can inform about: parameters, then shapes that are not choices."""
    return tuple(p.name for p in model.parameters) + tuple(s.name for s in model.shapes if not s.shape.choices)


def _evaluated(function: Any, motion: Motion, linear: Float, shape: Float, size: int) -> Float:
    state = np.column_stack([motion.t, motion.q, motion.dq, motion.ddq, motion.sign]).T
    values = np.asarray(function(state, np.concatenate([linear, shape])))
    return values.reshape(motion.q.shape[1], len(motion), size)


def central_differences(model: ModelStructure, motion: Motion, linear: Float, shape: Float) -> Float:
    """Return the derivatives (J, N, M) of the torque by central differences, for models whose operators have a past."""
    at = np.concatenate([linear, shape])
    count = len(linear)
    places = [*range(count), *(count + k for k, s in enumerate(model.shapes) if not s.shape.choices)]
    typical = [max(abs(v), abs(p.typical or 1.0)) for v, p in zip(linear, model.parameters, strict=True)]
    steps = [1e-5 * size for size in typical] + [1e-4 * (s.shape.max - s.shape.min) for s in model.shapes]
    if not needs_reference(model):
        out = [*np.moveaxis(model_columns(model, motion, shape), 2, 0)]
        places = places[count:]
    else:
        out = []
    for place in places:
        sides = []
        for sign in (1.0, -1.0):
            values = at.copy()
            values[place] += sign * steps[place]
            sides.append(model_torque(model, motion, values[:count], values[count:]).T)
        out.append((sides[0] - sides[1]) / (2.0 * steps[place]))
    return np.stack(out, axis=2)


def mean_sign(dq: Float, ddq: Float, step: float) -> Float:
    """Return the sign (N, J) of a velocity averaged over each sample's own `step` s: at a reversal it passes zero.

    The sums then change smoothly with the motion, and are closer to what faster sampling would give.
    """
    return np.clip(dq / np.maximum(0.5 * step * np.abs(ddq), 1e-300), -1.0, 1.0)


def largest_factor(swung: Float, speed: Float, pull: Float, centre: Float, limits: Float) -> Float:
    """Return the factor (J,) that brings each swing to the first limit it meets; 0 where the centre is outside."""
    low, high, fastest, strongest = limits.T
    up, down = np.maximum(swung.max(axis=0), 0.0), np.maximum(-swung.min(axis=0), 0.0)
    rooms = np.array([high - centre, centre - low, fastest, strongest])
    uses = np.array([up, down, np.abs(speed).max(axis=0), np.abs(pull).max(axis=0)])
    ratio = np.maximum(rooms, 0.0) / np.maximum(uses, 1e-300)
    return np.asarray(np.minimum(ratio.min(axis=0), 1e300))


def _softer(
    factor: Float, swung: Float, speed: Float, pull: Float, centre: Float, limits: Float, doublings: int
) -> Float:
    """Return the factor (J,) that brings the norm of all uses of the limits to one, from the `largest_factor`."""
    low, high, fastest, strongest = limits.T
    scale = np.minimum(factor, 1e200)  # without a swing nothing is met
    room = np.maximum(np.where(swung > 0.0, high - centre, centre - low), 1e-300)
    uses = scale * np.array([swung / room, speed / fastest, pull / strongest])
    order = 2**doublings
    norm = np.maximum((np.abs(uses) ** order).mean(axis=1).sum(axis=0), 1e-300) ** (1.0 / order)
    return np.where(factor > 1e200, factor, factor / norm)
