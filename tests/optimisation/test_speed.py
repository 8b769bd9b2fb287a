"""What is computed with less work comes out as it would with all of it."""

from __future__ import annotations

import numpy as np
import pytest

from exoid.measurement.reading.formats import csv
from exoid.measurement.signals.conditioning import UniformSignals, low_pass, low_pass_every
from exoid.optimisation.fitting import assemble
from exoid.optimisation.preparation import cutoff
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Motion

RNG = np.random.default_rng(1)


@pytest.mark.parametrize(("samples", "factor"), [(4001, 1), (4001, 3), (300, 3), (5000, 10)])
def test_samples_that_are_kept_are_those_of_the_whole(samples, factor):
    x = np.cumsum(RNG.normal(size=(samples, 2)), axis=0)
    whole = low_pass(x, 10.0, 1000.0)[::factor]
    assert np.allclose(low_pass_every(x, 10.0, 1000.0, factor), whole, rtol=0.0, atol=1e-6 * np.ptp(x))


def test_a_fixed_point_is_extrapolated_from_rounds_of_a_linear_map():
    matrix, offset = np.array([[0.5, 0.3], [-0.2, 0.4]]), np.array([1.0, -2.0])
    tried, x = [], np.zeros(2)
    for _ in range(3):
        tried.append((x, matrix @ x + offset))
        x = tried[-1][1]
    assert np.allclose(assemble._extrapolated(tried, np.eye(2)), np.linalg.solve(np.eye(2) - matrix, offset))


@pytest.mark.parametrize("effect", ["load_friction", "motor_elasticity", "stribeck", "gravity_tilt"])
def test_columns_depend_on_no_other_parameter_than_is_said(effect):
    model = Model.standard().with_effect(effect, None if effect == "gravity_tilt" else "knee")
    motion = Motion(np.arange(50) * 0.01, *(RNG.normal(size=(50, 2)) for _ in range(3)))
    reference = RNG.normal(size=len(model.parameters))
    others = np.delete(np.arange(len(reference)), model.reference_places)
    moved = reference.copy()
    moved[others] += 1.0
    assert np.array_equal(model.columns(motion, None, reference), model.columns(motion, None, moved))
    assert bool(model.reference_places) == model.needs_reference


@pytest.mark.parametrize(
    "effect", ["stribeck:knee", "end_stop:hip", "time_delay:knee", "joint_elasticity:hip", "series_backlash:knee",
               "gravity_tilt"],
)  # fmt: skip
def test_a_torque_is_what_follows_a_shape_and_the_rest(effect):
    model = Model.standard().with_effect(effect)
    for other in ("time_delay:hip", "load_friction:knee"):
        model = model.with_effect(other)
    t = np.arange(200) * 0.02
    q = np.column_stack([0.5 + 0.6 * np.sin(1.3 * t), -0.9 + 0.6 * np.sin(2.0 * t)])
    motion = Motion(t, q, np.gradient(q, t, axis=0), RNG.normal(size=q.shape))
    linear, shape = RNG.uniform(0.5, 1.0, len(model.parameters)), np.array(model.typical_shape)
    for index, entry in enumerate(model.shapes):
        low, high = entry.shape.min, entry.shape.max
        values = np.array([0.7 * low + 0.3 * high, 0.3 * low + 0.7 * high])
        still, joints, moved = model.moving_torque(motion, linear, shape, index)
        for value, part in zip(values, moved(values), strict=True):
            shape_there = np.where(np.arange(shape.size) == index, value, shape)
            whole = still.copy()
            whole[:, list(joints)] += part.T
            assert np.allclose(whole, model.torque(motion, linear, shape_there), rtol=0.0, atol=1e-10)


def test_a_long_recording_is_judged_by_stretches_in_which_it_moves(monkeypatch):
    monkeypatch.setattr(cutoff, "PARTS", 2)
    monkeypatch.setattr(cutoff, "PART", 5.0)
    t = np.arange(0.0, 40.0, 0.01)
    q = np.outer(np.sin(t) * ((t > 8.0) & (t < 14.0) | (t > 30.0) & (t < 36.0)), [1.0, 2.0])
    still = np.zeros(t.size, dtype=bool)
    even = UniformSignals(t, q, q, still, np.zeros(q.shape, dtype=bool), 100.0, np.zeros(2, dtype=bool))
    parts = cutoff.typical(even)
    assert [len(part.t) for part in parts] == [500, 500]
    assert 5.0 < parts[0].t[0] < 12.0 and 27.0 < parts[1].t[0] < 33.0
    assert cutoff.typical(even.stretch(0, 900))[0].t[-1] == pytest.approx(8.99)


def test_a_long_text_is_read_as_a_short_one(tmp_path, monkeypatch):
    file = tmp_path / "run.csv"
    file.write_text("# made\nt,q1 [deg],q2\n" + "".join(f"{k / 100},{k % 7 - 3},{k % 5}.25\n" for k in range(500)))
    short = csv.read(file)
    monkeypatch.setattr(csv, "SHORT", 0)
    monkeypatch.setattr(csv, "CHUNK", 130)
    for table in (csv.read(file), csv._long(file.read_bytes(), 0, file, csv.Budget(str(file)))):
        assert table.names == short.names and np.array_equal(table.row, short.row)
        assert [one.unit for one in table.columns] == [one.unit for one in short.columns]
        assert all(np.array_equal(a.values, b.values) for a, b in zip(table.columns, short.columns, strict=True))


@pytest.mark.parametrize("body", ["0,1,2\n1,2\n", "0,1,x\n", '0,"1",2\n', "0,1,2\n\n", "0,1,2\r\n", "0,1,2"])
def test_a_long_text_that_is_not_tidy_is_left_to_the_careful_way(tmp_path, monkeypatch, body):
    monkeypatch.setattr(csv, "SHORT", 0)
    data = ("t,q1,q2\n" + "0,1,2\n" * 5 + body).encode()
    assert csv._long(data, 0, tmp_path / "run.csv", csv.Budget("run.csv")) is None
