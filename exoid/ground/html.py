"""Results as a notebook shows them: small tables and lines of HTML, everything escaped.

No colour of text or ground of its own, so that light and dark notebooks both look right; pictures bring their own
ground.
"""

from __future__ import annotations

import html
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from exoid.ground.figures import to_data_uri

BAR = "rgba(86, 180, 233, 0.35)"
"""Sky blue through which text of any colour can be read."""

LARGEST = 150_000
"""Characters of a drawing in a notebook, which keeps every one; a larger one is there in pixels."""


@dataclass(frozen=True)
class Bar:
    """A number of a table with a bar behind it, `share` of the cell long."""

    value: float | None
    share: float


def picture(figure: Any, alt: str) -> str:
    """Return a matplotlib figure that follows the reader's light or dark mode; a heavy one stays light."""
    uri = to_data_uri(figure, LARGEST, dpi=90)
    return f"<p><img src='{uri}' alt='{html.escape(alt, quote=True)}' style='max-width:100%;height:auto'></p>"


def table(head: Sequence[str], rows: Iterable[Sequence[Any]], caption: str = "") -> str:
    """Return a table; numbers get four significant digits and stand to the right, None is a dash, and columns of empty
    texts are left out.
    """
    whole = list(rows)
    told = [k for k in range(len(head)) if not whole or any(row[k] != "" for row in whole)]
    head, rows = [head[k] for k in told], [[row[k] for k in told] for row in whole]
    title = f"<caption style='text-align:left'>{html.escape(caption)}</caption>" if caption else ""
    names = "".join(f"<th style='text-align:left'>{html.escape(name)}</th>" for name in head)
    body = "".join(f"<tr>{''.join(_cell(value) for value in row)}</tr>" for row in rows)
    return f"<table>{title}<thead><tr>{names}</tr></thead><tbody>{body}</tbody></table>"


def lines(*texts: str, strong: str = "") -> str:
    """Return paragraphs, `strong` first in bold; empty texts are left out."""
    first = f"<p><strong>{html.escape(strong)}</strong></p>" if strong else ""
    return first + "".join(f"<p>{html.escape(text)}</p>" for text in texts if text)


def bullets(texts: Iterable[Any]) -> str:
    """Return a list, or nothing for no entries."""
    items = "".join(f"<li>{html.escape(str(text))}</li>" for text in texts)
    return f"<ul>{items}</ul>" if items else ""


def code(text: str) -> str:
    """Return a line of code."""
    return f"<pre>{html.escape(text)}</pre>"


def fold(title: str, content: str) -> str:
    """HTML that is shown when its `title` is clicked; nothing where there is nothing to show."""
    return f"<details><summary>{html.escape(title)}</summary>{content}</details>" if content else ""


def _cell(value: Any) -> str:
    if isinstance(value, Bar):
        end = f"{100 * min(max(value.share, 0.0), 1.0):.1f}%"
        ground = f"background:linear-gradient(90deg, {BAR} {end}, transparent {end})"
        return _cell(value.value).replace("<td style='", f"<td style='{ground};")
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return f"<td style='text-align:left'>{html.escape('–' if value is None else str(value))}</td>"
    text = str(value) if isinstance(value, int) else f"{value:.4g}" if math.isfinite(value) else "–"
    return f"<td style='text-align:right'>{text}</td>"
