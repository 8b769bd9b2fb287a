"""A base that sways with another phase in every recording: found at its frequency, and fitted."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from synthetic import recording, search

from exoid.diagnosis.evidence.swinging import sway_nodes, swinging
from exoid.diagnosis.results import Accepted
from exoid.diagnosis.search.engine import run_search
from exoid.diagnosis.verdict import conclude
from exoid.optimisation.fitting.identify import identify
from exoid.optimisation.fitting.phases import phases_of
from exoid.symbolic.model import Model

NOISE = np.full(2, 0.05)
OFFSET = {"torque_offset:knee": ([3.0], [])}


PHASES = (0.0, 2.0, 4.0, 5.0)


def asked(hidden, candidates=()):
    """A search on three recordings, judged on a fourth, with the effects `hidden` (a list) in them."""
    context = search({}, candidates)
    made = [recording(f"run_{k}", k, each) for k, each in enumerate(hidden)]
    return replace(context, prepared=replace(context.prepared, train=tuple(made[:3]), verify=tuple(made[3:])))


def fitted(hidden):
    """The plain model fitted to these."""
    return asked(hidden).fit(Model.standard()).fitted


def sway(phase, hertz=1.3, size=0.8):
    """Forwards alone, so large, with that phase."""
    return {"base_motion": ([size * np.cos(phase), size * np.sin(phase), 0.0, 0.0], [hertz, 0.0])}


def test_a_sway_with_a_phase_of_its_own_in_every_recording_is_looked_for_at_its_frequency():
    found = sway_nodes(fitted([sway(phase) for phase in PHASES]), NOISE)
    assert found is not None
    assert found[:, 0, 0] == pytest.approx(1.3, abs=0.02)
    turned = np.exp(1j * (found[:, 0, 1] - found[0, 0, 1] - PHASES))
    assert np.abs(turned - 1.0).max() < 0.3


def test_no_sway_is_looked_for_where_none_is_or_what_is_left_is_near_the_noise():
    assert sway_nodes(fitted([{}] * 4), NOISE) is None
    last = fitted([sway(phase) for phase in PHASES])
    assert sway_nodes(last, last.evaluation_rms / 2.0) is None


def test_a_model_that_sways_already_is_not_asked():
    made = fitted([sway(0.3)] * 4)
    model = made.model.with_effect("base_motion")
    other = replace(made, fit=replace(made.fit, model=model))
    assert sway_nodes(other, NOISE) is None


def test_a_sway_of_another_phase_in_every_recording_is_accepted_and_judged_on_unseen_motion():
    context = asked([sway(phase) for phase in PHASES], ["base_motion", "time_delay:hip", "torque_ripple:hip"])
    state = run_search(context, context.fit(Model.standard())).state
    assert state.names == ("base_motion",)
    last = state.last.fitted
    known = {e.name.removeprefix("base_motion."): e for e in last.fit.estimates}
    assert known["f"].value == pytest.approx(1.3, abs=0.005)
    forwards, upwards = (np.hypot(known[f"{way}_s"].value, known[f"{way}_c"].value) for way in "xz")
    assert forwards == pytest.approx(0.8, rel=0.05) and upwards < 0.08
    assert known["x_s"].value > 0.9 * forwards  # nearly all of it, and with that sign
    turned = np.exp(1j * (last.shapes[:, 1] - last.shapes[0, 1] - PHASES))
    assert np.abs(turned - 1.0).max() < 0.2  # that of the one which was never fitted, too
    assert np.all(last.evaluation_rms < 1.5 * NOISE)


def test_a_sway_of_another_size_in_every_recording_is_told_and_not_accepted_as_one_of_the_same_size():
    hidden = [sway(phase, size=size) for phase, size in zip(PHASES, (0.2, 0.9, 0.3, 1.4), strict=True)]
    context = asked(hidden, ["base_motion"])
    state = run_search(context, context.fit(Model.standard())).state
    assert state.names == ()
    found = swinging(state.last.fitted)
    assert found is not None and found.hertz == pytest.approx(1.3, abs=0.1)


def test_a_model_with_a_sway_finds_phases_and_frequency_by_itself():
    train = asked([sway(phase) for phase in PHASES]).prepared.train
    fit = identify(Model.standard().with_effect("base_motion"), train, optimisers=())
    assert fit.estimate("base_motion.f").value == pytest.approx(1.3, abs=0.005)
    assert fit.estimate("base_motion.x_s").value == pytest.approx(0.8, rel=0.05)
    again = identify(Model.standard().with_effect("base_motion"), train, optimisers=(), start=fit.shape)
    assert again.loss == pytest.approx(fit.loss, rel=0.01)


def test_phases_turn_coefficients_of_recordings_to_the_same_ones():
    common, phases = np.array([0.7, 0.3j]), np.array([0.4, -2.0, 3.0])
    arrows = common * np.exp(1j * phases)[:, None]
    parts = np.stack([arrows.real, arrows.imag], axis=2).reshape(3, 4)
    assert phases_of(parts) == pytest.approx(phases)


def test_the_rule_of_an_answer_names_the_effect_and_not_the_phase_that_each_recording_has_to_itself():
    context = asked([sway(phase) for phase in PHASES], ["base_motion"])
    last = context.fit(Model.standard().with_effect("base_motion")).fitted
    effect = Accepted("base_motion", None, {}, (), (), 0.001, np.ones(2), 0.5 * np.ones(2), "Swaying base")
    found = conclude((effect,), None, last, last, True, 4)
    assert found.rule.startswith("Swaying base") and "phase" in found.sentence
