"""The documentation as a site: every page is in its navigation, every public name in its reference."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from types import SimpleNamespace

import pytest

import exoid

ROOT = Path(__file__).resolve().parents[2]
SPEC = importlib.util.spec_from_file_location("docs_site", ROOT / "benchmarks" / "docs_site.py")
SITE = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(SITE)


def test_every_page_is_in_the_navigation():
    pages = (one for section in SITE.sections() for entries in section.values() for one in entries)
    listed = [page for one in pages for page in one.values()]
    assert sorted(listed) == sorted(path.name for path in (ROOT / "docs").glob("*.md"))


def test_the_reference_has_every_function_and_class_of_the_door():
    said = SITE.reference()
    lacking = [name for name in exoid.__all__ if callable(getattr(exoid, name)) and f".{name}\n" not in said]
    assert lacking == []


@pytest.mark.parametrize(
    ("page", "link", "led"),
    [
        ("index.md", "[a](docs/open.md#who)", "[a](open.md#who)"),
        ("open.md", "[a](../README.md#set-up)", "[a](index.md#set-up)"),
        ("open.md", "[a](../ground/errors.py)", "a"),
        ("open.md", "[a](#here) [b](https://example.org/x)", "[a](#here) [b](https://example.org/x)"),
        ("index.md", "![a](docs/report.png)", "![a](report.png)"),
    ],
)
def test_links_lead_to_pages_of_the_site(page, link, led):
    assert SITE.on_page_markdown(link, SimpleNamespace(file=SimpleNamespace(src_uri=page))) == led
