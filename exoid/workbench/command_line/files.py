"""JSON as a command writes it: to a file, or to standard output for "-"."""

from __future__ import annotations

import json
import sys
from typing import Any

from exoid.ground.output import OutputError, check_target, json_text, write_text
from exoid.workbench.terminal.encoding import is_closed, spells


def check_json(path: str) -> None:
    """Refuse a --json that cannot be written, or would replace what is no JSON."""
    if path == "-" and is_closed(sys.stdout):
        raise OutputError("standard output is closed", where="--json -", remedy="name a file, or leave it open")
    if path != "-":
        check_target(path, lambda content: not content.strip() or content.lstrip()[:1] in (b"{", b"["))


def write_json(target: str, payload: Any) -> None:
    """Write `payload` as JSON to the file `target`, or to standard output for "-"."""
    text = json_text(payload)
    if target == "-":
        # A stream without θ gets \u03b8, which is the same JSON.
        sys.stdout.write(text if spells(sys.stdout, text) else json.dumps(json.loads(text), indent=2) + "\n")
    else:
        write_text(target, text)
