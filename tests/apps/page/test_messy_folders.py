"""A folder as a logger leaves it, dropped once: from the drop to the right verdict without opening a document."""

from __future__ import annotations

import pytest
from playwright.sync_api import expect

from . import messy

pytestmark = pytest.mark.slow  # a browser, and a search behind it


def drop(page, folder):
    """Drop a folder on the page, as a hand does."""
    page.get_by_test_id("drop").wait_for()
    box = page.get_by_test_id("drop").bounding_box()
    at = {"x": box["x"] + box["width"] / 2, "y": box["y"] + 20}
    data = {"items": [], "files": [str(folder)], "dragOperationsMask": 1}
    session = page.context.new_cdp_session(page)
    for step in ("dragEnter", "dragOver", "drop"):
        session.send("Input.dispatchDragEvent", {"type": step, **at, "data": data})


@pytest.mark.parametrize("fill", messy.FOLDERS, ids=lambda fill: fill.__name__)
def test_a_messy_folder_is_answered(fill, serve, visit, tmp_path, monkeypatch):
    monkeypatch.setenv("EXOID_CACHE", str(tmp_path / "cache"))  # what other folders were told is not known
    folder = tmp_path / fill.__name__
    folder.mkdir()
    missing, asked = fill(folder)
    page = visit(serve().url)
    drop(page, folder)
    if asked:
        page.get_by_test_id(asked).click()
    verdict = page.get_by_test_id("verdict")
    expect(verdict).to_have_attribute("data-verdict", "missing")
    expect(verdict).to_contain_text(missing)
    expect(page.get_by_test_id("map-dialog")).to_have_count(0)
    roles = [one.input_value() for one in page.locator("ul.files select").all()]
    assert roles == ["fit", "fit", "fit", "verify"]
