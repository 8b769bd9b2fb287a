"""Parameter by recording: agreement, contradiction, and the thigh length that the data want."""

from __future__ import annotations

import json
from functools import cache

import numpy as np
import pytest

from exoid.measurement.recording import Recording
from exoid.optimisation.fitting.by_recording import by_recording
from exoid.optimisation.fitting.identify import identify
from exoid.optimisation.fitting.thigh_length import wanted_thigh_length
from exoid.optimisation.preparation.prepare import prepare
from exoid.symbolic.model import Model
from tests.newton_euler import Leg, torque

LEG = Leg(m=(7.0, 4.5), inertia=(0.14, 0.07), along=(0.18, 0.2), length=0.4)


@cache
def run(seed, viscous=1.0):
    rng, count = np.random.default_rng(seed), 1500
    t = 0.01 * np.arange(count)
    q, dq, ddq = np.zeros((3, count, 2))
    for joint, (middle, size) in enumerate(((0.5, 0.5), (-0.9, 0.4))):
        q[:, joint] += middle
        for w, phase in zip((1.3, 3.1, 4.7), rng.uniform(0, 6, 3), strict=True):
            q[:, joint] += 0.5 * size * np.sin(w * t + phase)
            dq[:, joint] += 0.5 * size * w * np.cos(w * t + phase)
            ddq[:, joint] -= 0.5 * size * w * w * np.sin(w * t + phase)
    tau = np.array([torque(LEG, *state) for state in zip(q, dq, ddq, strict=True)])
    tau += 2.0 * np.sign(dq) + np.array([viscous, 0.8]) * dq + 0.2 * rng.standard_normal(tau.shape)
    return Recording(f"run{seed}", t, q + 1e-4 * rng.standard_normal(q.shape), tau)


def fitted(runs, length=0.4):
    prepared = prepare(Model.standard(thigh_length=length), runs, cutoff=5.0)
    return identify(Model.standard(thigh_length=length), prepared.train, optimisers=()), prepared


@pytest.mark.slow
def test_honest_recordings_agree_and_a_change_is_seen():
    found = by_recording(fitted([run(0), run(1), run(2)])[0])
    assert found.recordings == ("run0", "run1", "run2") and len(found.trusted()) == len(found.rows)
    frame, text = found.to_frame(), repr(found)
    assert len(frame) == len(found.rows) and "run2" in text and "Phi1" in found._repr_html_()
    json.dumps(found.to_json(), allow_nan=False)
    assert found.plot().axes
    changed = by_recording(fitted([run(0), run(1), run(2, viscous=3.0)])[0])
    (row,) = [row for row in changed.rows if row.name == "viscous:hip"]
    assert (
        row.verdict == "contradict" and row.scatter == pytest.approx(1.1, abs=0.4) and "constant speeds" in row.advice
    )
    assert "viscous:hip" not in changed.trusted()


def test_one_recording_cannot_be_compared():
    found = by_recording(fitted([run(0)])[0])
    assert all(row.p_value is None and row.advice for row in found.rows)


def test_the_thigh_length_is_told():
    runs = [run(0), run(1)]
    right = wanted_thigh_length(*fitted(runs))
    assert right.told and not right.wrong and right.value == pytest.approx(0.4, rel=0.1)
    assert right.finding().severity == "info"
    wrong = wanted_thigh_length(*fitted(runs, 0.6))
    assert wrong.wrong and wrong.low < 0.4 < wrong.high and wrong.value == pytest.approx(right.value, rel=0.02)
    assert wrong.finding().severity == "warning" and "thigh_length = 0." in wrong.finding().remedy
    json.dumps(wrong.to_json(), allow_nan=False)


def test_a_knee_that_hardly_moves_cannot_tell_the_thigh_length():
    one = run(0)
    rng = np.random.default_rng(5)
    q = 0.03 * (one.q - one.q.mean(axis=0)) + [0.0, 0.0]
    still = Recording("still", one.t, q, one.tau + 3.0 * rng.standard_normal(one.tau.shape))
    found = wanted_thigh_length(*fitted([still]))
    assert not found.told and not found.wrong and "cannot tell" in found.sentence
    json.dumps(found.to_json(), allow_nan=False)
