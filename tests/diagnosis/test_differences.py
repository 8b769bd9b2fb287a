"""Recordings that differ, beside a hidden effect: each hides the other as long as it is missing."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.differences import drawn, judged
from exoid.diagnosis.against.differences import compare_against
from exoid.diagnosis.against.result import Differences
from exoid.diagnosis.discovery import discover
from exoid.ground.errors import RecordingError
from exoid.measurement.bench.leg import standard_leg
from exoid.measurement.bench.simulation import Bench, simulate_runs
from exoid.measurement.recording import Recording
from exoid.symbolic import Model, Motion
from exoid.symbolic.joints import Joint


@pytest.mark.slow
@pytest.mark.parametrize(
    ("seed", "kind", "effect"),
    [
        (113, "late clock", False),  # friction that differs promises more at first
        (605, "gain", True),  # a curve in the velocity explains as much as the gain alone
        (612, "zeros", True),  # the nearest entry of the catalogue is another than that which is missing
        (614, "gain", True),  # a stop seems to stand elsewhere in each recording
        (325, "load", True),  # friction that grows with the load bears that of a recording, too
        (331, "load from then on", True),
        (339, "fast clock", True),  # as if something pushed
        (69, "encoder", False),  # as if a torque sensor had another zero
        (721, "load", True),  # no suspect felt the load
        (713, "friction", True),  # of the base model, not of the effect
        (724, "temperature", True),  # the same, with seven numbers of recordings besides
    ],
)
def test_what_differs_and_the_effect_that_is_missing_are_told_together(seed, kind, effect):
    wrong, told, inside = judged(seed, kind, effect=effect)
    assert wrong == "" and (told or kind == "temperature") and inside >= told - 1


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(2000, 2006))
def test_nothing_is_told_where_nothing_differs(seed):
    model, recordings, _, _ = drawn(seed, "nothing", effect=False)
    answer = discover(model, recordings[:3], recordings[3:])
    assert answer.verdict == "adequate" and not answer.of_recordings


def test_friction_bears_a_load_that_is_no_part_of_the_model():
    model = Model("drive", limits={}, joints=(Joint("hip"),)).with_effect("load_friction", "hip")
    rng = np.random.default_rng(0)
    q, dq, ddq = rng.standard_normal((3, 50, 1))
    load, linear = rng.standard_normal((50, 1)), rng.uniform(0.5, 1.5, len(model.parameters))
    bare, carrying = (model.torque(Motion(np.arange(50.0), q, dq, ddq, load=x), linear) for x in (None, load))
    rigid = model.without("load_friction:hip")
    own = np.where([p.name.startswith(("coulomb", "viscous")) for p in rigid.parameters], 0.0, linear[:-1])
    weight = rigid.torque(Motion(np.arange(50.0), q, dq, ddq), own)
    wanted = linear[-1] * (np.abs(weight + load) - np.abs(weight)) * np.sign(dq)
    np.testing.assert_allclose(carrying - bare, wanted, atol=1e-12)


@pytest.mark.slow
def test_of_a_joint_with_a_friction_more_another_level_of_the_usual_one_is_told():
    model = Model("drive", limits={}, joints=(Joint("hip"),)).with_effect("load_friction", "hip")

    def run(k, level):
        t, rng = np.arange(0.0, 15.0, 0.01), np.random.default_rng(k)
        pace = np.array([2.0 + 0.2 * k, 5.1 - 0.3 * k])
        angle, size = np.outer(t, pace) + np.array([0.0, k]), np.array([0.8, 0.4])
        parts = (size * np.sin(angle), size * pace * np.cos(angle), -size * pace**2 * np.sin(angle))
        q, dq, ddq = (part.sum(axis=1, keepdims=True) for part in parts)
        tau = model.torque(Motion(t, q, dq, ddq), np.array([0.3, 3.0, 1.2 * level, 0.5 * level, 0.15]))
        return Recording(f"run_{k}", t, q, tau + 0.05 * rng.standard_normal(tau.shape), joints=model.joints)

    found = compare_against(model, [run(k, 1.0) for k in range(4)], [run(k, 1.4) for k in range(4, 8)])
    assert [change.name for change in found.found] == ["friction_level:hip"]


def test_an_error_that_grew_is_told_although_nothing_that_was_asked_differs():
    def found(left):
        return Differences((), (), ("old",), ("new",), ("hip", "knee"), (0.2, 0.2), left, left, ("N·m", "N·m"))

    assert found((0.3, 0.5)).sentence.startswith("Nothing differs between before and after")
    assert "the error of the knee grew from 0.2 to 3.1 N·m: look at the channels" in found((0.3, 3.1)).sentence


@pytest.mark.slow
def test_recordings_in_degrees_are_refused_and_no_load_of_another_sign_is_told():
    before, after = (one.recording for one in simulate_runs(2, None, standard_leg(), seed=3))
    with pytest.raises(RecordingError, match="in degrees"):
        compare_against(Model.standard(), [before], [replace(after, q=np.rad2deg(after.q))])


@pytest.mark.slow
def test_a_load_and_a_zero_are_told_beside_each_other():
    """The load was granted first, at the place where it took up the zero: 2.5 kg, and a ripple for what was left."""
    bench, leg = Bench(duration=25.0), standard_leg()
    before = [run.recording for run in simulate_runs(3, leg=leg, bench=bench)]
    after = [run.recording for run in simulate_runs(6, leg=leg.with_payload(2.0, 0.3), bench=bench)[3:]]
    after = [replace(run, tau=run.tau + np.array([1.0, 0.0]), name=f"after_{run.name}") for run in after]
    load, zero = compare_against(Model.standard(), before, after).found
    assert (load.name, zero.name) == ("payload:shank", "torque_offset:hip")
    assert load.change[0].value == pytest.approx(2.0, abs=0.1) and load.place.value == pytest.approx(0.3, abs=0.02)
    assert zero.change[0].value == pytest.approx(1.0, abs=0.1)


@pytest.mark.slow
@pytest.mark.parametrize(("loads", "gain"), [({3: 1.5}, 1.2), ({1: 1.0, 3: 2.5}, 1.0)])
def test_a_gain_of_all_torques_and_loads_of_two_sizes_are_told_of_a_leg(loads, gain):
    """Two gains and a load were three ways, and so none; of two loads one mass was told, with a gain and zeros."""
    legs = [standard_leg().with_payload(loads[k], 0.3) if k in loads else standard_leg() for k in range(5)]
    runs = [simulate_runs(k + 1, leg=leg, bench=Bench(duration=25.0))[k].recording for k, leg in enumerate(legs)]
    runs[1] = replace(runs[1], tau=gain * runs[1].tau)
    found = discover(Model.standard(), runs[:4], runs[4])
    told = {(item.what, item.joint): {k: e.value for k, e in item.values.items()} for item in found.of_recordings}
    expected = {("torque_gain", None): pytest.approx({"run_1": gain}, abs=0.01)} if gain != 1.0 else {}
    expected["carried_load", "shank"] = pytest.approx({f"run_{k}": mass for k, mass in loads.items()}, abs=0.06)
    assert found.verdict == "adequate" and told == expected
