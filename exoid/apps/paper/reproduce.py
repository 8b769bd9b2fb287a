"""Figures, tables and equations of the paper, made again on the virtual bench and judged.

    reproduce_paper()                       everything
    reproduce_paper(figure="9")             one item; several as ("5", "10")
    reproduce_paper(equation="regressor")   where it has no number in print, by its subject
"""

from __future__ import annotations

import importlib
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from exoid.apps.paper import items
from exoid.apps.paper.experiments import Experiments
from exoid.apps.paper.item import SEEDS, Answered, PaperItem, item_of, item_order
from exoid.ground.errors import ExoidError
from exoid.ground.folder import modules_in
from exoid.ground.frames import pandas
from exoid.ground.html import table
from exoid.ground.plain import AsJson
from exoid.ground.progress import Progress, silent
from exoid.ground.suggest import did_you_mean

if TYPE_CHECKING:
    import pandas as pd


Asked = str | int | Sequence[str | int]
"""One item or several, by number or by name."""


class PaperError(ExoidError):
    """An item that the paper does not have."""


@dataclass(frozen=True, eq=False)
class Reproduced(AsJson):
    """Reproduced items, in the order of the paper's kinds; of `seeds` seeds from `seed` on."""

    answered: tuple[Answered, ...]
    seed: int
    seeds: int
    seconds: float = field(default=0.0, repr=False)

    def __repr__(self) -> str:
        return "\n".join(answer.line for answer in self.answered)

    def _repr_html_(self) -> str:
        head = ("item", "the paper says", "here", "it", "why not")
        return table(head, self.rows())

    def rows(self) -> list[tuple[str, str, str, str, str]]:
        """Return of each item its name, what the paper says, what comes out, whether it holds, why not."""
        return [
            (entry.item.name, entry.item.says, entry.answer.found, entry.answer.holds, entry.answer.why)
            for entry in self.answered
        ]

    def to_frame(self) -> pd.DataFrame:
        """Return the same as a data frame."""
        columns = ["item", "says", "found", "holds", "why"]
        return pandas().DataFrame(self.rows(), columns=columns)

    def _json(self) -> dict[str, Any]:
        return {"items": self.answered, "seed": self.seed, "seeds": self.seeds}


def paper_items() -> tuple[PaperItem, ...]:
    """Return every item there is, figures first, then tables and equations."""
    return tuple(sorted((item_of(name, module) for name, module in modules_in(items).items()), key=item_order))


def reproduce_paper(
    *, figure: Asked = (), table: Asked = (), equation: Asked = (), seed: int = 0, seeds: int = SEEDS,
    progress: Progress | None = None,
) -> Reproduced:  # fmt: skip
    """Make the items asked for again, all where none is, and say of each whether the paper holds.

    Items are asked for by their number in print, or by the word that stands for it (`paper_items()` has them). What is
    random is repeated for `seeds` seeds from `seed` on. PaperError for an item that there is not.
    """
    began, say = time.perf_counter(), progress or silent
    if seeds < 2:
        what = "one seed cannot show run-to-run variation"
        raise PaperError(what, where=f"--seeds {seeds}", remedy=f"give two at least, or {SEEDS}")
    chosen = _chosen({"figure": figure, "table": table, "equation": equation})
    experiments = Experiments(seed, seeds)
    answered: list[Answered] = []
    try:
        for item in chosen:
            say(len(answered) / len(chosen), item.name)
            module = importlib.import_module(f"{items.__name__}.{item.file}")
            answered.append(Answered(item, module.answer(experiments)))
    finally:
        experiments.close(ended=len(answered) == len(chosen))
    return Reproduced(tuple(answered), seed, seeds, time.perf_counter() - began)


def _chosen(asked: Mapping[str, Asked]) -> list[PaperItem]:
    """Return the items that are asked for; all where none is."""
    known = paper_items()
    wanted = [(kind, word) for kind, given in asked.items() for word in _words(given)]
    for kind, word in wanted:
        names = [number for item in known if item.kind == kind for number in item.numbers]
        if word not in names:
            remedy = did_you_mean(word, names) or f"there are {', '.join(names)}"
            raise PaperError(f"there is no {kind} {word!r} of the paper here", where=f"--{kind}", remedy=remedy)
    return [item for item in known if not wanted or any((item.kind, word) in wanted for word in item.numbers)]


def _words(given: Asked) -> list[str]:
    return [str(word) for word in ([given] if isinstance(given, (str, int)) else given)]
