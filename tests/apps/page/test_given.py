"""What the mapping dialog is told of a file."""

from __future__ import annotations

import json
from types import SimpleNamespace

import numpy as np
import pytest

from exoid.apps.page.given import Given, keep_mappings, mapping_preview, read_as_others, read_given, told_of_all
from exoid.apps.page.numbers import column_of
from exoid.diagnosis import Session
from exoid.ground.errors import RecordingError
from exoid.measurement.reading.columns import canonical_columns
from exoid.measurement.reading.mapping import StatedMapping, remember, remembered
from exoid.symbolic import Model
from exoid.symbolic.joints import LEG, Joint
from exoid.workbench.commands.demo import DATA

SLIDE = (Joint("cart", kind="prismatic"), Joint("pole"))


@pytest.mark.parametrize(("joints", "units"), [(LEG, ["rad", "N·m"]), (SLIDE, ["m", "N"])])
def test_every_column_that_may_be_there_is_asked_for_in_its_unit(joints, units):
    shown = mapping_preview(Given(1, "run.csv", DATA / "train_1.csv"), joints)
    assert [one["name"] for one in shown["wanted"]] == list(canonical_columns(joints))
    si = {one["name"]: one["si"] for one in shown["wanted"]}
    assert [si["q1"], si["tau1"]] == units and si["q2"] == "rad"
    assert shown["guess"]["q1"]["column"] == "q1" and len(shown["columns"][0]["first"]) > 2


def both_legs(path, more=""):
    """Write a recording with the columns of two legs, in degrees, and one that nobody needs."""
    quantities = ("Angle [deg]", "Torque [Nm]")
    names = ["Time [s]", *(f"{s}_{j}_{q}" for s in "LR" for j in ("Hip", "Knee") for q in quantities)]
    rows = [line.split(",")[:5] for line in (DATA / "train_1.csv").read_text("utf-8").splitlines()[1:400]]
    degrees = [[float(x) * (57.29578 if 1 <= k <= 2 else 1.0) for k, x in enumerate(row)] for row in rows]
    lines = [[t, q1, m1, q2, m2, q1, -m1, q2, -m2, k % 7] for k, (t, q1, q2, m1, m2) in enumerate(degrees)]
    text = [",".join([*names, f"EMG{more}"]), *(",".join(map(str, line)) for line in lines)]
    path.write_text("\n".join(text) + "\n", encoding="utf-8")
    return path


def test_of_two_legs_one_is_pressed_and_everything_the_reader_knows_is_filled_in(tmp_path):
    shown = mapping_preview(Given(1, "run.csv", both_legs(tmp_path / "run.csv")), LEG)
    assert shown["sides"] == ["left", "right"]
    assert shown["guess"]["q1"] == {"column": "L_Hip_Angle", "unit": "deg"}
    assert shown["guesses"]["right"]["tau2"] == {"column": "R_Knee_Torque", "unit": "Nm"}


def test_an_answer_is_carried_over_to_files_with_another_header(tmp_path):
    other = read_given(Given(2, "b.csv", both_legs(tmp_path / "b.csv", " raw")), tmp_path / "maps")
    assert other.error is not None and "more than one leg" in str(other.error)
    read = read_as_others(other, [StatedMapping(columns={"q1": "elsewhere"}), StatedMapping(leg="left")])
    assert read.error is None and read.told.leg == "left" and [one.name for one in read.recordings] == ["b"]
    both = read_as_others(other, [StatedMapping(leg="both")])
    assert [one.name for one in both.recordings] == ["b (left)", "b (right)"]
    assert read_as_others(other, [StatedMapping(columns={"q1": "EMG raw"})]) is other


def test_any_column_of_a_file_can_be_drawn_on_the_time_of_the_plots(tmp_path):
    given = read_as_others(Given(1, "a.csv", both_legs(tmp_path / "a.csv")), [StatedMapping(leg="left")])
    session = Session(Model.standard(), given.recordings)
    workspace = SimpleNamespace(given=[given])
    content = column_of(workspace, session, 0, "EMG")
    size = int.from_bytes(content[:4], "little")
    head, values = json.loads(content[4 : 4 + size]), np.frombuffer(content[4 + size :], "<f4")
    assert head["column"] == "EMG" and values.size == head["count"] == len(session.prepared.all[0].t)
    assert np.nanmin(values) == 0.0 and np.nanmax(values) == 6.0
    with pytest.raises(RecordingError, match="no column"):
        column_of(workspace, session, 0, "nothing")


def test_a_further_file_is_read_in_the_convention_of_the_others(tmp_path):
    def given(number, convention):
        return Given(number, f"{number}.csv", tmp_path, told=StatedMapping(convention=convention))

    assert told_of_all([]) == StatedMapping()
    assert told_of_all([given(1, "flexion-positive")] * 2) == StatedMapping(convention="flexion-positive")
    assert told_of_all([given(1, "flexion-positive"), given(2, "")]) == StatedMapping()


def test_what_was_mapped_before_is_kept_for_files_with_these_columns(tmp_path):
    names = ["t", "A", "B", "M", "N"]
    told = StatedMapping({"q1": "A", "q2": "B", "tau1": "M", "tau2": "N"})
    kept = remember(tmp_path, names, told)
    keep_mappings(tmp_path / "cache", kept)
    assert remembered(tmp_path / "cache", names) == told
    kept.write_text("[[recordings]]\nheader = 3\n", encoding="utf-8")
    with pytest.raises(RecordingError):
        keep_mappings(tmp_path / "cache", kept)


def test_a_product_of_columns_is_shown_and_carried_over(tmp_path):
    first, second = tmp_path / "a.csv", tmp_path / "b.csv"
    run = np.genfromtxt(sorted(DATA.glob("train*.csv"))[0], delimiter=",", names=True)
    for path, more in ((first, ""), (second, ",lamp")):
        rows = np.column_stack([run["t"], run["q1"], run["q2"], run["tau1"] / 24, 24 + 0 * run["t"], run["tau2"]])
        rows = np.column_stack([rows, run["t"]]) if more else rows
        np.savetxt(path, rows, delimiter=",", header="t,q1,q2,duty,volts,tau2" + more, comments="", fmt="%.9g")
    told = StatedMapping({"tau1": "duty*volts"}, {"tau1": "Nm*1"})
    one = read_given(Given(1, "a.csv", first, told=told), tmp_path / "none")
    assert mapping_preview(one, LEG)["guess"]["tau1"]["column"] == "duty*volts"
    other = read_as_others(Given(2, "b.csv", second), [told])
    np.testing.assert_allclose(other.recordings[0].tau[:, 0], run["tau1"], rtol=1e-6)
