"""The page without a mouse and for a screen reader: names, one heading, edges; and the sessions that it remembers."""

from __future__ import annotations

import pytest

from exoid.apps.page import recent

UNNAMED = """() => [...document.querySelectorAll("button, input, select, a, canvas, [role=separator], summary")]
  .filter((one) => one.checkVisibility())
  .filter((one) => ![one.ariaLabel, one.title, one.textContent.trim(),
    ...[...(one.labels || [])].flatMap((label) => [label.ariaLabel, label.textContent.trim()])].some(Boolean))
  .map((one) => one.outerHTML)"""


@pytest.mark.slow
def test_every_control_has_a_name_and_every_edge_moves_by_keys(serve, visit, tmp_path, monkeypatch):
    monkeypatch.setenv("EXOID_CACHE", str(tmp_path / "cache"))
    page = visit(serve().url)
    page.get_by_test_id("demo").wait_for()
    assert page.evaluate(UNNAMED) == [] and page.locator("h1:visible").count() == 1
    page.get_by_test_id("demo").click()
    page.get_by_test_id("error-knee").wait_for()
    assert page.evaluate(UNNAMED) == [] and page.locator("h1:visible").count() == 1
    for pane, larger in (("side", "ArrowRight"), ("right", "ArrowLeft"), ("plots", "ArrowDown")):
        edge = page.locator(f".split[data-pane={pane}]")
        edge.focus()
        page.keyboard.press(larger)
        first = int(edge.get_attribute("aria-valuenow"))
        page.keyboard.press(larger)
        assert int(edge.get_attribute("aria-valuenow")) > first


def test_sessions_are_remembered_newest_first_while_they_are_there(tmp_path, monkeypatch):
    monkeypatch.setenv("EXOID_CACHE", str(tmp_path / "cache"))
    folders = [tmp_path / name for name in ("first", "second", "gone")]
    for folder in folders:
        folder.mkdir()
        (folder / "session.json").write_text("{}")
        recent.note(folder)
    (folders[2] / "session.json").unlink()
    recent.note(folders[0])
    assert recent.sessions() == [str(folders[0]), str(folders[1])]
    recent.forget()
    assert recent.sessions() == []


def test_a_spoilt_list_of_sessions_is_an_empty_one(tmp_path, monkeypatch):
    monkeypatch.setenv("EXOID_CACHE", str(tmp_path / "cache"))
    recent.note(tmp_path)
    (tmp_path / "cache" / recent.FILE).write_text('{"not": "a list"}')
    assert recent.sessions() == []
