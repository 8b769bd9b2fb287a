"""The page: self-contained, escaped, readable on a phone, alive without errors in a real browser."""

from __future__ import annotations

import argparse
import base64
import functools
import html
import http.server
import json
import re
import shutil
import subprocess
import sys
import threading
from dataclasses import replace
from datetime import date
from html.parser import HTMLParser

import numpy as np
import pytest
from workbench_fakes import HOSTILE, FakeComparison, FakeDiagnosis, FakeModel, figure, material, recording

from exoid.diagnosis.extend import Waterfall
from exoid.diagnosis.report import sections
from exoid.diagnosis.report.material import Material
from exoid.diagnosis.report.page import (
    figure_file_name,
    find_sections,
    number_in_page,
    render_report,
    write_report,
)
from exoid.diagnosis.results import Step
from exoid.diagnosis.sureness import MEANINGS
from exoid.ground.figures import LARGEST_SVG, adaptive, to_data_uri, to_svg
from exoid.measurement.finding import Finding
from exoid.symbolic.model import Model
from exoid.workbench.command_line.deliver import command_of
from tests.waiting import HUNG

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")

FRAME = """<!doctype html><body style="margin:0"><iframe id="page" style="border:0;width:380px;height:900px"
src="report.html"></iframe><pre id="out">waiting</pre><script>
document.getElementById("page").onload = () => {
  const page = document.getElementById("page").contentDocument;
  const head = Array.from(page.querySelectorAll("#suspects th button")).find(b => b.textContent === "explains");
  const order = () => Array.from(page.querySelectorAll("#suspects tbody tr")).map(r => r.cells[0].textContent).join();
  const before = order(); head.click(); const after = order(); head.click(); const again = order();
  const cells = page.defaultView.getComputedStyle(page.querySelector("#suspects td")).display;
  page.querySelector("button.zoom").click();
  const large = page.querySelector("#zoom img").getBoundingClientRect().width;
  document.getElementById("out").textContent = "width=" + page.documentElement.scrollWidth
    + " before=" + before + " after=" + after + " again=" + again + " zoomed=" + page.getElementById("zoom").open
    + " cells=" + cells + " large=" + Math.round(large);
};</script></body>"""


class Page(HTMLParser):
    """Collects what a page asks for and what it shows without words."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.links: list[str] = []
        self.images: list[dict[str, str | None]] = []
        self.scripts = 0
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        found = dict(attrs)
        self.links += [found[name] or "" for name in ("src", "href", "data", "action", "srcset") if name in found]
        self.scripts += tag == "script"
        if tag == "img":
            self.images.append(found)


def test_nothing_is_requested_from_outside():
    text = render_report(material())
    page = Page(text)
    assert page.links
    assert all(link.startswith(("#", "data:")) for link in page.links)
    assert not re.search(r"@import|url\((?!data:)", text)


def test_figures_have_words_and_live_in_the_page():
    images = [i for i in Page(render_report(material())).images if "src" in i]
    assert len(images) == 2
    assert all((i["alt"] or "").strip() and (i["src"] or "").startswith("data:image/") for i in images)


def test_hostile_text_stays_text():
    text = render_report(material())
    assert HOSTILE not in text
    assert Page(text).scripts == 1


@pytest.mark.slow
def test_every_section_is_shown_with_its_title():
    text = render_report(material())
    shown = [section for section in find_sections() if section.context(material()) is not None]
    assert len(shown) >= 8
    for section in shown:
        assert f">{section.TITLE}</h2>" in text


@pytest.mark.parametrize("section", find_sections(), ids=lambda s: s.__name__.rsplit(".", 1)[1])
def test_sections_keep_quiet_without_material(section):
    assert section.__name__.endswith("repeat") or section.context(Material(title="empty")) is None


def test_a_page_does_not_tell_where_its_maker_keeps_files():
    finding = Finding("gaps", "warning", "12 rows are empty", where="/home/me/data set/run_0.csv, column tau2")
    given = Material(
        title="t", answer="a", recordings=(recording(findings=(finding,)),), model=FakeModel(), truth="in /srv/x/seal",
        command=command_of(argparse.Namespace(command_line=["exoid", "--model=/home/me/leg.toml", "C:/a/b.csv"])),
        payload={"where": "/home/me/data/run_0.csv", "unit": "N·m·s/rad", "ratio": "1/(a/b)"},
    )  # fmt: skip
    text = render_report(given)
    data = base64.b64decode(text.split("data:application/json;base64,")[1].split('"')[0])
    assert json.loads(data) == {"where": "run_0.csv", "unit": "N·m·s/rad", "ratio": "1/(a/b)"}
    assert "/home" not in text and "/srv" not in text and "C:/" not in text
    assert "run_0.csv, column tau2" in text and "leg.toml" in text


@pytest.mark.slow
def test_the_answer_is_open_and_the_rest_is_folded():
    text = render_report(material())
    assert text.index('class="verdict') < text.index('<details class="folded">')
    assert text.count('<details class="folded">') == text.count("<section ") - 1


def test_numbers_stand_in_an_appendix_that_is_printed_where_it_is_open():
    text = render_report(material())
    start = text.index('<details class="appendix"')
    first = [text.index(f'<section id="{name}"') for name in ("verdict", "falling", "suspects", "repeat")]
    assert max(first) < start < text.index('<section id="parameters"')
    assert ".appendix:not([open])" in text.split("@media print")[1]


def test_the_head_tells_machine_files_and_date_and_print_has_page_numbers():
    given = replace(material(), made=date(2026, 3, 5))
    text = render_report(given)
    head = text.split("<nav")[0]
    assert "5 March 2026" in head and all(html.escape(one.name) in head for one in given.recordings[:4])
    assert "5 March 2026" in text.split("</title>")[0]
    assert "counter(page)" in text and "counter(pages)" in text


def test_what_a_word_means_is_said_once():
    text = render_report(material())
    (said,) = [meaning for meaning in MEANINGS.values() if meaning[:30] in text]
    assert text.count(said[:30]) == 1


def test_an_almost_empty_page_renders():
    assert "only this" in render_report(Material(title="t", answer="only this"))


@pytest.mark.slow
@pytest.mark.parametrize("verdict", ["adequate", "missing", "ambiguous", "unexplained"])
def test_every_verdict_renders(verdict):
    assert f'class="verdict {verdict}"' in render_report(replace(material(), diagnosis=FakeDiagnosis(verdict=verdict)))


def test_without_unseen_recordings_no_unseen_error_is_claimed():
    fall = Waterfall((Step("base", np.array([1.0, np.inf]), None),), np.array([0.5, np.nan]), Model.standard(), "")
    text = render_report(Material(title="t", fall=fall, comparison=FakeComparison(unseen=False)))
    assert "has not seen" not in text
    assert not re.search(r">\s*(nan|inf)\b", text)


def test_files_of_a_report(tmp_path):
    page = write_report(material(), tmp_path / "out")
    assert page.name == "report.html"
    assert sorted(p.name for p in (page.parent / "figures").iterdir()) == [
        "01-suspects.png",
        "02-residual-over-time.png",
    ]


@pytest.mark.slow
def test_the_same_material_gives_the_same_page():
    assert render_report(material()) == render_report(material())


@pytest.mark.slow
def test_svg_follows_dark_mode_and_heavy_figures_become_png():
    svg = adaptive(to_svg(figure()))
    assert "prefers-color-scheme:dark" in svg
    assert "var(--c0)" in svg
    assert to_data_uri(figure()).startswith("data:image/svg+xml")
    import numpy as np

    from exoid.ground.figures import new_figure

    heavy = new_figure()
    heavy.subplots().scatter(np.arange(20000.0), np.sin(np.arange(20000.0)))
    assert len(to_svg(heavy)) > LARGEST_SVG
    assert to_data_uri(heavy).startswith("data:image/png")


def test_slug_is_a_file_name():
    assert figure_file_name("Where: θ/../x ") == "where-x"
    assert figure_file_name("θ") == "figure"


@pytest.fixture(scope="module")
def visit(tmp_path_factory):
    """Open the page in a 380 px wide frame of headless Chromium: (what it measured, console, requested paths)."""
    if CHROMIUM is None:
        pytest.skip("no Chromium on this machine, so the page cannot be opened in a browser")
    folder = tmp_path_factory.mktemp("page")
    write_report(material(), folder)
    (folder / "frame.html").write_text(FRAME, "utf-8")
    asked: list[str] = []

    class Handler(http.server.SimpleHTTPRequestHandler):
        def log_message(self, format, *args):
            asked.append(self.path)

    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Handler, directory=str(folder)))
    thread = threading.Thread(target=server.serve_forever, daemon=True)
    thread.start()
    try:
        out = subprocess.run(
            [CHROMIUM, "--headless", "--no-sandbox", "--disable-gpu", "--enable-logging=stderr", "--v=0",
             f"--user-data-dir={folder / 'profile'}", "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1",
             "--virtual-time-budget=4000", "--dump-dom", f"http://127.0.0.1:{server.server_port}/frame.html"],
            capture_output=True, text=True, timeout=HUNG, check=False,
        )  # fmt: skip
    finally:
        server.shutdown()
        server.server_close()
        thread.join()
    found = re.search(r'<pre id="out">(.*?)</pre>', out.stdout, re.S)
    return found[1] if found else out.stderr, [x for x in out.stderr.splitlines() if "CONSOLE" in x], asked


def test_no_overflow_at_380_pixels(visit):
    width = re.search(r"width=(\d+)", visit[0])
    assert width, visit[0]
    assert int(width[1]) <= 380


def test_no_console_errors_and_no_other_request(visit):
    assert visit[1] == []
    assert set(visit[2]) <= {"/frame.html", "/report.html", "/favicon.ico"}


def test_tables_sort_and_figures_zoom(visit):
    assert "before=1,2,3 after=3,2,1 again=1,2,3" in visit[0]
    assert "zoomed=true" in visit[0]


def test_on_a_phone_wide_tables_are_cards_and_a_figure_zooms_beyond_the_screen(visit):
    assert "cells=grid" in visit[0]
    large = re.search(r"large=(\d+)", visit[0])
    assert large and int(large[1]) > 500


def test_two_new_files_are_a_new_section(tmp_path, monkeypatch):
    (tmp_path / "sections").mkdir()
    (tmp_path / "sections/greeting.py").write_text(
        'TITLE = "Greeting"\nORDER = 0\n\n\ndef context(material):\n    return {"words": material.title}\n'
    )
    (tmp_path / "sections/greeting.html").write_text("<p>hello {{ words }}</p>\n")
    monkeypatch.setattr(sections, "__path__", [*sections.__path__, str(tmp_path / "sections")])
    try:
        assert "<p>hello t &amp; u</p>" in render_report(Material(title="t & u"))
    finally:
        sys.modules.pop("exoid.diagnosis.report.sections.greeting", None)


@pytest.mark.parametrize(("value", "text"), [(999.4, "999"), (999.7, "1000"), (1234.5, "1234"), (0.0012345, "0.00123")])
def test_numbers_are_written_out_from_a_thousand_on(value, text):
    assert number_in_page(value) == text
