"""The better model that is fed forward, the smaller the tracking error."""

import numpy as np

from exoid.measurement.bench.control import NOTHING, TRUTH, track
from exoid.measurement.bench.hidden import Hidden
from exoid.measurement.bench.leg import standard_leg
from exoid.measurement.bench.simulation import Bench
from exoid.symbolic.model import Model


def test_feedback_and_tracking_error_fall_with_what_is_missing():
    base = np.array(standard_leg().base)
    found = track(
        {"base": (Model.standard(), base, np.zeros(0))},
        effects=[Hidden("load_friction", "knee", {"c": 0.25})],
        bench=Bench(duration=6.0),
    )
    assert [one.name for one in found.runs] == [NOTHING, "gravity of base", "base", TRUTH]
    knee = [float(one.error[1]) for one in found.runs]
    assert knee == sorted(knee, reverse=True)
    assert found.find(TRUTH).error[1] < 0.6 * found.find("base").error[1]
    assert found.find(TRUTH).feedback[1] < 0.5 * found.find("base").feedback[1]
    # The torque that moves the leg is what the motion takes, whoever supplies it.
    np.testing.assert_allclose(found.find("base").effort, found.find(TRUTH).effort, rtol=0.05)
    assert found.to_json()["base"]["tracking_rms"]
