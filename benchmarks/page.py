"""How fast the page of `exoid open` answers, in a real browser on the demo's recordings: seconds from click to picture.

    python benchmarks/page.py [--runs 3]

Needs the extra test (Playwright) and a chromium. The first run fills the caches and is not counted; of the others the
median is printed, beside what is wanted of a quiet machine with two cores. Times are those of the browser, which looks
before every frame.
"""

from __future__ import annotations

import argparse
import os
import shutil
import signal
import statistics
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from playwright.sync_api import Page, sync_playwright

ROOT = Path(__file__).parents[1]
DEMO = ROOT / "exoid" / "workbench" / "demo_data"
WANTED = {
    "page usable after the command": 2.0, "first picture after that": 1.0, "add a suspect to its curves": 0.5,
    "brush to suspects ranked anew": 0.5, "point at a suspect to its curve": 0.5,
}  # fmt: skip
SUSPECT = "load_friction:knee"

# Answers in the frame in which the condition holds, with the seconds since then.
UNTIL = """(act) => new Promise((done) => {
  const began = performance.now();
  if (act) document.querySelector(act).click();
  const look = () => ((CONDITION) ? done((performance.now() - began) / 1000) : requestAnimationFrame(look));
  look();
})"""


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=3)
    runs = parser.parse_args().runs
    path = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))))
    with sync_playwright() as start:
        browser = start.chromium.launch(executable_path=path, args=["--no-sandbox"])
        found = [_story(browser.new_page()) for _ in range(runs + 1)][1:]
        browser.close()
    for what in found[0]:
        median = statistics.median(one[what] for one in found)
        print(f"{what:<42} {median:6.2f} s" + (f"   wanted {WANTED[what]:g} s" if what in WANTED else ""))


def _story(page: Page) -> dict[str, float]:
    out = {}
    with served() as (url, began):
        out["address printed after the command"] = time.perf_counter() - began
        page.goto(url, wait_until="commit")
        page.wait_for_selector("[data-testid=recordings]", timeout=120_000)
        out["page usable after the command"] = time.perf_counter() - began
        drawn = "document.querySelectorAll('canvas.plot[data-drawn=true]').length >= 6"
        out["first picture after that"] = _until(page, drawn)
        ranked = f"document.querySelector(\"[data-testid='suspect-{SUSPECT}'] .share\")"
        out["suspect ranked after that"] = _until(page, ranked)
        finished = "document.querySelector('[data-testid=ranking-progress][data-finished=true]')"
        out["all placebos asked after that"] = _until(page, finished)
        page.locator(f"[data-testid='suspect-{SUSPECT}'] button.link").scroll_into_view_if_needed()
        shown = "document.querySelector('[data-testid=detail]')"
        out["point at a suspect to its curve"] = _until(page, shown, f"[data-testid='suspect-{SUSPECT}'] button.link")
        for what in ("brush to suspects ranked anew", "brush once more"):
            out[what] = _brush(page)
            page.get_by_test_id("clear-selection").click()
        first = float(page.get_by_test_id("error-knee").inner_text().split()[0])
        fell = f"parseFloat(document.querySelector('[data-testid=error-knee]').textContent) < {0.6 * first}"
        out["add a suspect to its curves"] = _until(page, fell, f"[data-testid='add-{SUSPECT}']")
        out["refined in the background after that"] = _until(page, "document.body.dataset.ready === 'true'")
        page.get_by_test_id("discover").wait_for()
        judged = "document.querySelector('[data-testid=verdict]').dataset.verdict === 'missing'"
        page.get_by_test_id("step-0").click()
        out["discover to its verdict"] = _until(page, judged, "[data-testid=discover]")
    return out


def _brush(page: Page) -> float:
    plot = page.get_by_test_id("plot-error-knee")
    plot.scroll_into_view_if_needed()
    box = plot.bounding_box()
    assert box is not None
    x, y = box["x"], box["y"] + 0.5 * box["height"]
    page.mouse.move(x + 0.3 * box["width"], y)
    page.mouse.down()
    began = time.perf_counter()
    page.mouse.move(x + 0.5 * box["width"], y)
    page.mouse.up()
    _until(page, "document.querySelector('#suspects-list p').textContent.includes('selected')")
    return time.perf_counter() - began


def _until(page: Page, condition: str, act: str | None = None) -> float:
    return float(page.evaluate(UNTIL.replace("CONDITION", condition), act))


@contextmanager
def served() -> Iterator[tuple[str, float]]:
    began = time.perf_counter()
    words = [*sorted(one.name for one in DEMO.glob("train*.csv")), "--verify", "verify.csv"]
    process = subprocess.Popen(
        [sys.executable, "-m", "exoid", "open", "--no-browser", "--quiet", *words],
        cwd=DEMO, env={**os.environ, "PYTHONPATH": str(ROOT)}, stdout=subprocess.PIPE, text=True,
    )  # fmt: skip
    try:
        assert process.stdout is not None
        yield process.stdout.readline().strip(), began
    finally:
        process.send_signal(signal.SIGINT)
        process.wait()


if __name__ == "__main__":
    main()
