"""Forces that are measured are named on the page."""

from __future__ import annotations

from exoid.apps.page import views
from exoid.diagnosis import Session
from exoid.measurement.bench.simulation import Bench, simulate_runs
from exoid.symbolic.force import Force
from exoid.symbolic.model import Model

FORCES = (Force("thigh cuff", "hip", ("f1",), 0.28), Force("shank cuff", "knee", ("f2",), 0.21))


def test_the_page_tells_the_forces_that_are_used():
    worn = Model.standard().with_wearer(mass=70.0, height=1.78).with_forces(*FORCES)
    recordings = [run.recording for run in simulate_runs(2, worn, seed=5, bench=Bench(duration=20.0))]
    told = [one.sentence for one in views._forces(Session(Model.standard(), recordings).fitted())]
    assert [text.partition(" (")[0] for text in told] == ["thigh cuff", "shank cuff"]
