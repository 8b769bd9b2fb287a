"""A diagnosis against the truth: what counts as found, and what the command says of it."""

from __future__ import annotations

import json

import pytest

from exoid.diagnosis.grading import ScoreError, match, score
from exoid.measurement.bench.seal import HiddenTruth, Truth, write_seal
from exoid.workbench.command import main


def truth(*effects: HiddenTruth) -> Truth:
    return Truth("a leg", (1.0,) * 8, effects, 0)


STRIBECK = HiddenTruth("stribeck", "knee", {"c": 2.0, "v_s": 0.1})
TILT = HiddenTruth("gravity_tilt", None, {"tilt": 0.02})


def found(verdict: str, *accepted: tuple[str, str | None, list[str]]) -> dict:
    numbers = {"c": {"value": 2.1, "unit": "N·m", "low": 1.9, "high": 2.3}}
    entries = [{"effect": e, "joint": j, "look_alikes": a, "parameters": numbers} for e, j, a in accepted]
    return {"schema": "exoid.discovery/1", "verdict": verdict, "accepted": entries}


def test_found_by_name_with_its_numbers():
    one = score(truth(STRIBECK), found("missing", ("stribeck", "knee", [])))
    assert one.right and one.hidden[0].outcome == "found"
    (number,) = one.hidden[0].numbers
    assert number.inside and number.true == 2.0


def test_a_look_alike_counts_and_an_extra_does_not_pass():
    one = score(truth(STRIBECK), found("ambiguous", ("hysteresis", "knee", ["stribeck:knee"])))
    assert one.right and one.hidden[0].outcome == "in a class"
    more = score(truth(STRIBECK), found("missing", ("stribeck", "knee", []), ("time_delay", "hip", [])))
    assert not more.right and more.extra == ("time_delay:hip",)


def test_a_class_does_not_take_the_place_of_another_hidden_effect():
    answers = match(["a", "b"], [("b", ["a"]), ("c", ["a"])])
    assert answers == {"a": "c", "b": "b"}


@pytest.mark.parametrize(("verdict", "right"), [("adequate", True), ("unexplained", False)])
def test_nothing_hidden_must_be_called_adequate(verdict, right):
    assert score(truth(), found(verdict)).right is right


@pytest.mark.parametrize(
    "wrong", [{}, [], {"schema": "other/1"}, {"schema": "exoid.discovery/1", "verdict": "x"}, None]
)
def test_what_is_no_diagnosis_is_refused(wrong):
    with pytest.raises(ScoreError, match="not the JSON of exoid diagnose"):
        score(truth(TILT), wrong)


def test_the_command_scores_and_its_status_says_it(tmp_path, capsys):
    recording = tmp_path / "run_0.csv"
    recording.write_text("t,q1,q2,tau1,tau2\n", encoding="utf-8")
    seal = write_seal(tmp_path / "truth.seal", truth(STRIBECK), [recording])
    for content, status in ((found("missing", ("stribeck", "knee", [])), 0), (found("adequate"), 1)):
        path = tmp_path / "found.json"
        path.write_text(json.dumps(content), encoding="utf-8")
        assert main(["reveal", str(seal), "--diagnosis", str(path)]) == status
    assert "stribeck:knee: missed" in capsys.readouterr().out
    (tmp_path / "bad.json").write_text("{", encoding="utf-8")
    assert main(["reveal", str(seal), "--diagnosis", str(tmp_path / "bad.json")]) == 2
