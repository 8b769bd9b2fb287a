"""The calls a notebook makes, on the shipped demo recordings."""

from __future__ import annotations

from pathlib import Path

import pytest

from exoid import workbench
from exoid.diagnosis import compare, diagnose
from exoid.measurement import read_recording
from exoid.optimisation import identify
from exoid.symbolic import Model

DATA = Path(workbench.__file__).parent / "demo_data"


@pytest.mark.slow
def test_from_a_recording_to_a_suspect():
    train = [read_recording(DATA / f"train_{k}.csv") for k in (1, 2)]
    verify = [read_recording(DATA / "verify.csv")]
    fit = identify(Model.standard(thigh_length=0.40), train, optimisers=())
    seen = compare(fit, train, verify)
    assert seen.verify_rms[1] > 2.0 * seen.noise_floor[1]
    found = diagnose(fit, train, verify)
    assert [a.name for a in found.accepted] == ["load_friction:knee"]
    assert "load_friction" in found._repr_html_() and not found.to_frame().empty
    assert found.figures() and found.plot() is not None
    assert set(found.to_json()) >= {"schema", "verdict", "accepted", "suspects", "steps", "noise_floor", "unexplained"}
