"""What `mkdocs build` asks for: the landing page's table as navigation, a reference of what `import exoid` has, and the
thresholds that decide.
"""

from __future__ import annotations

import importlib
import inspect
import re
from itertools import groupby
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
API, THRESHOLDS = "api.md", "thresholds.md"
"""Pages that are made of the code whenever the site is built."""
LINK = re.compile(r"(!?\[[^\]]*\])\(([^)#\s]*)(#[^)\s]*)?\)")
"""A link of Markdown: text, target and place in it."""
GUIDE = "## Where to go\n"


def on_config(config: Any) -> Any:
    """Take the navigation from the landing page's table, and what is made of the code behind it."""
    config.nav = [{"Start": "index.md"}, *sections(), {"Reference": [{"Python": API}, {"Thresholds": THRESHOLDS}]}]
    return config


def on_files(files: Any, config: Any) -> Any:
    """Add the pages that are made of the code."""
    from mkdocs.structure.files import File

    for name, text in ((API, reference()), (THRESHOLDS, thresholds())):
        files.append(File.generated(config, name, content=text))
    return files


def on_page_markdown(markdown: str, **_: Any) -> str:
    """Lead links to where the page lies on the site; what is no page of it, source and notebooks, is named alone."""

    def led(found: re.Match[str]) -> str:
        text, target, place = found[1], found[2], found[3] or ""
        if not target or "://" in target:
            return found[0]
        path = (ROOT / "docs" / target).resolve()
        if path.parent == ROOT / "docs" and path.is_file():
            return f"{text}({path.name}{place})"
        return text.strip("[]")

    return LINK.sub(led, markdown)


def sections() -> list[dict[str, list[dict[str, str]]]]:
    """Sections of the landing page's table: [{section: [{title: page}]}]."""
    table = (ROOT / "docs" / "index.md").read_text(encoding="utf-8").partition(GUIDE)[2]
    found: list[dict[str, list[dict[str, str]]]] = []
    for row in re.findall(r"^\| (.+?) \| (.+) \|$", table, re.MULTILINE):
        pages = [{sentence(text[1:-1]): target} for text, target, _ in LINK.findall(row[1])]
        if pages:
            found.append({sentence(row[0]): pages})
    return found


def sentence(words: str) -> str:
    """The words with a capital at their beginning."""
    return words[:1].upper() + words[1:]


def thresholds() -> str:
    """The page of every number that a diagnosis compares with."""
    from exoid.diagnosis.thresholds import every_threshold

    lines = [
        "# Thresholds",
        "",
        "Every number that a diagnosis compares with, by what it bounds; [the evidence](statistics.md) says how.",
    ]
    for group, rules in groupby(every_threshold(), key=lambda rule: rule.group):
        lines += [
            "",
            f"## {sentence(group)}",
            "",
            "| threshold | value | what it is; what happens without it |",
            "|---|---|---|",
        ]
        lines += [f"| `{rule.name}` | {rule.value:g} | {rule.prevents} |" for rule in rules]
    return "\n".join(lines) + "\n"


def reference() -> str:
    """The page of every public name, by the package that it comes from."""
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
