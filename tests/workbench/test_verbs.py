"""What each verb does with the answers of the packages below, which are stood in for."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from workbench_fakes import FakeComparison, FakeDiagnosis, FakeFit, FakeModel

from exoid.diagnosis.extend import Addition, Waterfall
from exoid.symbolic.formula import pretty
from exoid.symbolic.model import Model
from exoid.workbench import commands
from exoid.workbench.command import main
from exoid.workbench.terminal.screen import Screen
from exoid.workbench.terminal.showing import show_limit, truth_sentence

DATA = Path(commands.__file__).parents[1] / "demo_data"
TRAIN, VERIFY = str(DATA / "train_1.csv"), str(DATA / "verify.csv")


@pytest.fixture
def stand_in(monkeypatch):
    """Put a function in the place of `diagnosis.<module>.<name>`."""

    def put(module, name, answer):
        calls = []

        def function(*arguments, **named):
            calls.append((arguments, named))
            if named.get("progress"):
                named["progress"](0.5, "half way")
            return answer

        monkeypatch.setitem(sys.modules, f"exoid.diagnosis.{module}", SimpleNamespace(**{name: function}))
        return calls

    return put


class FakeAddition(Addition):
    def to_json(self):
        return {"helped": self.helped}


@pytest.fixture
def addition(stand_in, monkeypatch, tmp_path):
    """`exoid.diagnosis.extend.add` and a model writer, standing in."""
    monkeypatch.chdir(tmp_path)
    written = []

    def write_model(model, path, fit=None):
        written.append(str(path))
        Path(path).write_text("name = 'x'\n", "utf-8")

    monkeypatch.setitem(sys.modules, "exoid.symbolic.model_file", SimpleNamespace(write_model=write_model))

    def put(helped):
        steps = FakeDiagnosis().steps[:2]
        fall = Waterfall(steps, np.array([0.5, 0.5]), Model.standard(), "it was asked for one.")
        found = FakeAddition(
            FakeModel(), FakeFit(estimates=()), FakeFit(), fall,
            "The unseen error of the knee falls from 0.98 to 0.58 N·m.", helped, "numpy",
        )  # fmt: skip
        stand_in("extend", "add", found)
        return written

    return put


def test_compare_shows_size_and_place(stand_in, capsys):
    stand_in("comparison", "compare", FakeComparison())
    assert main(["compare", TRAIN, "--verify", VERIFY]) == 0
    out = capsys.readouterr().out
    assert "0.58" in out
    assert "starts or reverses" in out


@pytest.mark.parametrize(("limit", "status"), [("0.8", 0), ("0.8,0.5", 1), ("0.1", 1)])
def test_a_limit_that_is_not_met_ends_with_1(limit, status, stand_in, capsys):
    stand_in("comparison", "compare", FakeComparison())
    assert main(["compare", TRAIN, "--verify", VERIFY, "--limit", limit]) == status


def test_an_error_that_is_not_a_number_meets_no_limit():
    assert show_limit(Screen(silent=True), (1.0, 1.0), [0.5, float("nan")], "N·m")
    assert not show_limit(Screen(silent=True), None, [float("nan"), 0.0], "N·m")


@pytest.mark.parametrize("verb", ["diagnose", "discover"])
def test_json_alone_on_standard_output(verb, stand_in, capsys):
    calls = stand_in("discovery", verb, FakeDiagnosis())
    assert main([verb, TRAIN, "--verify", VERIFY, "--seed", "5", "--json", "-"]) == 0
    found = json.loads(capsys.readouterr().out, parse_constant=pytest.fail)
    assert found["schema"] == "exoid.discovery/1"
    assert found["accepted"][0]["parameters"]["stribeck:knee.c"]["high"] is None
    assert calls[0][1]["seed"] == 5


@pytest.mark.slow
def test_json_file_report_and_table_together(stand_in, tmp_path, capsys):
    stand_in("discovery", "discover", FakeDiagnosis())
    stand_in("comparison", "compare_prepared", FakeComparison())
    arguments = ["--out", str(tmp_path / "r"), "--json", str(tmp_path / "x.json")]
    assert main(["discover", TRAIN, "--verify", VERIFY, *arguments]) == 0
    out = capsys.readouterr().out
    assert "Found: Stribeck friction at the knee; very sure" in out
    assert "noise floor" in out
    assert (tmp_path / "r" / "report.html").is_file()
    assert json.loads((tmp_path / "x.json").read_text("utf-8")) == json.loads(
        (tmp_path / "r" / "result.json").read_text("utf-8")
    )


def test_quiet_says_nothing(stand_in, capsys):
    stand_in("discovery", "diagnose", FakeDiagnosis())
    assert main(["diagnose", TRAIN, "--quiet"]) == 0
    assert capsys.readouterr().out == ""


@pytest.mark.parametrize(("helped", "status"), [(True, 0), (False, 1)])
def test_add_writes_a_new_model_and_judges_by_unseen_motion(helped, status, addition, capsys):
    written = addition(helped)
    assert main(["add", "stribeck:knee", TRAIN, "--verify", VERIFY]) == status
    assert written == ["leg+stribeck-knee.toml"]
    assert main(["add", "stribeck:knee", TRAIN, "--verify", VERIFY]) == status
    assert written[1] == "leg+stribeck-knee-2.toml"
    assert "0.58" in capsys.readouterr().out


def test_add_puts_the_model_into_a_folder_that_is_new(addition, tmp_path):
    written = addition(True)
    assert main(["add", "stribeck:knee", TRAIN, "--verify", VERIFY, "--out", "new/folder", "--quiet"]) == 0
    assert written == ["new/folder/model.toml"]
    assert (tmp_path / "new" / "folder" / "result.json").exists()


def test_add_never_overwrites_the_model_it_comes_from(tmp_path, monkeypatch, capsys):
    model = tmp_path / "leg.toml"
    model.write_text('name = "my leg"\n', "utf-8")
    assert main(["add", "stribeck:knee", TRAIN, "--model", str(model), "--write", str(model)]) == 2
    assert "overwrite" in capsys.readouterr().err
    assert model.read_text("utf-8") == 'name = "my leg"\n'


@pytest.mark.slow
def test_demo_opens_the_seal_and_writes_the_report(stand_in, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    stand_in("discovery", "discover", FakeDiagnosis())
    stand_in("comparison", "compare_prepared", FakeComparison())
    control = SimpleNamespace(sentence="It follows better.", to_json=dict, figures=list)
    monkeypatch.setattr("exoid.workbench.commands.demo._control", lambda *_: control)
    assert main(["demo"]) == 0
    out = capsys.readouterr().out
    assert "load_friction:knee" in out
    assert (tmp_path / "exoid-demo" / "report.html").is_file()


@pytest.mark.slow
def test_simulate_identify_and_reveal(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["simulate", "--blind", "--runs", "2", "--duration", "5", "--out", "b", "--seed", "3"]) == 0
    shown = capsys.readouterr().out
    assert main(["reveal", "b/truth.seal", "b/run_0.csv", "--json", "-"]) == 0
    effects = json.loads(capsys.readouterr().out)["effects"]
    assert all(one["id"] not in shown for one in effects)
    assert main(["simulate", "--runs", "2", "--out", "b"]) == 2
    walk = ["simulate", "--wearer", "--walk", "--runs", "1", "--duration", "4", "--quiet", "--measured"]
    assert main([*walk, "cuffs, switch", "--out", "w"]) == 0
    assert Path("w/run_0.csv").read_text().startswith("t,q1,q2,tau1,tau2,f1,f2,contact\n")
    assert main([*walk, "plates", "--out", "v"]) == 2 and not Path("v").exists()
    assert "exists already" in capsys.readouterr().err
    assert main(["identify", "b/run_0.csv", "b/run_1.csv", "--limit", "0.0001", "--json", "fit.json"]) == 1
    found = json.loads(Path("fit.json").read_text("utf-8"), parse_constant=pytest.fail)
    assert found["schema"] == "exoid.fit/1"
    assert "Phi1" in capsys.readouterr().out


def test_what_is_hidden_by_name_is_shown_with_its_sizes_and_kept(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    asked = ["simulate", "--effect", "stribeck:knee=2.5", "--runs", "1", "--duration", "5", "--out", "a"]
    assert main([*asked, "--json", "made.json"]) == 0
    assert "stribeck:knee (c = 2.5, v_s = " in capsys.readouterr().out
    made = json.loads(Path("made.json").read_text("utf-8"))
    assert made["truth"]["effects"][0]["values"]["c"] == 2.5
    assert main(["reveal", made["seal"], *made["recordings"]]) == 0
    assert "stribeck:knee (c = 2.5, v_s = " in capsys.readouterr().out


def test_without_generated_files_only_the_equations_are_checked(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["generate", "--check"]) == 0
    assert "only the equations are checked" in capsys.readouterr().out
    assert list(tmp_path.iterdir()) == []


def test_generate_prints_the_equations_and_writes_no_code(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["generate", "--print"]) == 0
    assert "M[1,1] = Phi1 + 2*Phi3*cos(theta2)" in capsys.readouterr().out
    assert main(["generate", "--print", "--as", "latex", "--out", "equations", "--json", "-"]) == 0
    written = (tmp_path / "equations" / "equations_latex.tex").read_text("utf-8")
    found = json.loads(capsys.readouterr().out)
    assert written == "% Written by exoid.\n" + found["text"] and r"\ddot{\theta}_{1}" in written
    assert found["parameters"]["Phi3"] == {"unit": "kg·m²", "meaning": "a_th*l_sh*m_sh"}
    assert [path.name for path in tmp_path.iterdir()] == ["equations"]


def test_a_format_without_print_is_told(capsys):
    assert main(["generate", "--as", "latex"]) == 2
    assert "add --print" in capsys.readouterr().err


def test_generate_writes_once_and_checks(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["generate", "--check", "--out", "g"]) == 1
    assert not Path("g").exists()
    assert main(["generate", "--out", "g", "--json", "-"]) == 0
    out = capsys.readouterr().out
    assert json.loads(out[out.index("{") :])["files"] == {"leg.c": "new", "leg.h": "new", "manifest.json": "new"}
    assert main(["generate", "--check", "--out", "g"]) == 0
    assert main(["generate", "--out", "g"]) == 0
    assert "unchanged" in capsys.readouterr().out


def test_truth_as_a_sentence():
    assert truth_sentence(SimpleNamespace(effects=())) == "nothing was hidden."
    one = SimpleNamespace(term="stribeck:hip", values={"c": 2.6, "v_s": 0.15})
    assert truth_sentence(SimpleNamespace(effects=(one,))) == "stribeck:hip (c = 2.6, v_s = 0.15) was hidden."


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("c * dtheta * abs(dtheta)", "c·θ′·|θ′|"),
        ("k * (theta1 + theta2)", "k·(θ₁ + θ₂)"),
        ("c * dtheta**3", "c·θ′³"),
        ("c * ddtheta2", "c·θ″₂"),
        ("c * abs(tau_rigid) * sgn(dtheta)", "c·|τ_rigid|·sgn(θ′)"),
        ("c * theta ** 0.5", "c·θ^0.5"),
    ],
)
def test_formulas_read_like_handwriting(text, shown):
    assert pretty(text) == shown


@pytest.mark.slow
def test_watch_names_what_appears(tmp_path, monkeypatch, capsys):
    from exoid.measurement.bench.hidden import Hidden
    from exoid.measurement.bench.simulation import Bench, run_bench
    from exoid.measurement.trajectories.trajectory import random_trajectory

    monkeypatch.chdir(tmp_path)
    path = random_trajectory(np.random.default_rng(1), period=47.0, harmonics=24)
    runs = [
        run_bench(effects=effects, seed=1, excitation=path, bench=Bench(duration=180.0)).recording
        for effects in ((), (Hidden("load_friction", "knee", {"c": 0.2}),))
    ]
    rows = [np.column_stack([r.t, r.q, r.tau]) for r in runs]
    lines = ["t,q1,q2,tau1,tau2", *(",".join(map(repr, map(float, row))) for row in np.vstack([rows[0][:11000],
             rows[1][11000:]]))]  # fmt: skip
    lines.insert(5, "not,a,sample")
    Path("live.csv").write_text("\n".join(lines), "utf-8")
    assert main(["watch", "standard", "live.csv", "--learn", "60", "--json", "events.json", "--quiet"]) == 1
    events = [json.loads(line) for line in Path("events.json").read_text("utf-8").splitlines()]
    assert events[0]["event"] in ("start", "skipped")
    assert events[-1]["event"] == "summary"
    changes = [e for e in events if e["event"] == "change"]
    found = {d["name"] for d in changes[-1]["differences"]}
    alike = {n for d in changes[-1]["differences"] for n in d["look_alikes"]}
    assert "load_friction:knee" in found | alike
    assert 110.0 < changes[0]["t"] < 160.0  # five blocks
    assert changes[0]["since"]["low"] - 12.0 < 110.0 < changes[0]["since"]["high"] + 12.0
    assert "not" not in capsys.readouterr().out
