"""The page on the paper in Markdown, and its pictures: docs/paper.md, and what `exoid paper --out` writes."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from exoid.apps.paper.item import Answered, PaperPicture
    from exoid.apps.paper.reproduce import Reproduced

DPI = 90
HEADS = {"figure": "Figures", "table": "Tables", "equation": "Equations"}


def page_of(found: Reproduced) -> str:
    """Return the page: all verdicts in one table, then each item with its command, its tables and its pictures."""
    rows = [
        f"| [{item.item.name}](#{anchor(item)}) | {item.item.title} | **{item.answer.holds}** |"
        for item in found.answered
    ]
    parts = [
        "# The paper, reproduced and assessed",
        "The paper: *Model Identification of 2-DOF Lower Limb Exoskeleton with Neighborhood Field Optimization "
        "Algorithm*. Its recordings are not published, so its experiments are repeated on the virtual bench with the "
        f"leg it identified, {found.seeds} seeds from {found.seed} on. This page is made by `exoid paper`; every "
        "number was measured in that run. What has no number in print, or one that is not known here, has a word.",
        "## What holds\n\n| item | about | the paper |\n| --- | --- | --- |\n" + "\n".join(rows),
    ]
    kind = ""
    for answer in found.answered:
        if answer.item.kind != kind:
            kind = answer.item.kind
            parts.append(f"## {HEADS[kind]}")
        parts.append(section(answer))
    return "\n\n".join(parts) + "\n"


def section(one: Answered) -> str:
    """Return one item: command, what the paper says, what comes out, whether it holds, formula, tables, pictures."""
    item, answer = one.item, one.answer
    verdict = f"**{answer.holds.capitalize()}**" + (f": {answer.why}." if answer.why else ".")
    parts = [
        f"### {heading(one)}",
        f"```sh\n{item.command}\n```",
        f"* The paper: {item.says}\n* Here: {answer.found}\n* {verdict}",
    ]
    if answer.text:
        parts.append(f"```text\n{answer.text}\n```")
    parts += [table.markdown() for table in answer.tables]
    parts += [f"![{picture.alt}]({name})" for name, picture in _named(one)]
    return "\n\n".join(parts)


def heading(one: Answered) -> str:
    """Return the head of an item's section."""
    return f"{one.item.name}: {one.item.title}"


def anchor(one: Answered) -> str:
    """Return the end of a link to the item's section: its head in small letters, without punctuation."""
    kept = "".join(c for c in heading(one).lower() if c.isalnum() or c in " -_")
    return kept.replace(" ", "-")


def pictures_in(found: Reproduced) -> dict[str, bytes]:
    """Return {file name: PNG} of all pictures."""
    from exoid.ground.figures import to_png

    return {name: to_png(picture.figure, dpi=DPI) for answer in found.answered for name, picture in _named(answer)}


def _named(one: Answered) -> Iterator[tuple[str, PaperPicture]]:
    for picture in one.answer.pictures:
        yield f"paper_{picture.name}.png", picture
