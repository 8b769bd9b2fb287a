"""The documentation as a site: every page is in its navigation, every public name in its reference."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import pytest

import exoid

ROOT = Path(__file__).resolve().parents[2]
SPEC = importlib.util.spec_from_file_location("docs_site", ROOT / "benchmarks" / "docs_site.py")
SITE = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(SITE)


def pages_of_site():
    return [one for section in SITE.sections() for entries in section.values() for one in entries]


def test_every_page_is_in_the_navigation():
    listed = [page for one in pages_of_site() for page in one.values()]
    assert sorted(["index.md", *listed]) == sorted(path.name for path in (ROOT / "docs").glob("*.md"))
    sections = [title for section in SITE.sections() for title in section]
    assert all(title[0].isupper() for title in (*sections, *(title for one in pages_of_site() for title in one)))


def test_the_reference_has_every_function_and_class_of_the_door():
    said = SITE.reference()
    lacking = [name for name in exoid.__all__ if callable(getattr(exoid, name)) and f".{name}\n" not in said]
    assert lacking == []


@pytest.mark.parametrize(
    ("link", "led"),
    [
        ("[a](open.md#who)", "[a](open.md#who)"),
        ("[a](../ground/errors.py)", "a"),
        ("[a](#here) [b](https://example.org/x)", "[a](#here) [b](https://example.org/x)"),
        ("![a](report.png)", "![a](report.png)"),
    ],
)
def test_links_lead_to_pages_of_the_site(link, led):
    assert SITE.on_page_markdown(link) == led


def test_the_thresholds_page_has_every_threshold():
    from exoid.diagnosis.thresholds import every_threshold

    page = SITE.thresholds()
    assert all(f"| `{rule.name}` | {rule.value:g} |" in page for rule in every_threshold())
