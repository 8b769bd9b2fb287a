"""Passive moments of hip and knee: the published curves, which machines have them, and that hidden ones are found."""

import math

import numpy as np
import pytest

from exoid.diagnosis.discovery import discover
from exoid.ground.errors import EffectError
from exoid.measurement.bench.simulation import Bench, simulate_runs
from exoid.symbolic.effect_catalogue import catalogue
from exoid.symbolic.joints import Joint
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Motion

LEG = Model.standard()
MOMENTS = ("passive_hip:hip", "passive_knee:knee")
CHAIN = tuple(Joint(name, length=0.4) for name in ("hip", "knee", "ankle"))


def published(hip, knee):
    """Riener and Edrich 1999: moments N·m that flex hip and knee, of angles in degrees, flexion positive."""
    at_hip = math.exp(1.4655 - 0.0034 * knee - 0.0750 * hip) - math.exp(1.3403 - 0.0226 * knee + 0.0305 * hip) + 8.072
    stretched = math.exp(1.800 - 0.0352 * knee + 0.0217 * hip) + math.exp(2.220 - 0.150 * knee)
    return at_hip, stretched - math.exp(-3.971 + 0.0495 * knee - 0.0128 * hip) - 4.820


def carried(model, moment, q):
    """The torque (J,) that the drives supply for a moment, at rest at angles q rad."""
    still = np.zeros((1, len(q)))
    extended = model.with_effect(moment)
    numbers = np.zeros(len(extended.parameters))
    numbers[-1] = 1.0
    return extended.torque(Motion(np.zeros(1), np.array([q]), still, still), numbers)[0]


@pytest.mark.parametrize(("hip", "knee"), [(-10.0, 5.0), (0.0, 0.0), (30.0, 60.0), (90.0, 20.0), (70.0, 110.0)])
def test_the_drives_hold_what_the_muscles_pull(hip, knee):
    flexes_hip, flexes_knee = published(hip, knee)
    q = np.radians([hip, -knee])
    np.testing.assert_allclose(carried(LEG, MOMENTS[0], q), [-flexes_hip, 0.0], rtol=1e-12)
    np.testing.assert_allclose(carried(LEG, MOMENTS[1], q), [0.0, flexes_knee], rtol=1e-12)


def test_a_straight_knee_is_bent_and_a_bent_one_stretched_and_a_flexed_hip_slackens_by_bending_the_knee():
    assert published(0.0, 0.0)[1] > 5.0 and published(0.0, 120.0)[1] < -3.0
    assert published(80.0, 0.0)[0] < published(80.0, 90.0)[0]


def test_other_machines_with_a_hip_and_a_knee_have_them_at_these():
    q = np.radians([30.0, -60.0, 0.0])
    chain = Model("leg with ankle", joints=CHAIN)
    np.testing.assert_allclose(carried(chain, MOMENTS[1], q), [0.0, published(30.0, 60.0)[1], 0.0], rtol=1e-12)
    moved = Model(moving_base=True)
    np.testing.assert_allclose(carried(moved, MOMENTS[0], q[:2]), [-published(30.0, 60.0)[0], 0.0], rtol=1e-12)
    assert not {"passive_hip", "passive_knee"} & {*catalogue(CHAIN[1:])}
    with pytest.raises(EffectError, match="no place"):
        Model("arm", joints=CHAIN[1:]).with_effect(MOMENTS[1])


def test_a_wearer_brings_them():
    ids = {"passive_hip", "passive_knee"}
    assert ids <= {*catalogue()} and not ids & {*catalogue(worn=False)}


@pytest.mark.slow
@pytest.mark.parametrize("moment", MOMENTS)
def test_they_are_found_where_the_model_has_a_wearer(moment):
    worn = LEG.with_wearer(mass=70.0, height=1.78)
    runs = simulate_runs(4, worn, effects=moment, seed=4, bench=Bench(duration=20.0))
    recordings = [run.recording for run in runs]
    found = discover(worn, recordings[:3], recordings[3:])
    assert [one.name for one in found.accepted] == [moment]
    assert found.accepted[0].parameters["c"].low < 1.0 < found.accepted[0].parameters["c"].high
    assert np.all(found.steps[-1].verify_rms < 1.3 * found.noise_floor)
    bare = discover(LEG, recordings[:3], recordings[3:])
    assert not {*MOMENTS} & {*(one.name for one in bare.accepted), *(one.name for one in bare.suspects)}
