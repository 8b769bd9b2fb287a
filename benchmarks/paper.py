"""Make docs/paper.md and its pictures with `exoid paper`: `python benchmarks/paper.py`, a minute or two.

With --check nothing is written; exit status 1 where the page is not what comes out.
"""

from __future__ import annotations

import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from exoid.apps.paper.page import page_of, pictures_in  # noqa: E402
from exoid.apps.paper.reproduce import reproduce_paper  # noqa: E402 - the repository must be on the path first

DOCS = ROOT / "docs"
PAGE = DOCS / "paper.md"


def main() -> int:
    found = reproduce_paper()
    fresh = page_of(found)
    if "--check" in sys.argv[1:]:
        current = PAGE.exists() and PAGE.read_text(encoding="utf-8") == fresh
        sys.stdout.write("docs/paper.md is current\n" if current else "docs/paper.md is out of date\n")
        return 0 if current else 1
    pictures = pictures_in(found)
    for old in DOCS.glob("paper_*.png"):
        if old.name not in pictures:
            old.unlink()
    for name, content in pictures.items():
        (DOCS / name).write_bytes(content)
    PAGE.write_text(fresh, encoding="utf-8")
    sys.stdout.write(f"{PAGE.relative_to(ROOT)}, {found.seconds:.0f} s\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
