"""A panel is one module and one script of the same name, and nothing else knows it."""

from __future__ import annotations

import re
import shutil

import pytest

from exoid.apps.page import panels
from exoid.apps.page.app import DRAWN, STATIC, actions
from exoid.ground.folder import modules_in
from exoid.workbench.commands.demo import DATA
from tests.architecture.source import PACKAGE

SCRIPTS = {path.stem: path.read_text("utf-8") for path in (STATIC / "panels").glob("*.js")}


def test_every_module_has_its_script_and_what_is_drawn_has_a_place():
    assert {*modules_in(panels)} <= {*SCRIPTS}
    places = re.findall(r'<section id="(\w+)"', (STATIC / "index.html").read_text("utf-8"))
    above = {name: re.findall(r'export const ABOVE = "(\w+)"', text) for name, text in SCRIPTS.items()}
    assert {name for name, text in SCRIPTS.items() if DRAWN in text} <= {*places} | {n for n in above if above[n]}
    assert {place for one in above.values() for place in one} <= {*places}


@pytest.mark.slow
def test_two_new_files_are_a_new_panel(serve, visit, tmp_path):
    shutil.copytree(PACKAGE, tmp_path / "exoid", ignore=shutil.ignore_patterns("__pycache__"))
    page = tmp_path / "exoid/apps/page"
    (page / "panels/greeting.py").write_text('ANSWERS = {"greeting": lambda workspace, request: {"words": "hello"}}\n')
    (page / "static/panels/greeting.js").write_text("""
import { ask } from "../api.js";
export const ABOVE = "history";
export function draw() {
  ask("/api/greeting").then((found) => { document.getElementById("greeting").textContent = found.words; });
}
""")
    page = visit(serve(DATA / "train_1.csv", package=tmp_path).url)
    expect = pytest.importorskip("playwright.sync_api").expect
    expect(page.get_by_test_id("greeting")).to_have_text("hello")
    expect(page.locator("#greeting + #history")).to_have_count(1)


def test_no_two_panels_share_an_address_or_an_action():
    for kind in ("ANSWERS", "ACTIONS"):
        names = [name for panel in modules_in(panels).values() for name in getattr(panel, kind, {})]
        assert len(names) == len({*names})


def test_what_scripts_ask_to_be_done_is_there():
    said = {name for path in STATIC.rglob("*.js") for name in re.findall(r'tell\("(\w+)"', path.read_text("utf-8"))}
    assert said and said <= {*actions()}
