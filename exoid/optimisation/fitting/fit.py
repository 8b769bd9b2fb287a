"""Result of an identification: numbers with units, intervals, proof, and what to be careful about."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from exoid.ground.frames import pandas
from exoid.ground.html import bullets, lines, picture, table
from exoid.ground.plain import AsJson, by_name
from exoid.measurement.finding import Finding
from exoid.optimisation.fitting.plots import fit_figure
from exoid.optimisation.linear.certificate import Certificate
from exoid.optimisation.linear.physical import Held
from exoid.optimisation.linear.problem import LinearData
from exoid.optimisation.linear.reference import Reference
from exoid.optimisation.optimiser import OptimiserRun
from exoid.symbolic.joints import Joint, names, units
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Float
from exoid.symbolic.quantity import Estimate

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure


@dataclass(frozen=True, eq=False)
class FitStage(AsJson):
    """One of the two stages ("sse", "huber"): parameters, loss, the optimisers' runs, IPOPT, the proof."""

    kind: str
    linear: Float
    shape: Float
    delta: Float
    loss: float
    runs: Mapping[str, OptimiserRun]
    reference: Reference | None
    certificate: Certificate

    def _json(self) -> dict[str, Any]:
        return {
            "kind": self.kind, "parameters": self.linear, "shape": self.shape, "delta": self.delta, "loss": self.loss,
            "runs": self.runs, "reference": self.reference, "certificate": self.certificate,
        }  # fmt: skip


@dataclass(frozen=True, eq=False)
class Fit(AsJson):
    """An identified model.

    `estimates` are the linear parameters (`linear`, (P,)), then the shape parameters (`shape`, (S,)), with 95 %
    intervals valid under autocorrelated residuals. `shapes` (R, S) are the shape parameters of each recording, which
    differ only where a shape belongs to the recording (`Shape.per_recording`). `delta`, `rms` (J,) in N·m; the
    `loss` counts the misses of each joint times its `weight` (J,).
    `best_known` says that shape parameters were searched, so that only the linear part carries a proof.
    `plausibility` is what to be careful about. `held` says what asking for a possible machine changed; None where
    nobody asked for one. `agreeing`: how many local searches of the shapes ended at the same loss, and how many there
    were.
    `spacing`: s between samples.
    """

    INSTEAD: ClassVar[Mapping[str, str]] = {"parameters": "fit.estimates, fit.to_frame(), fit.to_json()['parameters']"}

    model: Model
    estimates: tuple[Estimate, ...]
    linear: Float
    shape: Float
    shapes: Float = field(repr=False)
    delta: Float
    weight: Float
    rms: Float
    loss: float
    runs: Mapping[str, OptimiserRun]
    reference: Reference | None
    certificate: Certificate
    plausibility: tuple[Finding, ...]
    sse: FitStage
    data: LinearData = field(repr=False)
    covariance: Float = field(repr=False)
    best_known: bool
    lag: int
    seconds: float
    recordings: tuple[str, ...]
    held: Held | None = None
    agreeing: tuple[int, int] | None = None
    spacing: float = 1.0

    @property
    def joints(self) -> tuple[Joint, ...]:
        """Joints of the machine (J,), in the order of every axis of length J."""
        return tuple(self.model.joints)

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the joints (J,)."""
        return names(self.joints)

    @property
    def limits(self) -> Float:
        """Thresholds (J,) of the Huber loss for weighted misses."""
        return self.delta * self.weight

    @property
    def residual(self) -> Float:
        """Residual torque (J, N), N·m; zero where a sample was not used."""
        return self.data.residual(self.linear)

    @property
    def shapes_known(self) -> str:
        """Certainty of the shape parameters, in words; empty for a model without any."""
        if not self.best_known:
            return ""
        text = "shape parameters: best known of a wide and of local searches, not proven"
        return text if self.agreeing is None else f"{text}; {self.agreeing[0]} of {self.agreeing[1]} starts agree"

    @property
    def start(self) -> Float | None:
        """Start of a fit of the same model to other versions of the recordings: shape values (S,), (R, S) where
        recordings have their own; None for a model without any.
        """
        own = any(entry.shape.per_recording for entry in self.model.shapes)
        return (self.shapes if own else self.shape) if self.model.shapes else None

    def estimate(self, name: str) -> Estimate:
        """Return the estimate called `name`."""
        return {e.name: e for e in self.estimates}[name]

    def __repr__(self) -> str:
        where = ", ".join(self.recordings)
        lines = [f"Fit of {self.model.name!r} to {where}"]
        width = max(len(e.name) for e in self.estimates)
        for e in self.estimates:
            lines.append(f"  {e.name:<{width}}  {e.value:>11.5g} {e.unit:<12} 95 % {e.low:.4g} to {e.high:.4g}")
        rms = ", ".join(f"{joint} {value:.4g}" for joint, value in zip(self.joint_names, self.rms, strict=True))
        unit = units(self.joints, "tau")
        lines.append(f"  rms residual [{unit}]: {rms};  Huber loss {self.loss:.6g}, {self.certificate}")
        if self.best_known:
            lines.append(f"  {self.shapes_known}")
        for name, run in self.runs.items():
            lines.append(f"  {name}: relative gap {run.gap:.1e}, {run.evaluations} evaluations, {run.seconds:.2f} s")
        if self.reference is not None:
            r = self.reference
            lines.append(f"  IPOPT: relative gap {r.gap:.1e}, {r.iterations} iterations, {r.seconds:.2f} s, {r.status}")
        lines += [f"  caution, {caution}" for caution in self.plausibility]
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        first = map(float, (*self.sse.linear, *self.sse.shape))
        rows = [(e.name, e.value, e.unit, e.low, e.high, s) for e, s in zip(self.estimates, first, strict=True)]
        rms = ", ".join(f"{joint} {value:.4g}" for joint, value in zip(self.joint_names, self.rms, strict=True))
        gaps = [(name, run.gap, run.evaluations, run.seconds) for name, run in self.runs.items()]
        if self.reference is not None:
            gaps.append(("IPOPT", self.reference.gap, self.reference.iterations, self.reference.seconds))
        head = ("optimiser", "relative gap", "evaluations or iterations", "seconds")
        return (
            table(("parameter", "value", "unit", "95 % low", "95 % high", "SSE"), rows)
            + lines(f"RMS residual [{units(self.joints, 'tau')}]: {rms}", str(self.certificate))
            + (table(head, gaps) if gaps else "")
            + bullets(self.plausibility)
            + picture(self.plot(), f"Parameters with intervals, residuals and convergence; RMS residual {rms}")
        )

    def to_frame(self) -> pd.DataFrame:
        """Return one row per parameter: value, unit, 95 % interval, value of the SSE stage."""
        first = [*self.sse.linear, *self.sse.shape]
        rows = [(e.value, e.unit, e.low, e.high, s) for e, s in zip(self.estimates, first, strict=True)]
        names = [e.name for e in self.estimates]
        return pandas().DataFrame(rows, index=names, columns=["value", "unit", "low", "high", "sse"])

    def plot(self) -> Figure:
        """Draw parameters with intervals, residuals, and the convergence of the optimisers."""
        used = list(zip(self.data.tau, self.residual, self.data.use, strict=True))
        return fit_figure(
            joints=self.joints,
            t=[np.asarray(self.spacing * np.flatnonzero(use), float) for _, _, use in used],
            torque=[tau[use] for tau, _, use in used],
            residual=[residual[use] for _, residual, use in used],
            delta=self.delta,
            estimates=self.estimates,
            runs={name: (run.counts, run.history) for name, run in self.runs.items()},
            optimum=self.certificate.primal,
            tolerance=self.certificate.tolerance,
        )

    def _json(self) -> dict[str, Any]:
        return {
            "model": self.model.name, "recordings": self.recordings, "joints": self.joint_names,
            "parameters": by_name(self.estimates), "delta": self.delta, "weight": self.weight, "rms": self.rms,
            "loss": self.loss, "best_known": self.best_known, "starts_agreeing": self.agreeing, "runs": self.runs,
            "reference": self.reference, "certificate": self.certificate, "sse": self.sse,
            "plausibility": self.plausibility, "physical": self.held, "seconds": self.seconds,
        }  # fmt: skip
