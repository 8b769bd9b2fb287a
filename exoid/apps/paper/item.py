"""An item of the paper, and the answer to it: what comes out here, whether the paper holds, and why not where not."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from exoid.ground import html
from exoid.ground.plain import AsJson

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SEEDS = 5
"""Runs of whatever is random, where no other number is asked for."""
KINDS = ("figure", "table", "equation")
HOLDS, IN_PART, FAILS, UNKNOWN = "holds", "holds in part", "does not hold", "cannot be known"
"""What may be said of a claim."""


@dataclass(frozen=True)
class PaperItem(AsJson):
    """A figure, table or equation: its `kind`, its `numbers` in print or a word where it has none, and what the paper
    `says`. `file` is the module that answers it.
    """

    kind: str
    numbers: tuple[str, ...]
    title: str
    says: str
    file: str

    @property
    def name(self) -> str:
        """Its name in a sentence: "Figures 5 and 6", "Equation: regressor"."""
        if not self.printed:
            return f"{self.kind.capitalize()}: {' '.join(self.numbers)}"
        many = "s" if len(self.numbers) > 1 else ""
        listed = " and ".join(filter(None, (", ".join(self.numbers[:-1]), self.numbers[-1])))
        return f"{self.kind.capitalize()}{many} {listed}"

    @property
    def printed(self) -> bool:
        """True if it has a number in the paper, or one that is known here."""
        return self.numbers[0].isdecimal()

    @property
    def command(self) -> str:
        """The command that makes it."""
        return f"exoid paper --{self.kind} {self.numbers[0]}"

    def _json(self) -> dict[str, Any]:
        return {"kind": self.kind, "numbers": self.numbers, "title": self.title, "says": self.says}


@dataclass(frozen=True)
class PaperTable(AsJson):
    """A table: its `head`, its `rows` of text, and a `caption`."""

    head: Sequence[str]
    rows: Sequence[Sequence[str]]
    caption: str = ""

    def markdown(self) -> str:
        """Return it in Markdown."""
        lines = [self.head, ["---"] * len(self.head), *self.rows]
        body = "\n".join("| " + " | ".join(str(cell).replace("|", "\\|") for cell in line) + " |" for line in lines)
        return f"{self.caption}\n\n{body}" if self.caption else body


@dataclass(frozen=True, eq=False)
class PaperPicture(AsJson):
    """A figure and `alt`, the sentence that stands for it where it cannot be seen; `name` is a word for its file."""

    name: str
    alt: str
    figure: Figure

    def _json(self) -> dict[str, Any]:
        return {"name": self.name, "alt": self.alt}


@dataclass(frozen=True, eq=False)
class ItemAnswer(AsJson):
    """The result (`found`), whether the claim `holds` (one of four phrases), and `why` not where it does not.

    `text` is a formula, line by line.
    """

    found: str
    holds: str
    why: str = ""
    text: str = ""
    tables: tuple[PaperTable, ...] = ()
    pictures: tuple[PaperPicture, ...] = field(default=(), repr=False)

    def __post_init__(self) -> None:
        if (self.holds == HOLDS) == bool(self.why) or self.holds not in (HOLDS, IN_PART, FAILS, UNKNOWN):
            raise ValueError(f"{self.holds!r} because of {self.why!r}: what does not hold has a reason, and only that")


@dataclass(frozen=True, eq=False)
class Answered(AsJson):
    """An item with its answer."""

    item: PaperItem
    answer: ItemAnswer

    @property
    def line(self) -> str:
        """The paper's claim, what comes out, whether it holds, and why not where not, in one line."""
        item, answer = self.item, self.answer
        verdict = f"{answer.holds}: {answer.why}" if answer.why else answer.holds
        return f"{item.name}, {item.title}. The paper: {item.says} Here: {answer.found} It {verdict}."

    def _repr_html_(self) -> str:
        answer = self.answer
        shown = "".join(html.table(table.head, table.rows, table.caption) for table in answer.tables)
        return html.lines(self.line) + (html.code(answer.text) if answer.text else "") + shown


def item_of(file: str, module: Any) -> PaperItem:
    """Return the item of a module of the folder `items`; its file's name says what kind it is and its numbers."""
    kind, *words = file.split("_")
    numbers = tuple(str(int(word)) if word.isdecimal() else word for word in words)
    return PaperItem(kind, numbers, module.TITLE, module.SAYS, file)


def item_order(item: PaperItem) -> tuple[int, int, str]:
    """Return the place of an item: by kind, by number, what has none behind."""
    number = int(item.numbers[0]) if item.printed else 1_000
    return KINDS.index(item.kind), number, item.file


def is_file(name: str) -> bool:
    """True if a module of the folder is called as an item is."""
    return re.fullmatch(rf"({'|'.join(KINDS)})(_\d+)+|({'|'.join(KINDS)})_[a-z]+", name) is not None
