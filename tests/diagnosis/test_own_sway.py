"""A base that sways with another phase in every recording: its frequency and amplitude, each half by the other."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from synthetic import recording, search

from diagnosis.evidence.own_sway import own_sway
from diagnosis.rules import RULES
from diagnosis.verdict import Conclusion, swayed
from symbolic.model import Model

NOISE = np.full(2, 0.05)
OFFSET = {"torque_offset:knee": ([3.0], [])}


def fitted(hidden):
    """The plain model fitted to three recordings and judged on a fourth, with the effects `hidden` (a list) in them."""
    context = search({}, [])
    made = [recording(f"run_{k}", k, each) for k, each in enumerate(hidden)]
    prepared = replace(context.prepared, train=tuple(made[:3]), verify=tuple(made[3:]))
    return replace(context, prepared=prepared).fit(Model.standard()).fitted


def sway(phase, hertz=1.3, size=0.8):
    """Forwards alone, so large, with that phase."""
    return {"base_motion": ([size * np.cos(phase), size * np.sin(phase), 0.0, 0.0], [hertz])}


def test_a_sway_with_a_phase_of_its_own_in_every_recording_is_found_with_its_size():
    last = fitted([sway(phase) for phase in (0.0, 2.0, 4.0, 5.0)])
    found = own_sway(last, NOISE)
    assert found is not None
    assert found.hertz == pytest.approx(1.3, abs=0.01)
    assert found.amplitudes[:, 0] == pytest.approx(0.8, rel=0.1)
    assert found.amplitudes[:, 1] == pytest.approx(0.0, abs=0.08)
    assert np.all(found.after < 1.5 * NOISE) and found.share > 0.9
    assert found.parameters["forward"].low <= 0.8 <= found.parameters["forward"].high
    answer = swayed(found, Conclusion("missing", "", "", "", ""), last.model.joints)
    assert answer.verdict == "unexplained"
    assert "sways at 1.3 Hz, 0.8" in answer.sentence and "hip" in answer.sentence


def test_no_sway_is_seen_where_none_is_or_where_it_is_the_lesser_part():
    assert own_sway(fitted([{}] * 4), NOISE) is None
    last = fitted([sway(phase) for phase in (0.0, 2.0, 4.0, 5.0)])
    assert own_sway(last, last.evaluation_rms / 2.0) is None  # near the noise
    assert own_sway(last, NOISE, replace(RULES, leading=1.0)) is None


def test_a_model_that_sways_already_is_not_asked():
    made = fitted([sway(0.3)] * 4)
    model = made.model.with_effect("base_motion")
    other = replace(made, fit=replace(made.fit, model=model))
    assert own_sway(other, NOISE) is None
