"""What one tries first in Python works, or an ExoidError says what to do instead.

The calls were written down before the code was looked at, as somebody would who has a folder of recordings and has
read one example.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import exoid
from exoid.ground.engines.processes import alone
from exoid.workbench.commands.demo import DATA

NAMES = ("t", "q1", "q2", "tau1", "tau2")
MAGNET = {"torque": "c * dtheta * abs(dtheta)", "coefficients": {"c": exoid.Coefficient("N·m·s²/rad²")}}


class Bench:
    """What somebody has at hand: files, tables, arrays, recordings, and a leg."""

    def __init__(self) -> None:
        pandas = pytest.importorskip("pandas")
        self.files = sorted(map(str, DATA.glob("*.csv")))
        self.frames = [pandas.read_csv(file) for file in self.files]
        self.arrays = [frame[list(NAMES)].to_numpy() for frame in self.frames]
        self.runs = [exoid.read_recording(file) for file in self.files]
        self.leg = exoid.Model.standard()
        self.table = {name: self.arrays[0][:, k] for k, name in enumerate(NAMES)}
        self.stacked = {"t": self.arrays[0][:, 0], "q": self.arrays[0][:, 1:3], "tau": self.arrays[0][:, 3:]}


@pytest.fixture(scope="module")
def bench():
    return Bench()


COMPARED = {
    "a path": lambda b: (b.files[0],),
    "a Path": lambda b: (Path(b.files[0]),),
    "paths": lambda b: (b.files[:1],),
    "a frame": lambda b: (b.frames[0],),
    "a dict": lambda b: (b.table,),
    "a dict of arrays with a column per joint": lambda b: (b.stacked,),
    "an array": lambda b: (b.arrays[0],),
    "a recording": lambda b: (b.runs[0],),
}


@pytest.mark.slow
@pytest.mark.parametrize("called", COMPARED)
def test_the_same_recording_in_any_form_gives_the_same_answer(bench, called):
    first = exoid.compare(bench.leg, [bench.runs[0]])
    found = exoid.compare(bench.leg, *COMPARED[called](bench))
    assert np.array_equal(found.rms, first.rms) and found.verify_rms is None


@pytest.mark.slow
def test_recordings_alone_are_of_the_standard_leg(bench):
    first = exoid.compare(bench.leg, bench.runs[:1])
    for found in (exoid.compare(bench.files[0]), exoid.compare(recordings=bench.frames[0]),
                  exoid.Session(bench.files[:1]).compare()):  # fmt: skip
        assert np.array_equal(found.rms, first.rms)
    with pytest.raises(exoid.ExoidError, match="recordings"):
        exoid.compare("leg.toml")


@pytest.mark.slow
def test_a_file_of_the_folder_that_is_held_out_is_not_fitted(bench):
    held_out = DATA / "verify.csv"
    apart = exoid.compare([*sorted(DATA.glob("train*.csv"))], verify=held_out)
    assert np.array_equal(exoid.compare(DATA, verify=held_out).rms, apart.rms)
    with pytest.raises(exoid.ExoidError, match="held out"):
        exoid.compare([held_out, bench.files[0]], verify=held_out)


HELD_OUT = {
    "a path": lambda b: b.files[3],
    "a frame": lambda b: b.frames[3],
    "an array": lambda b: b.arrays[3],
    "a recording": lambda b: b.runs[3],
    "many": lambda b: [b.files[3]],
}


@pytest.mark.parametrize("called", HELD_OUT)
def test_what_is_held_out_comes_in_any_form_too(bench, called):
    found = exoid.compare(bench.leg, bench.runs[:1], verify=HELD_OUT[called](bench))
    assert found.verify_rms is not None and found.verify_rms[0] > 0.0


@pytest.mark.slow
def test_a_folder_and_a_mixture(bench):
    assert len(exoid.compare(bench.leg, DATA).per_recording) == len(bench.files)
    mixed = exoid.compare(bench.leg, [bench.files[0], bench.frames[1], bench.arrays[2]], verify=bench.runs[3])
    assert [name for name, _ in mixed.per_recording][:3] == ["train_1", "table 2", "table 3"]


READ = {
    "read_recording of an array": lambda b: exoid.read_recording(b.arrays[0]),
    "read_recording of a frame": lambda b: exoid.read_recording(b.frames[0]),
    "read_recordings of a folder": lambda b: exoid.read_recordings(DATA)[0],
    "read_recordings of a mapping": lambda b: len(exoid.read_recordings(dict(b.frames[0]))) == 1,
    "read_recordings of a mixture": lambda b: [
        one.name for one in exoid.read_recordings([b.frames[0], b.files[1], b.arrays[2]])
    ] == ["table 1", "train_2", "table 3"],
    "an array of one joint": lambda b: exoid.prepare(exoid.Model(joints=["axis"]), b.arrays[0][:, [0, 1, 3]]),
    "identify of a path": lambda b: exoid.identify(b.leg, b.files[0], optimisers=()),
    "identify of what is prepared": lambda b: exoid.identify(b.leg, exoid.prepare(b.leg, b.files[0]), optimisers=()),
    "a session": lambda b: exoid.Session(b.leg, b.files[:1], b.frames[3]).fitted(),
    "add by its full name": lambda b: exoid.add(b.leg, "load_friction:knee", b.files[0]),
    "add with a joint": lambda b: exoid.add(b.leg, "load_friction", b.runs[0], joint="knee"),
    "add of one's own": lambda b: exoid.add(b.leg, exoid.Effect("magnet", joints="hip", **MAGNET), b.runs[0]),
    "add without a model": lambda b: exoid.add("load_friction:knee", b.files[:1], b.files[3]).helped,
    "add of one's own without a model": lambda b: exoid.add(exoid.Effect("magnet", joints="hip", **MAGNET), b.runs[0]),
    "add to an answer": lambda b: exoid.add(exoid.compare(b.leg, b.runs[0]), "load_friction:knee", b.runs[0]),
    "a named joint": lambda b: exoid.Model(joints=["axis"]),
    "the leg by names": lambda b: exoid.Model(joints=["hip", "knee"], terms=["stribeck:hip"]),
    "an effect of a model": lambda b: exoid.Model(terms="stribeck:hip").without("stribeck:hip"),
    "the effects of a model": lambda b: exoid.Model(terms="stribeck:hip").effects == ("stribeck:hip",),
    "an Effect with units alone": lambda b: exoid.Effect("m", torque="c * dtheta", coefficients={"c": "N·m·s/rad"}),
    "the version": lambda b: exoid.__version__,
    "a simulated effect": lambda b: exoid.simulate(b.leg, effects="stribeck:hip", duration=5.0),
}


@pytest.mark.slow
@pytest.mark.parametrize("called", READ)
def test_it_works(bench, called):
    assert READ[called](bench)


SAID = {
    "the old order": (lambda b: exoid.add(b.leg, "load_friction", "knee", b.runs), "add(model, 'stribeck:knee'"),
    "a misspelt effect": (lambda b: exoid.add("load_fricton:knee", b.files[:1]), "load_friction"),
    "a misspelt function": (
        lambda b: exoid.Effect("m", torque="c * sinn theta", coefficients={"c": "N·m"}), "unknown function 'sinn'",
    ),
    "no joint": (lambda b: exoid.add(b.leg, "load_friction", b.runs), "load_friction:hip or load_friction:knee"),
    "an Effect of the catalogue": (lambda b: exoid.Effect("stribeck", joints="hip"), "with_effect('stribeck:hip')"),
    "an Effect by its full name": (lambda b: exoid.Effect("stribeck:hip"), "with_effect('stribeck:hip')"),
    "joints without links": (lambda b: exoid.Model(joints=["hip", "knee", "ankle"]), 'Joint("hip", length=0.4)'),
    "joints that are none": (lambda b: exoid.Model(joints=5), 'Joint("hip")'),
    "an effect that is none": (lambda b: exoid.Model(terms=[5]), "stribeck:hip"),
    "an array that lies": (lambda b: exoid.compare(b.leg, b.arrays[0].T), "array.T"),
    "arrays one by one": (lambda b: exoid.compare(b.leg, [b.arrays[0][:, 0]]), "name the columns"),
    "read_recording of a folder": (lambda b: exoid.read_recording(DATA), "read_recordings"),
    "read_recordings of a number": (lambda b: exoid.read_recordings(3), "a int is not read as a recording"),
    "read_recordings of numbers": (lambda b: exoid.read_recordings([b.files[0], 3]), "a int is not read"),
    "a file that is not there": (lambda b: exoid.compare(b.leg, "run_99.csv"), "check the path"),
    "a model that is not there": (lambda b: exoid.compare("no.toml", b.files), "check the path"),
    "a number": (lambda b: exoid.compare(b.leg, 3), "give a recording, a path"),
    "nothing": (lambda b: exoid.compare(b.leg, []), "name at least one recording"),
    "a number among files": (lambda b: exoid.compare(b.leg, [b.files[0], 3]), "number 2 of 2"),
    "the wrong way round": (lambda b: exoid.compare(b.runs, b.leg), "the recordings come second"),
    "no recordings": (lambda b: exoid.discover(b.leg), "after the model, give a recording"),
    "a misspelt setting": (lambda b: exoid.discover(b.leg, b.runs[0], sed=3), "did you mean 'seed'?"),
    "a model file as a name": (lambda b: exoid.Model("leg.toml"), "Model.load('leg.toml')"),
    "a model that is not there, loaded": (lambda b: exoid.Model.load("no.toml"), "check the path"),
    "one rival": (lambda b: exoid.separate(b.leg, "stribeck:hip"), "add a second effect"),
    "an effect as a leg": (lambda b: exoid.simulate(b.leg, "stribeck:hip"), "effects="),
}


@pytest.mark.parametrize("called", SAID)
def test_it_says_what_to_do(bench, called):
    call, remedy = SAID[called]
    with pytest.raises(exoid.ExoidError) as caught:
        call(bench)
    assert remedy in str(caught.value)


def test_a_model_is_saved_and_loaded(bench, tmp_path):
    leg = bench.leg.with_effect("stribeck:hip")
    leg.save(tmp_path / "leg.toml")
    again = exoid.Model.load(tmp_path / "leg.toml")
    assert again.effects == leg.effects and again.joints == leg.joints


def _known_there(model):
    """Ask in another process what a model is taken for there."""
    return [joint.name for joint in model.chain], model.with_effect("stribeck", model.joint_names[-1]).terms[0].name


def test_a_model_is_the_same_machine_in_another_process(bench):
    engine = alone()
    try:
        asked = [engine.executor.submit(_known_there, m) for m in (bench.leg, exoid.Model(joints=["axis"]))]
        assert [one.result() for one in asked] == [([], "stribeck:knee"), (["axis"], "stribeck:axis")]
        rotor = engine.executor.submit(bench.leg.with_effect, "rotor_inertia:knee").result()
        assert rotor.chain == ()
    finally:
        engine.close(False)


WRONG = {
    "a keyword of a verb": lambda b: exoid.compare(b.leg, b.files, verfy=b.runs),
    "a keyword of a model": lambda b: exoid.Model(joint=["hip"]),
    "a way to read": lambda b: exoid.read_recording(b.files[0], unitz={}),
    "a recording without a name": lambda b: exoid.Recording(**b.stacked),
}


@pytest.mark.parametrize("called", WRONG)
def test_a_call_that_does_not_fit_is_pythons_type_error(bench, called):
    with pytest.raises(TypeError, match=r"unexpected keyword|missing \d required"):
        WRONG[called](bench)


@pytest.mark.slow
def test_results_report_themselves_and_show_the_fall(bench, tmp_path):
    found = exoid.diagnose(bench.leg, bench.files[:2], verify=bench.files[3])
    assert [one.name for one in found.accepted] == ["load_friction:knee"]
    shown = found._repr_html_()
    assert "data:image/svg+xml" in shown and "linear-gradient" in shown  # which follows light and dark
    assert not any(word in shown for word in ("color:#", "background:#", "background-color"))
    page = found.report(tmp_path / "out")
    assert page == tmp_path / "out" / "report.html" and "load_friction" in page.read_text("utf-8")
    added = exoid.add(found, "stribeck:hip", bench.files[0])
    for number, other in enumerate((added, added.waterfall, exoid.compare(bench.leg, bench.files[0]))):
        assert other.report(tmp_path / str(number)).stat().st_size > 10_000
