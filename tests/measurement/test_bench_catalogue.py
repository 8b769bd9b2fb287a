"""Every entry of the catalogue can be hidden at every joint, and the recording then obeys the model that has
it.
"""

import numpy as np
import pytest

from exoid.measurement.bench.equation import belongs_to_channel
from exoid.measurement.bench.hidden import Hidden
from exoid.measurement.bench.sensors import Sensors
from exoid.measurement.bench.simulation import Bench, run_bench
from exoid.symbolic.effect_catalogue import catalogue

IDEAL = Bench(duration=5.0, lead_in=0.0, sensors=Sensors.ideal())
EVERYWHERE = [
    (name, joint)
    for name, effect in catalogue().items()
    for joint in ((None,) if effect.on_both else effect.joints)
    if joint not in effect.absorbed_on
]
# At their typical place some effects are outside the motion, or larger than this leg's dry friction.
VALUES = {
    ("end_stop", "hip"): {"theta_s": 0.7, "side": 1.0},
    ("end_stop", "knee"): {"theta_s": -1.0, "side": -1.0},
    ("hysteresis", "hip"): {"c": 3.0},
    ("hysteresis", "knee"): {"c": 2.5},
    ("passive_exponential", "hip"): {"side": 1.0},
}
# Play and Dahl's state go through every inner step; the columns see them at the samples only, so that the
# turn of a motion between two samples is rounded off.
# What rises steeply from standstill stops a joint within a sample, which the columns see one sample later: how far off
# these few are is the last digits' affair.
SAMPLED = {"hysteresis": 0.1, "backlash": 0.02, "viscous_power": np.inf}
# What stands between link and encoder is real on the bench and of first order in the model.
FIRST_ORDER = {"motor_elasticity", "series_backlash"}


@pytest.fixture(scope="module")
def plain():
    return run_bench(seed=1, bench=IDEAL)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "joint"), EVERYWHERE)
def test_a_hidden_effect_is_the_models_own_torque(name, joint, plain):
    one = run_bench(effects=[Hidden(name, joint, VALUES.get((name, joint), {}))], seed=1, bench=IDEAL)
    error = np.abs(one.true.torque(one.motion) - one.torque)
    missing = plain.true.torque(one.motion) - one.torque
    if name in FIRST_ORDER:
        assert np.median(error, axis=0).max() < 0.25 * np.median(np.abs(missing), axis=0).max()
        assert one.saturated == 0.0
        return
    assert error.max() < SAMPLED.get(name, 1e-4)
    assert np.percentile(error, 95) < 1e-4
    assert one.saturated == 0.0 and np.abs(one.motion.sign).max() <= 1.0 + 1e-9
    # The base model alone does not explain the recording: the effect has really acted.
    assert np.abs(missing).max() > 0.05
    for j in (0, 1):
        if joint == ("hip", "knee")[1 - j]:
            assert np.percentile(np.abs(missing[:, j]), 95) < 1e-4


def test_only_what_belongs_to_the_torque_channel_is_added_there():
    channel = {
        name
        for name, joint in EVERYWHERE
        for term in run_bench(effects=[Hidden(name, joint)], bench=Bench(duration=0.1, lead_in=0.0)).true.model.terms
        if belongs_to_channel(term)
    }
    assert channel == {"drive_gain", "time_delay", "joint_elasticity"}
