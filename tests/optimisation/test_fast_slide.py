"""The cut-off of a heavy slide that accelerates in a tenth of a second, seen by a good encoder."""

from __future__ import annotations

import numpy as np

from exoid.measurement.reading.read import read_recording
from exoid.optimisation.fitting.identify import identify
from exoid.optimisation.preparation.prepare import prepare
from exoid.symbolic.joints import Joint
from exoid.symbolic.model import Model

RATE, MASS, COULOMB, VISCOUS = 500.0, 95.0, 20.0, 200.0


def test_a_slow_cut_off_that_its_own_filter_error_favours_is_not_taken(tmp_path):
    t = np.arange(0.0, 20.0, 1.0 / RATE)
    speed = np.zeros(t.size)
    for k, begin in enumerate(np.arange(0.6, 18.0, 1.7)):  # there and back, with rests
        size = (0.1, 0.1, 0.2, 0.2, 0.06, 0.06)[k % 6] * (-1) ** k
        speed += size * np.clip(np.minimum(t - begin, begin + 1.2 - t) / (abs(size) / 1.2), 0.0, 1.0)
    window = np.hanning(31) / np.hanning(31).sum()
    dq = np.convolve(speed, window, "same")
    q, ddq = np.cumsum(dq) / RATE, np.gradient(dq, 1.0 / RATE)
    sign = np.where(np.abs(dq) > 1e-6, np.sign(dq), 0.0)
    noise = 0.5 * np.random.default_rng(0).standard_normal(t.size)
    tau = MASS * ddq + COULOMB * sign + VISCOUS * dq + noise
    path = tmp_path / "slide.csv"
    np.savetxt(path, np.column_stack([t, q, tau]), delimiter=",", header="t,q,tau", comments="", fmt="%.7f")
    model = Model("slide", gravity=0.0, joints=(Joint("axis", "prismatic"),))
    prepared = prepare(model, [read_recording(path, joints=model.joints)])
    assert prepared.choice.cutoff >= 10.0
    mass = identify(model, prepared.train, optimisers=()).estimates[0]
    assert abs(mass.value - MASS) < 0.01 * MASS
