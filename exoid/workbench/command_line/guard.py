"""No output of a command is one of its inputs: what the command line names is looked at before the work starts."""

from __future__ import annotations

import argparse
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from exoid.ground.delivery import Delivery

OUTPUTS = ("json", "out", "write", "state")
"""Options that name what is written, a state read before that; whatever else names a file on a command line names an
input.
"""
NEITHER = (*OUTPUTS, "command_line")


def protect_inputs(args: argparse.Namespace, delivery: Delivery) -> None:
    """Let `delivery` refuse to write to any file that `args` name, whatever the option is called."""
    for option, value in vars(args).items():
        if option in NEITHER:
            continue
        for text in _texts(value):
            # FILE, FILE=KG@M, NAME=FILE
            for path in {text, text.rpartition("=")[0], text.partition("=")[2], *_archives(text)}:
                try:
                    status = os.stat(path) if path else None
                except (OSError, ValueError):
                    continue
                if status is not None:
                    delivery.note(status, path)


def _archives(text: str) -> list[str]:
    """Return the archives that `archive.zip/run1.csv` may lie in."""
    return [str(parent) for parent in Path(text).parents if parent.suffix.lower() == ".zip"]


def _texts(value: Any) -> Iterator[str]:
    if isinstance(value, str):
        yield value
    elif isinstance(value, dict):
        for item in value.values():
            yield from _texts(item)
    elif isinstance(value, (list, tuple)):
        for item in value:
            yield from _texts(item)
