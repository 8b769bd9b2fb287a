"""Drop files and get the answer: two legs in degrees, another header in one of them, one click."""

from __future__ import annotations

import math

import numpy as np
import pytest
from playwright.sync_api import expect

from exoid.workbench.commands.demo import DATA

pytestmark = pytest.mark.slow  # a browser, and fits behind it


def both_legs(source, target, more):
    """Write a demo recording as the left leg of a file of two, in degrees, and its mirror image as the right."""
    run = np.genfromtxt(source, delimiter=",", names=True)
    columns, names = [run["t"]], ["Time [s]"]
    for side, turn in (("L", 1), ("R", -1)):
        for joint, q, tau in (("Hip", "q1", "tau1"), ("Knee", "q2", "tau2")):
            columns += [np.degrees(run[q][::turn]), run[tau][::turn]]
            names += [f"{side}_{joint}_Angle [deg]", f"{side}_{joint}_Torque [Nm]"]
    columns, names = [*columns, np.sin(3.0 * run["t"])], [*names, f"EMG{more}"]
    np.savetxt(target, np.column_stack(columns), delimiter=",", header=",".join(names), comments="", fmt="%.7g")
    return target


def test_files_of_two_legs_are_answered_after_one_click(serve, visit, tmp_path, monkeypatch):
    monkeypatch.setenv("EXOID_CACHE", str(tmp_path / "cache"))  # what other runs were told is not known
    sources = [*sorted(DATA.glob("train*.csv")), DATA / "verify.csv"]
    files = [both_legs(one, tmp_path / f"trial_{k}.csv", " raw" * (k == 2)) for k, one in enumerate(sources)]
    page = visit(serve().url)
    page.get_by_test_id("pick-files").set_input_files(files)
    dialog = page.get_by_test_id("map-dialog")
    dialog.wait_for()
    expect(page.get_by_test_id("map-q1")).to_have_value("L_Hip_Angle")
    expect(dialog).not_to_contain_text("--leg")
    page.get_by_test_id("side-left").click()

    verdict = page.get_by_test_id("verdict")
    expect(verdict).to_have_attribute("data-verdict", "missing")
    expect(verdict).to_contain_text("Load-dependent friction at the knee")
    expect(verdict).to_contain_text("very sure")
    expect(dialog).to_have_count(0)  # the file with another header was read as told of the first
    roles = [one.input_value() for one in page.locator("ul.files select").all()]
    assert roles == ["fit", "fit", "fit", "verify"]

    # One screen: sentence, plots, suspects and steps stand on it without scrolling.
    page.set_viewport_size({"width": 1280, "height": 900})
    for place in ("#verdict", "#compare", "#history"):
        box = page.locator(place).bounding_box()
        assert box["y"] >= 0.0 and math.floor(box["y"] + box["height"]) <= 900, place
    assert page.evaluate("document.body.scrollHeight <= innerHeight")

    # Any column, by keyboard to a suspect, and a link that leads back to what was looked at.
    page.get_by_test_id("further-column").focus()
    page.get_by_test_id("further-column").select_option("EMG")
    expect(page.get_by_test_id("column-EMG")).to_have_attribute("data-drawn", "true")
    page.locator("body").click(position={"x": 2, "y": 2})
    page.keyboard.press("j")
    expect(page.get_by_test_id("detail")).to_be_visible()
    page.keyboard.press("f")
    expect(page.locator("#side")).to_be_hidden()
    again = visit(page.url, context=page.context)
    expect(again.get_by_test_id("detail")).to_be_visible()
    expect(again.locator("#side")).to_be_hidden()  # the layout is remembered


def test_a_joint_without_a_drive_is_said_in_the_dialog(serve, visit, tmp_path, monkeypatch):
    monkeypatch.setenv("EXOID_CACHE", str(tmp_path / "cache"))
    for source in sorted(DATA.glob("*.csv")):
        rows = np.genfromtxt(source, delimiter=",", names=True)
        table = np.column_stack([rows["t"], rows["q1"], rows["q2"], rows["tau1"]])
        np.savetxt(tmp_path / source.name, table, delimiter=",", header="t,q1,q2,tau1", comments="", fmt="%.7g")
    page = visit(serve().url)
    page.get_by_test_id("pick-files").set_input_files(sorted(tmp_path.glob("*.csv")))
    dialog = page.get_by_test_id("map-dialog")
    expect(dialog).to_contain_text("choose “no drive” for the torque of the knee")
    page.get_by_test_id("map-tau2").select_option("no drive: the knee swings freely")
    page.get_by_test_id("map-apply").click()
    expect(dialog).to_have_count(0)
    expect(page.locator("ul.files .finding.refused")).to_have_count(0)  # the others are read as told of the first
