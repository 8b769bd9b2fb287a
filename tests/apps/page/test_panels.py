"""A panel is one module and one script of the same name, and nothing else knows it."""

from __future__ import annotations

import re

from exoid.apps.page import panels
from exoid.apps.page.app import DRAWN, STATIC, actions
from exoid.ground.folder import modules_in

SCRIPTS = {path.stem: path.read_text("utf-8") for path in (STATIC / "panels").glob("*.js")}


def test_every_module_has_its_script_and_what_is_drawn_has_a_place():
    assert {*modules_in(panels)} <= {*SCRIPTS}
    places = re.findall(r'<section id="(\w+)"', (STATIC / "index.html").read_text("utf-8"))
    assert {name for name, text in SCRIPTS.items() if DRAWN in text} <= {*places}


def test_no_two_panels_share_an_address_or_an_action():
    for kind in ("ANSWERS", "ACTIONS"):
        names = [name for panel in modules_in(panels).values() for name in getattr(panel, kind, {})]
        assert len(names) == len({*names})


def test_what_scripts_ask_to_be_done_is_there():
    said = {name for path in STATIC.rglob("*.js") for name in re.findall(r'tell\("(\w+)"', path.read_text("utf-8"))}
    assert said and said <= {*actions()}
