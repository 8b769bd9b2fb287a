"""A session prepares its recordings once; what it says of a suspect is what adding it then does."""

from __future__ import annotations

import cloudpickle
import numpy as np
import pytest

from exoid.diagnosis.session import Session
from exoid.ground.toml_reader import Table
from exoid.measurement.reading.read import read_recording
from exoid.symbolic.custom_effect import read_custom_effect
from exoid.symbolic.model import Model
from exoid.workbench.commands.demo import DATA

FEW = ("load_friction:knee", "stribeck:knee", "viscous_quadratic:hip")


@pytest.fixture(scope="module")
def session():
    runs = [read_recording(path) for path in sorted(DATA.glob("train*.csv"))]
    held = [read_recording(path) for path in DATA.glob("verify*.csv")]
    session = Session(Model.standard(), runs, held)
    library = session.library
    few = tuple(c for c in library.candidates if c.name in FEW)
    session.__dict__["library"] = type(library)(few)
    return session


@pytest.fixture(scope="module")
def ranking(session):
    ranking = session.ranking()
    seen = []
    for _ in ranking.work():
        seen.append(dict(ranking.draws))
    assert ranking.finished and ranking.weighed == 1.0
    assert any(0 < draws["load_friction:knee"] < session.rules.placebos for draws in seen if draws)
    return ranking


def test_a_session_that_has_worked_can_be_sent_to_another_process(session):
    fitted = session.fitted(["load_friction:knee"])
    sent = cloudpickle.loads(cloudpickle.dumps(session.light()))
    assert np.allclose(sent.fitted(["load_friction:knee"]).train_rms, fitted.train_rms, rtol=1e-12)


def test_the_missing_effect_comes_first_and_placebos_do_not_match_it(session, ranking):
    best = ranking.scores[0]
    assert best.name == "load_friction:knee" and best.significant
    assert ranking.draws[best.name] == session.rules.placebos


def test_what_would_be_left_is_what_is_left(session, ranking):
    trial = ranking.trial("load_friction:knee")
    session.starts_at(["load_friction:knee"], ranking)
    after = session.fitted(["load_friction:knee"])
    assert trial.evaluation_rms == pytest.approx(after.evaluation_rms, rel=0.05)
    assert after is session.fitted(("load_friction:knee",))
    assert np.all(after.evaluation_rms < session.fitted().evaluation_rms)


def test_a_selection_is_explained_by_what_acts_there(ranking):
    everything = [np.ones_like(r, dtype=bool) for r in ranking.fitted.residuals]
    explained = ranking.explained(everything)
    assert next(iter(explained)) == "load_friction:knee" and explained["load_friction:knee"] > 0.3
    nothing = [np.zeros_like(r, dtype=bool) for r in ranking.fitted.residuals]
    assert ranking.explained(nothing) == {}


def test_placebos_stay_near_the_error_as_it_is(ranking):
    low, high = ranking.band("load_friction:knee")
    now = ranking.fitted.residuals[0][1]
    assert np.all(low[0] <= high[0])
    assert np.mean((now >= low[0][1] - 0.3) & (now <= high[0][1] + 0.3)) > 0.9
    assert ranking.band("no_such:knee") is None and ranking.trial("no_such:knee") is None


def test_an_own_effect_joins_in_and_nothing_is_prepared_again(session):
    own = {"id": "brake", "joint": "knee", "torque": "c * dtheta2", "coefficients": {"c": {"unit": "N·m·s/rad"}}}
    before = session.fitted()
    more = session.knowing(read_custom_effect(Table(own, (), "typed", "")))
    assert more.prepared is session.prepared and more.fitted() is before
    assert "brake:knee" in [c.name for c in more.library.candidates]
