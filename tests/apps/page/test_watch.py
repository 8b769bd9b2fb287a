"""A recording is played through a watch on the page: numbers with intervals, and the change, on one axis of time."""

from __future__ import annotations

import numpy as np
import pytest
from playwright.sync_api import expect

from exoid.measurement.bench.hidden import true_model
from exoid.measurement.bench.leg import standard_leg
from exoid.measurement.trajectories.trajectory import random_trajectory
from exoid.symbolic.mechanics.payload import Payload
from exoid.symbolic.model import Model
from exoid.workbench.commands.demo import DATA
from tests.apps.page.test_story import wait_ready

pytestmark = pytest.mark.slow  # a browser, and fits behind it


def with_a_payload(path, seconds=80.0, moment=48.0):
    """Write a recording of a leg that takes up 1.5 kg meanwhile."""
    model, rng = Model.standard(), np.random.default_rng(8)
    motion = random_trajectory(np.random.default_rng(5), period=47.0, harmonics=24).at(np.arange(0.0, seconds, 0.01))
    number = np.zeros(len(model.parameters))
    number[:4] = Payload(1.5, 0.2, "shank").numbers(model.thigh_length)
    torque = true_model(model, standard_leg().base, ()).torque(motion) + 0.5 * rng.standard_normal(motion.q.shape)
    torque += (motion.t >= moment)[:, None] * (model.columns(motion) @ number).T
    rows = np.column_stack([motion.t, motion.q, torque])
    np.savetxt(path, rows, "%.5f", delimiter=",", header="t,q1,q2,tau1,tau2", comments="")
    return path


@pytest.mark.parametrize("width", [1280, 380])
def test_a_recording_is_played_and_the_change_is_on_the_axis(serve, visit, tmp_path, width):
    page = visit(serve(with_a_payload(tmp_path / "run.csv"), DATA / "train_1.csv").url, width=width)
    wait_ready(page)
    page.get_by_test_id("watch-play").click()
    said = page.get_by_test_id("watch-events").locator("li")
    expect(said.last).to_contain_text("watched")
    assert [one.get_attribute("data-event") for one in said.all()] == ["reference", "change", "change", "summary"]
    expect(said.nth(1)).to_contain_text("payload:shank")
    expect(page.get_by_test_id("watch-plot")).to_have_attribute("data-drawn", "true")
    page.get_by_test_id("watch-number").select_option("viscous:knee")
    expect(page.get_by_test_id("watch-plot")).to_have_attribute(
        "aria-label", "viscous:knee over 80 s of run; what changed is in the list below"
    )
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    # One that is too short is refused in words.
    page.locator("#which").select_option("1")
    page.get_by_test_id("watch-play").click()
    expect(page.get_by_test_id("watch")).to_contain_text("too short to be watched")
