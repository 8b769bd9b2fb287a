"""What is concluded of two sets of recordings that hold ties, as JSON: run by `test_every_processor.py` elsewhere.

`python -m tests.diagnosis.answers CHANGE`: angles and torques are multiplied by 1 ± CHANGE, at random.
"""

from __future__ import annotations

import json
import sys
from dataclasses import replace
from typing import Any

import numpy as np

from exoid.diagnosis.discovery import discover
from exoid.measurement.auditing.convention import check_conventions
from exoid.measurement.recording import Recording
from exoid.symbolic.model import Model
from tests.made_recordings import motion, recording
from tests.measurement.test_conventions_of_machines import ANKLE, PAIR, kept, moved


def told(change: float) -> dict[str, Any]:
    """Return verdict, terms and suspects in their order, and what is said of conventions."""
    rng = np.random.default_rng(0)

    def changed(one: Recording) -> Recording:
        q, tau = (x * (1.0 + change * rng.uniform(-1.0, 1.0, x.shape)) for x in (one.q, one.tau))
        return replace(one, q=q, tau=tau)

    runs = []
    for seed in (1, 2, 3, 4):
        extra = 0.35 * motion(seed, 8.0, 50.0).ddq * [0.0, 1.0]  # the rotor of the knee's drive
        runs.append(changed(recording(seed, seconds=8.0, rate=50.0, noise=0.05, extra=extra)))
    found = discover(Model.standard(), runs[:3], verify=runs[3:])
    of_machines = [(PAIR, "right-torque-negated"), (PAIR, "left-angle-negated"), (ANKLE, "knee-angle-negated")]
    readings = [check_conventions([changed(kept(moved(joints), names))]) for joints, names in of_machines]
    return {
        "verdict": found.verdict,
        "accepted": [(one.name, one.look_alikes) for one in found.accepted],
        "suspects": [one.name for one in found.suspects],
        "possible": [one.name for one in found.possible],
        "readings": [[(one.what, one.remedy) for one in each] for each in readings],
    }


if __name__ == "__main__":
    print(json.dumps(told(float(sys.argv[1]))))
