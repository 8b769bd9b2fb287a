"""Everything a report may draw on; each section takes what it needs and is silent without it."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from datetime import date
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from exoid.measurement.recording import Recording

FALLING = "The error falling"
"""Title of the figure that every result with steps draws."""
FOLDERS = re.compile(r"""(?<![\w.~/\\])(?:/|[A-Za-z]:[/\\]+)(?:[^\s/\\:"'<>]+[/\\]+)+""")
"""The folders of an absolute path, up to the name of the file."""
MOST_NAMED = 4
"""Recordings whose names stand below the title; of more their number is told."""
WIDE = 6.5
"""Inches from which on a figure does not share its row with another."""
NOTHING_HELD_OUT = (
    "Nothing is held out: these errors are on the motion that was fitted, and say little about any other. "
    "Name a recording that is not fitted with --verify."
)
"""What is said where no recording is verified."""
Context = Mapping[str, Any] | None
"""What the template of a section shows; None where the section has nothing to say."""


@dataclass(frozen=True, eq=False)
class Picture:
    """A figure with its `title` and `alt`, the sentence that stands for it where it cannot be seen.

    `section` names the section it belongs to ("" for the section of figures).
    """

    title: str
    alt: str
    figure: Any
    section: str = ""

    @property
    def wide(self) -> bool:
        """True if it needs the whole width of the page."""
        return float(self.figure.get_figwidth()) > WIDE


@dataclass(frozen=True, eq=False)
class Material:
    """The results of one command. `answer` stands at the top where there is no diagnosis, `fall` is the Diagnosis or
    the Waterfall whose steps are shown, `payload` the JSON.
    """

    title: str
    answer: str = ""
    recordings: tuple[Recording, ...] = ()
    verify: tuple[Recording, ...] = ()
    model: Any = None
    fit: Any = None
    by_recording: Any = None
    comparison: Any = None
    diagnosis: Any = None
    fall: Any = None
    pictures: tuple[Picture, ...] = ()
    truth: str = ""
    command: str = ""
    settings: Mapping[str, str] = field(default_factory=dict)
    seconds: float | None = None
    payload: Any = None
    made: date = field(default_factory=date.today)

    @property
    def about(self) -> str:
        """The line below the title: machine, files, and the day on which the report was made."""
        parts = [str(getattr(self.model, "name", "")), _some(self.recordings), _some(self.verify, "held out ")]
        parts.append(f"{self.made.day} {self.made:%B %Y}")
        return " · ".join(part for part in parts if part)

    def pictures_in(self, section: str) -> tuple[Picture, ...]:
        """Return the pictures that belong to `section`."""
        return tuple(picture for picture in self.pictures if picture.section == section)


def _some(recordings: Sequence[Recording], before: str = "") -> str:
    names = [recording.name for recording in recordings[:MOST_NAMED]]
    more = len(recordings) - len(names)
    return (before + ", ".join(names) + (f" and {more} more" if more else "")) if names else ""


def pictures_of(*results: Any, section: str = "") -> tuple[Picture, ...]:
    """Return the pictures of every result that draws some, in their order, for one `section` of the page.

    The falling error goes to its own section, which shows it as bars that fit a phone.
    """
    return tuple(
        Picture(title, alt, figure, "falling" if title == FALLING else section)
        for result in results
        if hasattr(result, "figures")
        for title, alt, figure in result.figures()
    )


def picture_of_fit(fit: Any) -> Picture:
    """Return the plot of a Fit."""
    alt = "Torque and residual of every joint, intervals of the parameters, and how each optimiser converged."
    return Picture("The fit: residuals, intervals, convergence", alt, fit.plot())


def without_folders(text: str) -> str:
    """Return `text` with the names of files in place of their whole paths: a page is made to be handed on."""
    return FOLDERS.sub("", text)
