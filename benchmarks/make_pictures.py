"""Draw the pictures of the README from the shipped demo recordings: `python benchmarks/make_pictures.py`.

`docs/falling_error.png` is the figure of the result; `docs/report.png` is the head of the report, photographed where a
Chromium is installed (and left as it is where none is).
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))
SIZE = (900, 830)
"""Pixels of the picture of the report."""


def main() -> None:
    """Run the demo and take both pictures."""
    from exoid.workbench.command import main as exoid

    with tempfile.TemporaryDirectory() as folder:
        exoid(["demo", "--out", folder, "--quiet"])
        falling = next(Path(folder).glob("figures/*-the-error-falling.png"))
        shutil.copyfile(falling, ROOT / "docs" / "falling_error.png")
        photograph(Path(folder) / "report.html", ROOT / "docs" / "report.png")
    small(ROOT / "docs" / "falling_error.png")
    sys.stdout.write("docs/falling_error.png, docs/report.png\n")


def photograph(page: Path, target: Path) -> None:
    """Write the head of `page` as a PNG, if there is a browser."""
    browser = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    if browser is None:
        sys.stdout.write("no Chromium: docs/report.png stays as it is\n")
        return
    picture = page.with_name("report.png")
    subprocess.run(
        [browser, "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--no-first-run",
         f"--user-data-dir={page.parent / 'profile'}", f"--window-size={SIZE[0]},{SIZE[1]}",
         f"--screenshot={picture}", page.as_uri()],
        check=True, capture_output=True, timeout=60,
    )  # fmt: skip
    shutil.copyfile(picture, target)
    small(target)


def small(path: Path) -> None:
    """Reduce a PNG to 64 colours; plots and text need no more."""
    from PIL import Image

    picture = Image.open(path).convert("RGB").quantize(64, dither=Image.Dither.NONE)
    picture.save(path, "PNG", optimize=True)


if __name__ == "__main__":
    main()
