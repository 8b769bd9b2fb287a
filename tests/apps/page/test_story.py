"""The whole story on the demo, in a real browser: from nothing to a verdict, and everything that can be taken away."""

from __future__ import annotations

import re
import tomllib
import zipfile

import pytest
from playwright.sync_api import expect

pytestmark = pytest.mark.slow  # a browser, and fits behind it

MISSING = "load_friction:knee"


def number(page, testid):
    return float(page.get_by_test_id(testid).inner_text().split()[0])


def wait_ready(page):
    """Wait until the present model is fitted and drawn."""
    expect(page.locator("body")).to_have_attribute("data-ready", "true")


def drag(page, testid, start, end):
    """Drag over a plot from one place to another, in shares of its size."""
    plot = page.get_by_test_id(testid)
    plot.scroll_into_view_if_needed()
    box = plot.bounding_box()
    page.mouse.move(box["x"] + start[0] * box["width"], box["y"] + start[1] * box["height"])
    page.mouse.down()
    page.mouse.move(box["x"] + end[0] * box["width"], box["y"] + end[1] * box["height"], steps=4)
    page.mouse.up()


def colours(page, testid):
    """How many colours are painted on a plot."""
    return page.get_by_test_id(testid).evaluate(
        "c => new Set(new Uint32Array(c.getContext('2d').getImageData(0, 0, c.width, c.height).data.buffer)).size"
    )


def test_from_the_start_screen_to_a_verdict(serve, visit, tmp_path):
    server = serve()
    assert re.fullmatch(r"http://127\.0\.0\.1:\d+/\?token=\S+", server.url)
    page = visit(server.url)
    page.get_by_test_id("demo").click()

    # Compare: error, noise and pictures.
    page.get_by_test_id("error-knee").wait_for()
    before = number(page, "error-knee")
    assert before > 2.0 * number(page, "noise-knee")
    expect(page.get_by_test_id("recordings")).to_contain_text("verify.csv")
    wait_ready(page)
    for plot in (f"{kind}-{joint}" for kind in ("plot-torque", "plot-error", "scatter") for joint in ("hip", "knee")):
        expect(page.get_by_test_id(plot)).to_have_attribute("data-drawn", "true")
        assert colours(page, plot) > 2

    # Point at a suspect, then select a stretch: it is the one that explains it.
    suspect = page.get_by_test_id(f"suspect-{MISSING}")
    suspect.hover()
    expect(page.get_by_test_id("detail")).to_contain_text("Error as it would become")
    drag(page, "plot-error-knee", (0.3, 0.5), (0.6, 0.5))
    expect(page.get_by_test_id("selection")).to_contain_text("of verify")
    page.wait_for_selector(f"ul.suspects li:first-child[data-testid='suspect-{MISSING}']")
    drag(page, "scatter-knee", (0.55, 0.1), (0.95, 0.4))
    expect(page.get_by_test_id("selection")).to_contain_text("knee: knee velocity")
    page.get_by_test_id("clear-selection").click()

    # Add it, take it back, bring it again, switch it off and on.
    page.get_by_test_id(f"add-{MISSING}").click()
    page.get_by_test_id(f"layer-{MISSING}").wait_for()
    wait_ready(page)
    after = number(page, "error-knee")
    assert after < 0.4 * before
    page.get_by_test_id("undo").click()
    expect(page.get_by_test_id("error-knee")).to_have_text(f"{before:.3f} N·m")
    page.get_by_test_id("redo").click()
    expect(page.get_by_test_id("error-knee")).to_have_text(f"{after:.3f} N·m")
    page.get_by_test_id(f"switch-{MISSING}").click()
    expect(page.get_by_test_id("error-knee")).to_have_text(f"{before:.3f} N·m")
    page.get_by_test_id("step-0").click()
    expect(page.get_by_test_id(f"layer-{MISSING}")).to_have_count(0)

    # The whole search comes to the same.
    wait_ready(page)
    page.get_by_test_id("discover").click()
    expect(page.get_by_test_id("verdict")).to_have_attribute("data-verdict", "missing")
    page.get_by_test_id(f"layer-{MISSING}").wait_for()
    wait_ready(page)
    assert number(page, "error-knee") < 0.4 * before
    expect(page.get_by_test_id("staircase")).to_contain_text(f"+ {MISSING}")

    # What can be done is found by its words; the plots are as high as one makes them.
    page.keyboard.press("Control+k")
    page.get_by_test_id("find").fill("show train_1")
    page.keyboard.press("Enter")
    expect(page.locator("#which")).to_have_value("0")
    edge, height = page.locator("[data-pane=plots]"), "document.getElementById('compare').offsetHeight"
    high = page.evaluate(f"() => {height}")
    edge.press("ArrowUp")
    assert page.evaluate(f"() => {height}") < high
    edge.dblclick()
    assert page.evaluate(f"() => {height}") == high

    # Take away.
    expect(page.get_by_test_id("command")).to_contain_text("exoid discover")
    page.get_by_test_id("copy-command").click()
    assert "exoid discover" in page.evaluate("navigator.clipboard.readText()")
    with page.expect_download() as download:
        page.get_by_test_id("save-report").click()
    assert "load_friction" in download.value.path().read_text(encoding="utf-8")
    with page.expect_download() as download:
        page.get_by_test_id("save-model").click()
    model = tomllib.loads(download.value.path().read_text(encoding="utf-8"))
    assert model["effects"] == [{"id": "load_friction", "joint": "knee"}]
    page.get_by_test_id("save-folder").fill(str(tmp_path / "kept"))
    page.get_by_test_id("save-session").click()
    expect(page.locator("#saved")).to_contain_text("kept")
    page.context.close()
    assert server.end() == 0

    # The saved folder goes on where this ended.
    again = visit(serve(tmp_path / "kept").url)
    again.get_by_test_id(f"layer-{MISSING}").wait_for()
    expect(again.get_by_test_id("verdict")).to_have_attribute("data-verdict", "missing")
    wait_ready(again)
    assert number(again, "error-knee") < 0.4 * before

    # So it does where it is chosen on the start screen. The code of the model can be had, too.
    chosen = visit(serve().url)
    with chosen.expect_file_chooser() as chooser:
        chosen.get_by_test_id("pick-session").click()
    chooser.value.set_files(tmp_path / "kept")
    chosen.get_by_test_id(f"layer-{MISSING}").wait_for()
    expect(chosen.get_by_test_id("verdict")).to_have_attribute("data-verdict", "missing")
    wait_ready(chosen)
    chosen.get_by_test_id("export-format").select_option("numpy")
    with chosen.expect_download() as download:
        chosen.get_by_test_id("export-model").click()
    assert zipfile.is_zipfile(download.value.path())
