"""Each command and its function in Python give the same answer to the same question."""

from __future__ import annotations

import json

import numpy as np
import pytest

import exoid
from exoid.apps.campaign.engines.local import local
from exoid.apps.campaign.plan import read_plan
from exoid.apps.campaign.run import run_campaign
from exoid.apps.watch.settings import Settings
from exoid.diagnosis.question import own_effects
from exoid.symbolic.codegen.code import generate
from exoid.workbench.command import main
from exoid.workbench.exporting import exporter
from exoid.workbench.identified import Options, read_ready

LEG = """\
name = "my leg"

[[custom_effects]]
id = "magnet_brake"
joint = "knee"
torque = "c * dtheta * exp(-((theta + 0.9)/w)**2)"
coefficients = { c = { unit = "N·m·s/rad", min = 0 } }
shape = { w = { unit = "rad", min = 0.05, max = 0.6 } }
explains = "eddy-current brake near mid-flexion"
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Three recordings of a leg with a brake that no catalogue knows, and a model file that declares it."""
    place = tmp_path_factory.mktemp("both")
    (place / "leg.toml").write_text(LEG, encoding="utf-8")
    brake = exoid.read_model(place / "leg.toml").custom[0]
    hidden = (exoid.Hidden(brake, "knee", {"c": 3.0, "w": 0.2}),)
    for k, run in enumerate(exoid.simulate_runs(3, effects=hidden, seed=5, bench=exoid.Bench(duration=12.0))):
        exoid.write_recording(run.recording, place / f"run{k}.csv")
    return place


@pytest.fixture
def given(folder, monkeypatch):
    """The model, the recordings to fit and the unseen one, read as the command reads them."""
    monkeypatch.chdir(folder)
    runs = [exoid.read_recording(f"run{k}.csv") for k in range(3)]
    return exoid.read_model("leg.toml"), runs[:2], runs[2:]


FILES = ["run0.csv", "run1.csv", "--verify", "run2.csv", "--model", "leg.toml"]


def by_command(*words):
    status = main([*words, "--json", "answer.json", "--quiet"])
    assert status in (0, 1)
    with open("answer.json", encoding="utf-8") as stream:
        return json.load(stream)


def plain(value):
    """Return `value` as JSON keeps it, without what a clock says."""
    if isinstance(value, dict):
        return {key: plain(one) for key, one in value.items() if key not in ("seconds", "schema")}
    if isinstance(value, list):
        return [plain(one) for one in value]
    return value


def same(command, result, *beyond):
    """Whether the command's JSON is that of the result, but for the keys `beyond` that only the command can know."""
    said = {key: value for key, value in plain(command).items() if key not in beyond}
    return said == plain(json.loads(json.dumps(result.to_json())))


def test_compare(given):
    model, train, verify = given
    assert same(by_command("compare", *FILES), exoid.compare(model, train, verify))


@pytest.mark.slow
def test_compare_before_against_after(given):
    model, train, verify = given
    words = ("compare", "run0.csv", "run1.csv", "--against", "run2.csv", "--model", "leg.toml", "--seed", "4")
    found = exoid.compare_against(model, train, verify, seed=4, extra=model.custom)
    assert same(by_command(*words), found)


@pytest.mark.slow
def test_identify(given):
    model, train, verify = given
    fit = exoid.identify(model, exoid.prepare(model, train, verify).train)
    command, alone = plain(by_command("identify", *FILES)), plain(json.loads(json.dumps(fit.to_json())))
    cautions = command.pop("plausibility")  # the command adds what neighbouring cut-offs and unseen motion say
    assert cautions[: len(alone["plausibility"])] == alone.pop("plausibility")
    assert {key: command[key] for key in alone} == alone


@pytest.mark.slow
def test_add(given):
    model, train, verify = given
    command = by_command("add", "stribeck:knee", *FILES, "--write", "extended.toml")
    assert same(command, exoid.add(model, "stribeck:knee", train, verify), "model_file")


def test_a_declared_effect_is_suspected_once_wherever_it_is_named(given):
    model, *_ = given
    assert model.custom and not model.terms
    for extra in ((), model.custom):
        for asked in (model, model.with_effect(model.custom[0], "knee")):
            assert [effect.id for effect in own_effects(asked, extra)] == ["magnet_brake"]


@pytest.mark.slow
def test_diagnose_suspects_a_declared_effect(given):
    model, train, verify = given
    command = by_command("diagnose", *FILES)
    found = exoid.diagnose(model, train, verify)
    assert same(command, found)
    assert [a.name for a in found.accepted] == ["magnet_brake:knee"]


@pytest.mark.slow
def test_discover(given):
    model, train, verify = given
    assert same(by_command("discover", *FILES), exoid.discover(model, train, verify))


@pytest.mark.slow
def test_design(given):
    model, *_ = given
    command = by_command("design", "leg.toml", "--seed", "3")
    assert same(command, exoid.design(model, seed=3))


@pytest.mark.slow
def test_separate(given):
    model, train, _ = given
    rivals = ["stribeck:hip", "viscous_quadratic:hip"]
    command = by_command("design", "run0.csv", "run1.csv", "--model", "leg.toml", "--separate", ",".join(rivals))
    assert same(command, exoid.separate(model, rivals, train))


@pytest.mark.slow
def test_rivals(given):
    model, train, _ = given
    fit = exoid.identify(model, exoid.prepare(model, train).train, optimisers=())
    command = by_command(
        "rivals", "run0.csv", "run1.csv", "--model", "leg.toml", "--seeds", "2", "--generations", "20", "--jobs", "1"
    )
    found = exoid.rivals(fit, seeds=2, generations=20, jobs=1)
    gaps = {name: one["gaps"] for name, one in command["optimisers"].items()}
    assert gaps == {name: found.gaps(name).tolist() for name in found.outcomes}


@pytest.mark.slow
def test_simulate(given):
    asked = "simulate leg.toml --effect stribeck:hip=2.6 --runs 2 --duration 5 --seed 9 --out made --quiet"
    assert main(asked.split()) == 0
    hidden = (exoid.Hidden("stribeck", "hip", size=2.6),)
    model = exoid.read_model("leg.toml")
    runs = exoid.simulate_runs(2, model, effects=hidden, seed=9, bench=exoid.Bench(duration=5.0))
    for k, run in enumerate(runs):
        assert np.array_equal(run.recording.tau, exoid.read_recording(f"made/run_{k}.csv").tau)


def test_generate(given):
    command = by_command("generate", "leg.toml", "--out", "code")
    files = generate(given[0]).files
    assert set(command["files"]) == set(files)
    for name, text in files.items():
        with open(f"code/{name}", encoding="utf-8") as stream:
            assert stream.read() == text


@pytest.mark.slow
def test_export(given):
    assert main(["identify", "run0.csv", "run1.csv", "--model", "leg.toml", "--write", "ready.toml", "--quiet"]) == 0
    command = by_command("export", "ready.toml", "--format", "numpy", "casadi", "--out", "exported")
    ready = read_ready("ready.toml")
    for name, written in command["files"].items():
        files = exporter(name).write(ready, Options("exoid_leg", None, 0.0))
        assert written == sorted(files)
        for file, text in files.items():
            with open(f"exported/{file}", encoding="utf-8") as stream:
                assert stream.read() == text


@pytest.mark.slow
def test_watch(folder, monkeypatch):
    monkeypatch.chdir(folder)
    exoid.write_recording(exoid.simulate_runs(1, seed=5, bench=exoid.Bench(duration=26.0))[0].recording, "long.csv")
    words = "watch standard long.csv --learn 20 --seed 2 --json events.json --quiet"
    assert main(words.split()) == 0
    with open("events.json", encoding="utf-8") as stream:
        command = [plain(json.loads(line)) for line in stream]
    settings = Settings(learn=4, most_learn=12, seed=2)
    found = exoid.watch(exoid.Model.standard(), exoid.read_recording("long.csv"), settings)
    assert [(one["event"], one["sentence"]) for one in command] == [(one.event, one.sentence) for one in found]


@pytest.mark.slow
def test_campaign(given):
    model, train, verify = given
    with open("plan.toml", "w", encoding="utf-8") as stream:
        stream.write('verb = "compare"\nfiles = "run{run}.csv"\ngroup = []\nverify = 1\nmodel = "leg.toml"\n')
    engine = local(1)
    found = run_campaign(read_plan("plan.toml"), "fleet", engine)
    engine.close(True)
    result = {key: value for key, value in found.rows[0]["result"].items() if key not in ("schema", "seconds")}
    assert result == plain(json.loads(json.dumps(exoid.compare(model, train, verify).to_json())))
    command = by_command("campaign", "plan.toml", "--out", "fleet")
    assert command["rows"] == found.to_json()["rows"] and command["kept"] == 1


def test_effects(given):
    command = by_command("effects")
    assert [one["id"] for one in command["effects"]] == list(exoid.catalogue())
