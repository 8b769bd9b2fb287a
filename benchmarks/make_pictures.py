"""Pictures of the README and the first hour, made from the shipped demo: `python benchmarks/make_pictures.py`.

`docs/falling_error.png` is the figure of the result, `docs/page.png` the page of `exoid open`, and `docs/report.png`
the head of the report; the last two need a Chromium. Each carries the text that is to be read on it (`Description`).

python benchmarks/make_pictures.py rivals    `docs/rivals.png`: the contest of `exoid rivals` with 51 seeds, minutes
python benchmarks/make_pictures.py arm       `docs/arm.png`: the arm of docs/machines.md, from EXOID_SHARED_DATA
python benchmarks/make_pictures.py --check exoid-demo/result.json    exit status 1 where `exoid demo` says otherwise
"""

from __future__ import annotations

import json
import os
import shutil
import sys
import tempfile
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))
DOCS = ROOT / "docs"
SIZES = {"page": (1280, 800), "report": (900, 830)}
"""Pixels of what is photographed."""
ABOUT = "Description"


def main() -> int:
    """Make the pictures, or check them."""
    if "--check" in sys.argv[1:]:
        found = json.loads(Path(sys.argv[-1]).read_text(encoding="utf-8"))
        old = out_of_date(found)
        sys.stdout.write(f"run python benchmarks/make_pictures.py: {'; '.join(old)}\n" if old else "current\n")
        return 1 if old else 0
    if "rivals" in sys.argv[1:]:
        draw_rivals()
        return 0
    if "arm" in sys.argv[1:]:
        draw_arm()
        return 0
    draw_falling()
    photograph()
    sys.stdout.write("docs/falling_error.png, docs/page.png, docs/report.png\n")
    return 0


def out_of_date(found: dict[str, Any]) -> list[str]:
    """What the pictures do not show of `found`, the JSON of `exoid demo`."""
    errors = [error for step in (found["steps"][0], found["steps"][-1]) for error in step["verify_rms"]]
    lacking = []
    for name, form in (("falling_error", "{:.2g}"), ("page", "{:.3g}"), ("report", "{:.3g}")):
        shown = text_on(DOCS / f"{name}.png").split()
        lacking += [f"{one} is not on {name}.png" for one in map(form.format, errors) if one not in shown]
    return lacking


def text_on(path: Path) -> str:
    """The text that is to be read on a picture."""
    from PIL import Image

    with Image.open(path) as picture:
        return str(picture.info[ABOUT])


def draw_falling() -> None:
    """The figure of `found.plot()`, with the numbers above its bars."""
    import exoid
    from exoid.workbench.commands.demo import DATA

    figure = exoid.discover(sorted(DATA.glob("train*.csv")), verify=sorted(DATA.glob("verify*.csv"))).plot()
    target = DOCS / "falling_error.png"
    figure.savefig(target, dpi=150)
    keep(target, " ".join(text.get_text() for axes in figure.axes for text in axes.texts))


def draw_rivals() -> None:
    """The figure of the contest of optimisers, as `exoid rivals` runs it."""
    import exoid

    target = DOCS / "rivals.png"
    exoid.rivals().plot().savefig(target, dpi=110)
    keep(target, "")


def draw_arm() -> None:
    """The falling error of a real arm."""
    import exoid

    where, target = Path(os.environ["EXOID_SHARED_DATA"]) / "arm_tx40", DOCS / "arm.png"
    model = exoid.read_model(where / "tx40.urdf")
    figure = exoid.discover(model, where / "run.csv").plot()
    figure.savefig(target, dpi=90)
    keep(target, " ".join(text.get_text() for axes in figure.axes for text in axes.texts))


def photograph() -> None:
    """The page with the demo's answer, and the head of the demo's report."""
    from playwright.sync_api import sync_playwright

    from benchmarks.page import served
    from exoid.workbench.command import main as exoid

    browser_path = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))))
    with sync_playwright() as start, tempfile.TemporaryDirectory() as folder:
        browser = start.chromium.launch(executable_path=browser_path, args=["--no-sandbox"])

        def opened(name: str, address: str) -> Any:
            width, height = SIZES[name]
            tab = browser.new_page(viewport={"width": width, "height": height})
            tab.goto(address)
            return tab

        def taken(name: str, tab: Any, where: str) -> None:
            tab.screenshot(path=DOCS / f"{name}.png")
            keep(DOCS / f"{name}.png", tab.locator(where).inner_text())

        exoid(["demo", "--out", folder, "--quiet"])
        taken("report", opened("report", (Path(folder) / "report.html").as_uri()), "main section >> nth=0")
        with served() as (url, _):
            tab = opened("page", url)
            tab.wait_for_selector("[data-testid=verdict][data-verdict=missing]", timeout=120_000)
            tab.wait_for_selector(
                "[data-testid=ranking-progress][data-finished=true]", timeout=120_000, state="attached"
            )
            tab.wait_for_selector("body[data-ready=true]", timeout=120_000)
            taken("page", tab, "section#verdict")
        browser.close()


def keep(path: Path, text: str) -> None:
    """Reduce a PNG to 128 colours, which is enough for plots and text, and write `text` into it."""
    from PIL import Image
    from PIL.PngImagePlugin import PngInfo

    about = PngInfo()
    about.add_text(ABOUT, " ".join(text.split()).encode("ascii", "ignore").decode())
    picture = Image.open(path).convert("RGB").quantize(128, dither=Image.Dither.NONE)
    picture.save(path, "PNG", optimize=True, pnginfo=about)


if __name__ == "__main__":
    sys.exit(main())
