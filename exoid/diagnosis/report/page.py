"""Puts the sections together into one self-contained page: no request leaves it."""

from __future__ import annotations

import math
import re
from abc import abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

from exoid.diagnosis.report import sections
from exoid.diagnosis.report.material import Material, Picture, without_folders
from exoid.ground.figures import colour_rules, png_of_uri, to_uris
from exoid.ground.folder import with_apps
from exoid.ground.output import make_folder, write_bytes, write_text
from exoid.ground.plain import AsJson

if TYPE_CHECKING:
    from jinja2 import Environment

FOLDER = Path(__file__).parent


def find_sections() -> tuple[ModuleType, ...]:
    """Return every module of `sections/`, and of those of apps, in the order in which they stand in the page."""
    found = (import_module(name) for name in with_apps(sections).values())
    return tuple(sorted(found, key=lambda section: (section.ORDER, section.__name__)))


def render_report(material: Material, drawn: Mapping[Picture, tuple[str, str]] | None = None) -> str:
    """Return the page as HTML text; its pictures may be `drawn` already."""
    from markupsafe import Markup, escape

    uris = _drawn(material.pictures) if drawn is None else drawn
    templates = environment()
    templates.filters["uri"] = lambda picture: escape(uris[picture][0])  # no text for people
    blocks: list[dict[str, Any]] = []
    for section in find_sections():
        context = section.context(material)
        if context is None:
            continue
        name = section.__name__.rsplit(".", 1)[1]
        html = templates.get_template(f"sections/{name}.html").render(context)
        # The answer and, without a diagnosis, what it rests on; one screen that is not lost among proofs and settings.
        shown = len(blocks) < (1 if material.diagnosis is not None else 2)
        appendix = getattr(section, "APPENDIX", False) and bool(blocks) and material.diagnosis is not None
        blocks.append(
            # `html` is escaped by its own template; what is not `open` shows its title until it is clicked.
            {"id": name, "title": section.TITLE, "html": Markup(html), "open": shown, "appendix": appendix}
        )
    # Style and script are ours and contain no text from outside.
    style = Markup(report_style())
    script = Markup((FOLDER / "page.js").read_text("utf-8"))
    page = templates.get_template("page.html")
    blocks.sort(key=lambda block: bool(block["appendix"]))
    return page.render(material=material, blocks=blocks, style=style, script=script)


def report_style() -> str:
    """CSS of the report, on which the pages of apps build."""
    return colour_rules() + (FOLDER / "page.css").read_text("utf-8")


def write_report(material: Material, folder: str | Path) -> Path:
    """Write `report.html`, and its figures as PNG beside it, into `folder`; return the path of the page."""
    target = make_folder(folder)
    drawn = _drawn(material.pictures)
    page = write_text(target / "report.html", render_report(material, drawn))
    if drawn:
        figures = make_folder(target / "figures")
        for index, (picture, (_, png)) in enumerate(drawn.items(), start=1):
            write_bytes(figures / f"{index:02d}-{figure_file_name(picture.title)}.png", png_of_uri(png))
    return page


def _drawn(pictures: Sequence[Picture]) -> dict[Picture, tuple[str, str]]:
    """Every picture as two data URIs, as it stands in a page and as PNG."""
    return {picture: to_uris(picture.figure) for picture in pictures}


def environment() -> Environment:
    """Return the templates with autoescape, undefined names refused, the filters sections use, and no folder of whoever
    made the page in any text.
    """
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    beside = {Path(str(section.__file__)).parents[1]: None for section in find_sections()}  # a section's own template
    templates = Environment(
        loader=FileSystemLoader([FOLDER, *beside]), autoescape=True, undefined=StrictUndefined, trim_blocks=True,
        lstrip_blocks=True, finalize=_for_others,
    )  # fmt: skip
    templates.filters["number"] = number_in_page
    return templates


def number_in_page(value: Any, digits: int = 3) -> str:
    """Return a number with `digits` significant digits, or a dash for None and what is not finite."""
    if value is None or not math.isfinite(value):
        return "–"
    if isinstance(value, int):
        return str(value)
    text = f"{value:.{digits}g}"
    if 10**digits <= abs(float(text)) < 1e7:
        text = f"{value:.0f}"
    return text.replace("-", "\N{MINUS SIGN}")


def _for_others(value: Any) -> Any:
    return without_folders(value) if type(value) is str else value  # what is markup came through here as text


def figure_file_name(title: str) -> str:
    """Return a title as a file name."""
    return re.sub("[^a-z0-9]+", "-", title.lower()).strip("-")[:60] or "figure"


class Reported(AsJson):
    """A result that writes its report."""

    @abstractmethod
    def material(self) -> Material:
        """Material that the report draws on, the recordings apart."""

    def report(self, folder: str | Path = "exoid-report") -> Path:
        """Write the report into `folder`, made where there is none; return its path. OutputError where it cannot be."""
        return write_report(replace(self.material(), payload=self.to_json()), folder)
