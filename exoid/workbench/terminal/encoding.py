"""Text for terminals and files that know no Greek: "N·m" becomes "N*m", not "N?m"; and for streams that are closed."""

from __future__ import annotations

import codecs
import io
import os
import sys
from collections.abc import Mapping
from types import MappingProxyType
from typing import TextIO

STDERR = 2
"""The last of the numbers that standard streams have."""
HANDLER = "exoid-ascii"
"""Name of the error handler that `install` registers."""

PLAIN: Mapping[str, str] = MappingProxyType(
    {
        "·": "*", "×": "x", "±": "+-", "≤": "<=", "≥": ">=", "≈": "~", "≡": "==", "≠": "!=", "→": "->", "−": "-",
        "–": "-", "—": "-", "…": "...", "‘": "'", "’": "'", "“": '"', "”": '"', "′": "'", "″": "''", "°": "deg",
        "²": "^2", "³": "^3", "⁰": "^0", "¹": "^1", "⁴": "^4", "⁵": "^5", "⁶": "^6", "⁷": "^7", "⁸": "^8", "⁹": "^9",
        "⁻": "^-", "ᵀ": "^T", "₀": "0", "₁": "1", "₂": "2", "₃": "3", "∞": "inf", "Σ": "sum ", "√": "sqrt ", "∂": "d",
        "θ": "theta", "τ": "tau", "Φ": "Phi", "φ": "phi", "δ": "delta", "Δ": "Delta", "α": "alpha", "β": "beta",
        "ω": "omega", "π": "pi", "µ": "u", "μ": "u", "σ": "sigma", "λ": "lambda", "∈": "in", "é": "e", "ö": "o",
    }
)  # fmt: skip
"""Characters exoid writes and how they are spelt in ASCII."""

BAR = str.maketrans({**dict.fromkeys("█▉▊▋▌", "#"), **dict.fromkeys("▍▎▏", "")})
"""Bars of blocks as bars of "#"."""


def ascii_text(text: str) -> str:
    """Return `text` in ASCII; a character without a spelling becomes "?"."""
    return "".join(c if c.isascii() else PLAIN.get(c, "?") for c in text.translate(BAR))


def spells(stream: TextIO, sample: str = "θ·█") -> bool:
    """True if `stream` can write what exoid writes."""
    try:
        sample.encode(stream.encoding or "utf-8")
    except (UnicodeEncodeError, LookupError):
        return False
    return True


_NOWHERE: list[TextIO] = []
"""Streams in the place of closed ones."""


def is_closed(stream: TextIO) -> bool:
    """True if what is written to a standard stream comes to nobody: it was closed (`>&-`)."""
    return any(stream is item for item in _NOWHERE)


def _open_closed() -> None:
    """Let standard streams that are closed lead nowhere: a file that is opened would get their number, and hold what is
    meant for them.
    """
    while (number := os.open(os.devnull, os.O_RDWR)) <= STDERR:
        os.set_inheritable(number, True)
    os.close(number)
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        if getattr(sys, name) is None:
            stream = io.TextIOWrapper(open(os.devnull, f"{mode}b"), "utf-8")  # noqa: SIM115 - as long as we live
            setattr(sys, name, stream)
            _NOWHERE.append(stream)


def install() -> None:
    """Make standard output and error spell what their encoding lacks, so that nothing is a traceback or a "?"."""
    _open_closed()
    codecs.register_error(HANDLER, _handle)
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors=HANDLER)


def _handle(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    return ascii_text(error.object[error.start : error.end]), error.end
