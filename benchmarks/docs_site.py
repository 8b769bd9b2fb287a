"""What `mkdocs build` asks for: the README as first page, its table of pages as navigation, and a reference of what
`import exoid` has.
"""

from __future__ import annotations

import importlib
import inspect
import re
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
API = "api.md"
LINK = re.compile(r"(!?\[[^\]]*\])\(([^)#\s]*)(#[^)\s]*)?\)")
"""A link of Markdown: text, target and place in it."""
GUIDE = "## Where to go from here"


def on_config(config: Any) -> Any:
    """Take the navigation from the README's table, and the reference behind it."""
    config.nav = [{"exoid": "index.md"}, *sections(), {"API reference": API}]
    return config


def on_files(files: Any, config: Any) -> Any:
    """Add the pages that lie elsewhere or are made of the code."""
    from mkdocs.structure.files import File

    for name, text in (("index.md", (ROOT / "README.md").read_text(encoding="utf-8")), (API, reference())):
        files.append(File.generated(config, name, content=text))
    return files


def on_page_markdown(markdown: str, page: Any, **_: Any) -> str:
    """Lead links to where the page lies on the site; what is no page of it, source and notebooks, is named alone."""
    home = ROOT if page.file.src_uri == "index.md" else ROOT / "docs"

    def led(found: re.Match[str]) -> str:
        text, target, place = found[1], found[2], found[3] or ""
        if not target or "://" in target:
            return found[0]
        path = (home / target).resolve()
        if path == ROOT / "README.md":
            return f"{text}(index.md{place})"
        if path.parent == ROOT / "docs" and path.is_file():
            return f"{text}({path.name}{place})"
        return text.strip("[]")

    return LINK.sub(led, markdown)


def sections() -> list[dict[str, list[dict[str, str]]]]:
    """Return [{section: [{title: page}]}] of the README's table of what to read."""
    table = (ROOT / "README.md").read_text(encoding="utf-8").partition(GUIDE)[2]
    found: list[dict[str, list[dict[str, str]]]] = []
    for row in re.findall(r"^\| (.+?) \| (.+) \|$", table, re.MULTILINE):
        pages = [{text[1:-1]: target[5:]} for text, target, _ in LINK.findall(row[1]) if target.startswith("docs/")]
        if pages:
            found.append({row[0][:1].upper() + row[0][1:]: pages})
    return found


def reference() -> str:
    """Return the page of every public name, by the package that it comes from."""
    exoid = importlib.import_module("exoid")
    lines = ["# API reference", "", "Every name is one of `exoid`: `exoid.discover`, `exoid.Model`, ..."]
    groups: dict[str, list[str]] = {}
    for name in sorted(exoid.__all__, key=str.lower):
        one = getattr(exoid, name)
        if inspect.ismodule(one) or not hasattr(one, "__module__") or not hasattr(one, "__qualname__"):
            continue
        module = importlib.import_module(one.__module__)
        groups.setdefault(one.__module__.split(".")[1], []).append(f"::: {module.__name__}.{one.__qualname__}")
    for package in ("diagnosis", "optimisation", "measurement", "symbolic", "apps", "ground"):
        about = (importlib.import_module(f"exoid.{package}").__doc__ or "").strip().splitlines()[:1]
        lines += ["", f"## {package}", "", *about, "", "\n\n".join(groups.get(package, []))]
    return "\n".join(lines) + "\n"
