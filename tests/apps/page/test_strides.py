"""Curves over the stride on the page: there where the motion has strides, and not where it has none."""

from __future__ import annotations

import pytest
from playwright.sync_api import expect

from exoid.measurement.bench.simulation import Bench, simulate_runs
from exoid.measurement.bench.walk import Walk
from exoid.measurement.recording import write_recording
from exoid.workbench.commands.demo import DATA
from tests.apps.page.test_story import wait_ready

pytestmark = pytest.mark.slow  # a browser, and fits behind it


@pytest.mark.parametrize("width", [1280, 380])
def test_a_walk_is_shown_over_the_stride(serve, visit, tmp_path, width):
    runs = simulate_runs(2, seed=2, bench=Bench(duration=20.0, walk=Walk(stride=1.3), measured=("plate",)))
    paths = [write_recording(run.recording, tmp_path / f"{run.recording.name}.csv") for run in runs]
    page = visit(serve(*paths).url, width=width)
    wait_ready(page)
    expect(page.get_by_test_id("strides-said")).to_contain_text("from one step of the foot to its next")
    for joint in ("hip", "knee"):
        expect(page.get_by_test_id(f"stride-{joint}")).to_have_attribute("data-drawn", "true")
    assert page.evaluate("document.documentElement.scrollWidth") <= width


def test_a_motion_that_was_drawn_has_no_strides(serve, visit):
    page = visit(serve(DATA / "train_1.csv").url)
    wait_ready(page)
    expect(page.locator("#strides")).to_be_hidden()
