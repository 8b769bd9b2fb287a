"""A worn machine with measured forces in verbs beside compare and discover: exported, separated, and on the page."""

from __future__ import annotations

import numpy as np
import pytest

from exoid.diagnosis.separation.design import separate
from exoid.measurement.bench.leg import standard_leg
from exoid.measurement.bench.simulation import Bench, simulate_runs
from exoid.symbolic.force import Force
from exoid.symbolic.model import Model
from exoid.symbolic.model_file import Numbers
from exoid.symbolic.motion import Motion
from exoid.workbench.export import numpy
from exoid.workbench.identified import Options, ready
from tests.exported_module import python_module

FORCES = (Force("thigh cuff", "hip", ("f1",), 0.28), Force("shank cuff", "knee", ("f2",), 0.21))
WORN = Model.standard().with_wearer(mass=70.0, height=1.78).with_forces(*FORCES)


@pytest.fixture(scope="module")
def recordings():
    runs = simulate_runs(2, WORN, effects="load_friction:knee=0.25", seed=5, bench=Bench(duration=20.0))
    return [run.recording for run in runs]


def test_exported_code_takes_the_forces_and_moves_the_limb_too(tmp_path):
    numbers = Numbers(dict(zip([p.name for p in WORN.parameters], standard_leg().base, strict=True)), {}, None)
    module = python_module(numpy.write(ready(WORN, numbers), Options())["exoid_leg.py"], tmp_path, "worn")
    rng = np.random.default_rng(0)
    t, (q, dq, ddq) = np.arange(9) * 0.01, rng.normal(size=(3, 9, 2))
    force = 20.0 * rng.normal(size=(9, 2))
    motion = Motion(t, q, dq, ddq, payload=WORN.wearer.added(WORN), force=force)
    wanted = WORN.torque(motion, np.array(standard_leg().base))
    assert np.abs(module.torque(t, q, dq, ddq, force) - wanted).max() < 1e-10
    assert np.abs(module.torque(t, q, dq, ddq, 0.0 * force) - wanted).max() > 1.0


@pytest.mark.slow
def test_rivals_of_pushed_recordings_are_fitted_with_what_pushed(recordings):
    found = separate(WORN, ["load_friction:knee", "stribeck:knee"], recordings, generations=2, seed=1)
    assert found.rivals[0].own["load_friction:knee.c"] == pytest.approx(0.25, abs=0.01)
    assert np.all(found.noise.sd < 0.35) and found.separable
