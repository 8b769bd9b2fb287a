"""The arena: its plants against exoid's mechanics, its least squares against NumPy's, its counts by hand."""

import importlib
import json

import numpy as np
import pytest

from benchmarks.arena.__main__ import answered, main
from benchmarks.arena.cases import draw, folder, names
from benchmarks.arena.columns import Table
from benchmarks.arena.plants import equations
from benchmarks.arena.referee import graded, page, right
from exoid.measurement.signals.conditioning import low_pass

CASE = "equations/1j@0.02,100/viscous_quadratic:axis/1"


@pytest.fixture(scope="module")
def sealed():
    return draw(CASE)


@pytest.mark.parametrize("name", ["1j@0.02,100/nothing/1", "2j@0.1,100/nothing/1", "3j@0.05,100/nothing/2"])
def test_equations_written_from_forces_are_those_of_the_model(name):
    drawn = equations.draw(name)
    for run in drawn.runs[:2]:
        columns = np.moveaxis(drawn.model.columns(run.motion), 1, 0).reshape(-1, drawn.model.base_count)
        torque = run.torque.ravel()
        left = torque - columns @ np.linalg.lstsq(columns, torque, rcond=None)[0]
        assert np.abs(left).max() < 1e-8 * np.abs(torque).max()
    assert drawn.size < 1e-6


def test_a_case_is_the_same_each_time_and_its_noise_is_what_its_name_says(sealed):
    again = draw(CASE)
    for one, other in zip(sealed.runs, again.runs, strict=True):
        assert np.array_equal(one.recording.tau, other.recording.tau)
    wrong = sealed.runs[0].recording.tau - sealed.runs[0].torque
    assert np.median(np.abs(wrong)) / 0.6745 == pytest.approx(0.02, rel=0.1)


def test_a_task_has_no_torque_of_the_motion_asked(sealed):
    task = sealed.task
    assert len(task.recordings) == len(sealed.runs) - 1
    assert not any(np.array_equal(task.q, one.q) for one in task.recordings)
    assert not hasattr(task, "torque") and not hasattr(task, "hidden")


def test_the_true_torque_is_not_away_and_noise_is_away_by_one(sealed):
    last = sealed.runs[-1]
    assert sealed.away(last.torque) < 1e-9
    noise = 0.02 * np.random.default_rng(0).standard_normal(last.torque.shape)
    expected = np.std(low_pass(noise, 4.0, 100.0)) / sealed.in_band[0]
    assert sealed.away(last.torque + noise) == pytest.approx(expected, rel=0.15)


@pytest.mark.slow
def test_sums_of_products_say_what_a_regression_on_samples_says(sealed):
    table = Table(sealed.task)
    one = table.fitted.prepared.train
    sigma = table.fitted.train_rms[:, None]
    x = np.concatenate([(table.fitted.block_of(r).columns / sigma[:, :, None])[r.used] for r in one])
    y = np.concatenate([(r.torque / sigma)[r.used] for r in one])
    left = y - x @ np.linalg.lstsq(x, y, rcond=None)[0]
    assert table.rest(table.base) == pytest.approx(float(left @ left), rel=1e-6)
    assert len(table.unseen(table.base)) == len(one)
    assert table.best["viscous_quadratic:axis"] in table.nodes["viscous_quadratic:axis"]


def test_counts():
    assert graded(["a:hip", "b:hip"], [["a:hip"], ["c:hip", "b:hip"], ["d:hip"]]) == (2, 1)
    assert graded(["com_offset_shank"], [["encoder_offset_knee"]]) == (1, 0)
    assert right({"names": []}, {"hidden": []}) and not right({"names": []}, {"hidden": ["a:hip"]})
    spoilt = {"hidden": [], "told": "check_channels"}
    assert right({"names": [], "verdict": "check_channels: late"}, spoilt) and right({"names": []}, spoilt)
    assert not right({"names": [], "verdict": "adequate"}, spoilt)


def test_the_page_compares_cases_that_everybody_answered():
    truths = {f"p/k/{n}": {"hidden": [n] if n else [], "size": 3.0} for n in ("", "x:hip")}
    lines = [
        {"case": case, "entry": "a", "names": [[h] for h in truth["hidden"]], "away": 1.5, "seconds": 2.0}
        for case, truth in truths.items()
    ]
    lines.append({**lines[1], "entry": "b", "names": [["y:hip"]]})
    text = page(lines, truths, {"a": "first", "b": "second", "c": "never asked"})
    assert "1 cases were answered by every entry" in text
    assert "| first | 1 of 1 |  | 1 of 1 | 0 of 1 | 1.50 |" in text
    assert "| second | 0 of 1 |  | 0 of 1 | 1 of 1 |" in text
    assert "No case" in page([], truths, {"a": "first"})


def test_every_entry_is_short_and_says_what_it_is():
    for name in folder("entries"):
        module = importlib.import_module(f"benchmarks.arena.entries.{name}")
        with open(module.__file__, encoding="utf-8") as stream:
            assert len(stream.readlines()) <= 40
        assert module.TITLE and callable(module.answer)


@pytest.mark.slow
def test_names_are_distinct_and_every_plant_has_its_part_in_the_first_of_them():
    every = names()
    assert len(set(every)) == len(every)
    assert {case.partition("/")[0] for case in every[:25]} == set(folder("plants"))
    others = names(1100)
    assert len(others) == len(every) and not {*others} & {*every}


@pytest.mark.slow
def test_rivals_that_select_name_what_is_plain(sealed):
    for entry in ("friction_models", "stepwise"):
        said = importlib.import_module(f"benchmarks.arena.entries.{entry}").answer(sealed.task)
        assert said.names[0] == ("viscous_quadratic:axis",)
        assert sealed.away(said.torque) < 3.0


@pytest.mark.slow
def test_answers_are_kept_and_asked_once(tmp_path, capsys):
    words = [str(tmp_path), "--only", CASE, "--entries", "base_model", "--processes", "1"]
    assert main(words) == 0
    assert main(words) == 0
    (line,) = (tmp_path / "answers.jsonl").read_text().splitlines()
    (truth,) = (tmp_path / "truths.jsonl").read_text().splitlines()
    assert json.loads(line)["names"] == [] and json.loads(truth)["hidden"] == ["viscous_quadratic:axis"]
    assert main([*words, "--against", str(tmp_path)]) == 0
    assert "right before 0, now 0" in capsys.readouterr().out


def test_a_plant_that_is_not_installed_is_left_out_with_a_line(monkeypatch, capsys):
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    assert answered("mujoco/leg@0.4/nothing/1", ["base_model"], sealed_before=False) == (None, [])
    assert "MuJoCo is not installed" in capsys.readouterr().out
