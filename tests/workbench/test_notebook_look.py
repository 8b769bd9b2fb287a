"""Whatever a user gets in a notebook shows itself, plots itself where there is something to plot, and escapes text."""

from __future__ import annotations

import re

import pytest
from workbench_fakes import HOSTILE

from exoid.diagnosis import add, compare, diagnose
from exoid.ground.html import bullets, code, lines, table
from exoid.measurement import read_recording
from exoid.measurement.trajectories.trajectory import paper_trajectory
from exoid.optimisation import identify
from exoid.optimisation.preparation.prepare import prepare
from exoid.symbolic import Model
from exoid.symbolic.effect_catalogue import catalogue
from exoid.workbench.commands.demo import DATA


@pytest.fixture(scope="module")
def results():
    runs = [read_recording(path) for path in sorted(DATA.glob("*.csv"))]
    leg, train, verify = Model.standard(), runs[:1], runs[3:]
    prepared = prepare(leg, train, verify)
    fit = identify(leg, prepared.train)
    added = add(leg, "load_friction:knee", train, verify)
    return {
        "Prepared": prepared, "Recording": runs[0],
        "Model": added.model, "Effect": catalogue()["stribeck"], "Fourier": paper_trajectory(),
        "Fit": fit, "Run": fit.runs["nfo"], "Comparison": compare(fit, train, verify),
        "Diagnosis": diagnose(added.after, train, verify), "Waterfall": added.waterfall, "Addition": added,
    }  # fmt: skip


NAMES = (
    "Prepared", "Recording", "Model", "Effect", "Fourier", "Fit", "Run", "Comparison", "Diagnosis", "Waterfall",
    "Addition",
)  # fmt: skip


@pytest.mark.parametrize("name", NAMES)
def test_it_shows_itself(name, results):
    text = re.sub(r"data:image/[a-z+]+;base64,[^']+", "", results[name]._repr_html_())
    assert "<table>" in text
    assert not any(word in text for word in ("nan", "None", "array("))
    assert len(repr(results[name])) < 4000


@pytest.mark.slow
@pytest.mark.parametrize("name", ["Fit", "Comparison", "Diagnosis", "Waterfall", "Addition"])
def test_a_result_has_a_picture(name, results):
    assert "<img src='data:image/" in results[name]._repr_html_()


@pytest.mark.parametrize("name", [n for n in NAMES if n not in ("Prepared", "Model", "Effect")])
def test_it_plots_itself(name, results):
    figure = results[name].plot()
    labelled = [axes for axes in figure.axes if axes.get_xlabel() or axes.get_ylabel()]
    assert labelled, name


@pytest.mark.parametrize("name", [n for n in NAMES if n not in ("Prepared", "Model", "Effect", "Fourier")])
def test_it_becomes_a_frame(name, results):
    assert len(results[name].to_frame()) > 0


def test_text_stays_text():
    shown = table(["a"], [[HOSTILE]], HOSTILE) + lines(HOSTILE, strong=HOSTILE) + bullets([HOSTILE]) + code(HOSTILE)
    assert HOSTILE not in shown
    assert "&lt;script&gt;" in shown


def test_numbers_stand_right_and_nothing_is_a_dash():
    shown = table(["x"], [[1.23456789], [7], [None], [float("inf")], [True]])
    assert "text-align:right'>1.235" in shown and ">7<" in shown and shown.count("–") == 2 and "True" in shown
