"""Results as the packages below hand them over, made by hand: the workbench is tested without running them."""

from __future__ import annotations

from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any

import numpy as np

from exoid.diagnosis.comparison import Comparison
from exoid.diagnosis.evidence.power import Power
from exoid.diagnosis.results import Diagnosis, Step
from exoid.ground.figures import figure_style, joint_colours, label, new_figure
from exoid.measurement.finding import Finding
from exoid.measurement.recording import Recording, Source
from exoid.symbolic.joints import LEG
from exoid.symbolic.quantity import Estimate

HOSTILE = "<script>alert('x')</script> & \"quotes\""
"""Text that would break a page which forgets to escape."""


def recording(name: str = "run_0", findings: tuple[Finding, ...] = ()) -> Recording:
    t = np.arange(0.0, 2.0, 0.01)
    q = np.column_stack([np.sin(t), np.cos(t)])
    return Recording(name, t, q, 10 * q, source=Source(f"/data/{name}.csv", "ab" * 32), findings=findings)


FINDINGS = (
    Finding("clock", "warning", "12 samples are missing", where="run_0.csv rows 40-52", remedy="check the logger"),
    Finding("name", "info", f"the file's title is {HOSTILE}", where="run_0.csv"),
)


def figure(points: int = 200) -> Any:
    t = np.linspace(0.0, 10.0, points)
    with figure_style():
        drawn = new_figure(7, 3.6)
        axes = drawn.subplots()
        colours = joint_colours(["hip", "knee"])
        axes.plot(t, np.sin(2 * t), color=colours["hip"], label="hip")
        axes.plot(t, np.cos(3 * t), color=colours["knee"], label="knee")
        axes.set(xlabel=label("time", "s"), ylabel=label("residual", "N·m"), title="Residual over time")
        axes.legend()
    return drawn


@dataclass(frozen=True, eq=False)
class FakeModel:
    name: str = "standard leg"
    joints: tuple[Any, ...] = LEG
    joint_names: tuple[str, ...] = ("hip", "knee")
    parameters: tuple[Any, ...] = (SimpleNamespace(name="Phi1", label="inertia Φ1", unit="kg·m²"),)
    shapes: tuple[Any, ...] = ()
    terms: tuple[Any, ...] = (
        SimpleNamespace(name="stribeck:knee", effect=SimpleNamespace(id="stribeck", title="Stribeck"), joint="knee"),
    )


@dataclass(frozen=True, eq=False)
class FakeFit:
    model: Any = field(default_factory=FakeModel)
    joints: tuple[Any, ...] = LEG
    estimates: tuple[Estimate, ...] = (
        Estimate("Phi1", 25.14, "kg·m²", 24.9, 25.4),
        Estimate("viscous:knee", -5.89, "N·m·s/rad", -7.0, -4.8),
        Estimate("stribeck:knee.c", 2.6, "N·m", 2.2, float("inf")),
    )
    rms: Any = field(default_factory=lambda: np.array([0.71, 0.53]))
    runs: Any = field(default_factory=lambda: {
        "nfo": SimpleNamespace(gap=4e-3, evaluations=16000, seconds=0.04),
        "nfo_whitened": SimpleNamespace(gap=1e-15, evaluations=16000, seconds=0.04),
    })  # fmt: skip
    reference: Any = field(
        default_factory=lambda: SimpleNamespace(gap=3e-12, iterations=8, seconds=0.011, status="Solve_Succeeded")
    )
    certificate: str = "certified: relative gap 1e-14, KKT residual 3e-13"
    plausibility: tuple[Finding, ...] = (
        Finding(
            "sign", "warning", "viscous friction of the knee is negative", where="viscous:knee", remedy="more data"
        ),
    )
    best_known: bool = True
    shapes_known: str = "shape parameters: best known, 3 of 6 starts agree"
    seconds: float = 0.3

    def to_json(self) -> dict[str, Any]:
        return {"parameters": {e.name: e.to_json() for e in self.estimates}, "rms": self.rms}

    def plot(self) -> Any:
        return figure()


@dataclass(frozen=True, eq=False)
class FakeComparison:
    joints: tuple[str, ...] = ("hip", "knee")
    misread: tuple[Finding, ...] = ()
    audit: tuple[Finding, ...] = ()
    unseen: bool = True
    forces: tuple[Any, ...] = ()
    strides: Any = None
    fit: Any = field(default_factory=FakeFit)
    now: Any = field(default_factory=lambda: SimpleNamespace(prepared=None))
    rms: Any = field(default_factory=lambda: np.array([0.71, 0.53]))
    unit: str = "N·m"
    signal_rms: Any = field(default_factory=lambda: np.array([24.0, 11.0]))
    noise_floor: Any = field(default_factory=lambda: np.array([0.5, 0.5]))
    where: tuple[Any, ...] = (
        SimpleNamespace(joint="knee", variable="dq2 near zero", share=0.41, caution="",
                        sentence="The knee misses torque when it starts or reverses."),
        SimpleNamespace(joint="hip", variable="q1", share=0.07, caution="only in run_0", sentence=HOSTILE),
    )  # fmt: skip

    material = Comparison.material

    @property
    def verify_rms(self) -> Any:
        return np.array([0.74, 0.58]) if self.unseen else None

    def before_and_after(self, after: Any) -> tuple[str, str, Any]:
        return "Before and after", "measured, before and after", figure()

    def figures(self) -> list[tuple[str, str, Any]]:
        return [("Residual over time", f"The residual of both joints. {HOSTILE}", figure())]

    def to_json(self) -> dict[str, Any]:
        return {"rms": self.rms, "verify_rms": self.verify_rms, "noise_floor": self.noise_floor}


STEPS = [
    {"model": "base", "train_rms": [0.71, 0.93], "verify_rms": [0.74, 0.98]},
    {"model": "+ stribeck:knee", "train_rms": [0.70, 0.56], "verify_rms": [0.73, 0.58]},
    {"model": "+ torque_ripple:knee", "train_rms": [0.70, 0.51], "verify_rms": [0.73, 0.53]},
]


@dataclass(frozen=True, eq=False)
class FakeDiagnosis:
    audit: tuple[Finding, ...] = ()
    verdict: str = "missing"
    rule: str = "stribeck:knee lowers the error of unseen motion, and no placebo did"
    sentence: str = "The knee sticks when it starts or reverses, and runs freely once it moves."
    headline: str = "Found: Stribeck friction at the knee; very sure"
    sureness: str = "very sure"
    suspects: tuple[Any, ...] = (
        SimpleNamespace(effect="stribeck", joint="knee", caution=""),
        SimpleNamespace(effect="viscous_quadratic", joint="knee", caution="looks like the first"),
        SimpleNamespace(effect="gravity_tilt", joint=None, caution=HOSTILE),
    )
    steps: tuple[Any, ...] = tuple(
        Step(s["model"], np.array(s["train_rms"]), np.array(s["verify_rms"])) for s in STEPS
    )
    joints: tuple[str, ...] = ("hip", "knee")
    unit: str = "N·m"
    noise_floor: Any = field(default_factory=lambda: np.array([0.5, 0.5]))
    next_experiment: str = "Move the knee slowly through zero speed, many times."
    seconds: float = 1.9
    cutoff: str = "8 Hz, the best of seven on unseen motion"
    stopped_because: str = "nothing left lowers the error of unseen motion"
    biased: tuple[str, ...] = ("Phi2",)
    model: Any = field(default_factory=FakeModel)
    fit: Any = field(default_factory=FakeFit)
    given: Any = field(default_factory=lambda: SimpleNamespace(fit=None, prepared=None))
    power: tuple[Power, ...] = (Power("stribeck", "hip", "c", 17.6, 5.0, "N·m"),)

    material = Diagnosis.material

    def fitted_on(self, prepared: Any) -> Any:
        return None

    def figures(self) -> list[tuple[str, str, Any]]:
        return [("Suspects", "Share explained by each suspect, with its placebos.", figure())]

    @property
    def further(self) -> str:
        return self.sentence

    def called(self, name: str) -> str:
        return name

    def to_json(self) -> dict[str, Any]:
        return {
            "schema": "exoid.discovery/1",
            "verdict": self.verdict,
            "accepted": [
                {"effect": "stribeck", "joint": "knee", "look_alikes": ["viscous_quadratic:knee"], "p_value": 0.001,
                 "parameters": {"stribeck:knee.c": Estimate("c", 2.6, "N·m", 2.2, float("inf")).to_json()},
                 "rms_before": [0.74, 0.98], "rms_after": [0.73, 0.58], "sureness": "very sure"},
            ],
            "suspects": [
                {"effect": s.effect, "joint": s.joint, "explained_share": share, "p_value": p, "look_alikes": alike,
                 "caution": s.caution, "sureness": "very sure" if s.effect == "stribeck" else ""}
                for s, share, p, alike in zip(self.suspects, (0.61, 0.4, 0.02), (0.001, 0.02, None),
                                              (["viscous_quadratic:knee"], [], []), strict=True)
            ],
            "steps": STEPS,
            "noise_floor": self.noise_floor,
            "unexplained": {"significant": True, "joint": "hip", "variables": ["q1"], "share": 0.2,
                            "suggested_terms": ["c * exp(-((theta - 0.5)/0.1)**2)"]},
            "audit": [f.to_json() for f in FINDINGS],
            "seconds": self.seconds,
        }  # fmt: skip


def material() -> Any:
    from exoid.diagnosis.report.material import Material, pictures_of

    found, comparison = FakeDiagnosis(), FakeComparison()
    return Material(
        title="What the model was missing", recordings=(recording("run_0", FINDINGS), recording("run_1")),
        verify=(recording("run_2"),), model=found.model, fit=found.fit, comparison=comparison, diagnosis=found,
        fall=found, pictures=pictures_of(found, comparison), truth="stribeck:knee was hidden.",
        command="exoid discover run_0.csv run_1.csv --verify run_2.csv", settings={"seed": "0"}, seconds=1.9,
    )  # fmt: skip
