"""What may go wrong on the page: strange files, hostile names, wrong torques, second thoughts, two tabs, a reload."""

from __future__ import annotations

import signal
import uuid

import pytest
from playwright.sync_api import expect

from exoid.apps.page.saved import is_session
from exoid.workbench.commands.demo import DATA
from tests.apps.page.test_story import number, wait_ready

pytestmark = pytest.mark.slow  # a browser, and fits behind it

PRESS = """(button) => new MutationObserver((_, observer) => {
  if (document.querySelector(button)) { observer.disconnect(); document.querySelector(button).click(); }
}).observe(document.body, { childList: true, subtree: true })"""
"""Presses a button as soon as it is there."""

SCRIPT = "<img src=x onerror=window.hacked=1>"


def renamed(source, target, header, rows=None):
    """Write the recording `source` to `target` under another header line."""
    lines = source.read_text().splitlines()[: rows and rows + 1]
    target.write_text("\n".join([header, *lines[1:]]) + "\n", encoding="utf-8")
    return target


def test_a_strange_file_is_mapped_once_and_no_name_is_markup(serve, visit, tmp_path):
    header = f"Uhr {uuid.uuid4().hex},{SCRIPT},B,M1,M2"  # what one run was told is remembered by the next
    files = [
        renamed(DATA / "train_1.csv", tmp_path / f"a {SCRIPT.replace('/', '')}.csv", header),
        renamed(DATA / "train_2.csv", tmp_path / "b.csv", header),
    ]
    page = visit(serve().url, width=380)
    page.get_by_test_id("pick-files").set_input_files(files)
    dialog = page.get_by_test_id("map-dialog")
    dialog.wait_for()
    expect(dialog).to_contain_text(SCRIPT)
    page.get_by_test_id("map-apply").click()
    expect(page.get_by_test_id("map-error")).to_contain_text("no column for")
    for name, column in zip(("t", "q1", "q2", "tau1", "tau2"), header.split(","), strict=True):
        page.get_by_test_id(f"map-{name}").select_option(column)
    page.get_by_test_id("map-apply").click()
    expect(dialog).to_have_count(0)
    wait_ready(page)  # the second file was read in the same way
    expect(page.get_by_test_id("recordings").locator(".finding.refused")).to_have_count(0)
    expect(page.get_by_test_id("recordings")).to_contain_text(SCRIPT)
    expect(page.get_by_test_id("verdict")).to_contain_text("Nothing is held out")
    assert page.evaluate("window.hacked === undefined && document.querySelector('img') === null")
    assert page.evaluate("document.documentElement.scrollWidth") <= 380


def test_a_file_without_a_clock_asks_for_its_rate_and_the_next_one_has_it_too(serve, visit, tmp_path):
    files = []
    for name in ("train_1.csv", "train_2.csv"):
        lines = (DATA / name).read_text().splitlines()
        (tmp_path / name).write_text("\n".join(line.partition(",")[2] for line in lines) + "\n", encoding="utf-8")
        files.append(tmp_path / name)
    page = visit(serve().url)
    page.get_by_test_id("pick-files").set_input_files(files)
    dialog = page.get_by_test_id("map-dialog")
    dialog.wait_for()
    page.get_by_test_id("map-rate").fill("often")
    page.get_by_test_id("map-apply").click()
    expect(page.get_by_test_id("map-error")).to_contain_text("no rate")
    page.get_by_test_id("map-rate").fill("100")
    page.get_by_test_id("map-apply").click()
    expect(dialog).to_have_count(0)
    wait_ready(page)  # the second file was read in the same way
    expect(page.get_by_test_id("recordings").locator(".finding.refused")).to_have_count(0)


def test_of_a_weaker_suspect_it_is_said_what_explains_more(serve, visit):
    page = visit(serve(DATA / "train_1.csv", DATA / "train_2.csv", "--verify", DATA / "verify.csv").url)
    page.locator("#fold > summary").click()  # it explains less than a percent
    page.get_by_test_id("suspect-stribeck:knee").hover()
    expect(page.get_by_test_id("rivals")).to_contain_text("explains more")
    expect(page.get_by_test_id("rivals")).not_to_contain_text("Nothing else")


def test_own_effect_cancel_two_tabs_reload_and_kill(serve, visit, tmp_path):
    server = serve(
        DATA / "train_1.csv", DATA / "train_2.csv", "--verify", DATA / "verify.csv", "--out", tmp_path / "kept"
    )
    page = visit(server.url)
    # The first thing that the mouse does is to point at a suspect.
    page.get_by_test_id("suspect-load_friction:knee").hover()
    expect(page.get_by_test_id("detail")).to_be_visible()
    before = page.get_by_test_id("error-knee").inner_text()

    # A torque that cannot be is refused with a caret; one that can joins the suspects.
    page.get_by_test_id("own-effect").click()
    page.get_by_test_id("own-id").fill("rub")
    page.get_by_test_id("own-joint").select_option("knee")
    page.get_by_test_id("own-torque").fill("c * abs(tau_rigid) * sgn(dthta)")
    page.get_by_test_id("own-add").click()
    expect(page.get_by_test_id("own-error")).to_contain_text("^")
    page.get_by_test_id("own-torque").fill("c * abs(tau_rigid) * sgn(dtheta)")
    page.get_by_test_id("own-unit-c").fill("1")
    page.get_by_test_id("own-add").click()
    expect(page.get_by_test_id("own-dialog")).to_have_count(0)
    page.get_by_test_id("add-rub:knee").click()
    page.get_by_test_id("layer-rub:knee").wait_for()
    wait_ready(page)
    assert number(page, "error-knee") < 0.6 * float(before.split()[0])

    # Another tab shows the same, and what is done there is seen here; a reload loses nothing.
    other = visit(server.url, context=page.context)
    other.get_by_test_id("layer-rub:knee").wait_for()
    other.get_by_test_id("undo").click()
    expect(page.get_by_test_id("layer-rub:knee")).to_have_count(0)
    expect(page.get_by_test_id("error-knee")).to_have_text(before)
    page.reload()
    page.get_by_test_id("redo").click()
    page.get_by_test_id("layer-rub:knee").wait_for()

    # A search is ended at once, and changes nothing. It may take less time than a mouse to get to the button.
    page.evaluate(PRESS, "[data-testid=cancel]")
    page.get_by_test_id("discover").click()
    page.get_by_test_id("discover").wait_for()
    expect(page.locator("#verdict")).to_contain_text("cancelled")
    expect(page.get_by_test_id("staircase").locator("li")).to_have_count(2)

    # What was kept is whole, however it ends.
    expect(page.locator("#saved")).to_have_attribute("data-kept", "true")
    page.context.close()
    server.end(signal.SIGKILL)
    assert is_session(tmp_path / "kept")
    again = visit(serve(tmp_path / "kept").url)
    again.get_by_test_id("layer-rub:knee").wait_for()
