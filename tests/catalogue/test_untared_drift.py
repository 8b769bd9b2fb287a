"""A torque sensor that drifts and is never tared: every recording has an offset of its own."""

from dataclasses import replace

import numpy as np
import pytest

from exoid.measurement.bench.sensors import Sensors
from exoid.measurement.bench.simulation import Bench, simulate_runs
from exoid.optimisation.fitting.identify import identify
from exoid.optimisation.preparation.prepare import prepare
from exoid.symbolic.model import Model

DRIFT = 0.08


def test_each_recording_gets_its_own_zero():
    sensors = Sensors(burst_rate=0.0, outlier_share=0.0, torque_noise=0.1)
    runs = simulate_runs(2, seed=2, bench=Bench(duration=8.0, sensors=sensors))
    moments = (4.0, -6.0)
    drifting = []
    for one, moment in zip(runs, moments, strict=True):
        tau = np.array(one.recording.tau)
        tau[:, 1] += DRIFT * (one.recording.t - moment)
        drifting.append(replace(one.recording, tau=tau))
    model = Model.standard().with_effect("torque_drift:knee")
    prepared = prepare(Model.standard(), drifting)
    fit = identify(model, prepared.train, optimisers=(), start=np.array([[3.0], [0.0]]))
    assert fit.estimate("torque_drift:knee.c").value == pytest.approx(DRIFT, abs=0.02)
    assert fit.shapes[0, 0] - fit.shapes[1, 0] == pytest.approx(moments[0] - moments[1], abs=3.0)
