"""A person at the command line, who types the remedy that is printed."""

from __future__ import annotations

import re
import shlex
import warnings
from itertools import pairwise

from exoid.workbench.command import main

MOST = 2
"""Remedies that are typed at most before there is an answer."""
OPTION = re.compile(r"--(?:map|units|passive|rate|leg|convention) (?:'[^']*'|[^\s?;]*[^\s?;,])")
"""An option with its value, as a remedy prints it."""
INSIDE = ("Traceback", "Warning", "internal error", "np.", "nan", "None")
"""What no line may hold that a person reads."""


def first_option(remedy):
    """The words of the first options in a remedy, those that stand side by side together."""
    found = list(OPTION.finditer(remedy))
    kept = found[:1] + [b for a, b in pairwise(found) if remedy[a.end() : b.start()] == " "]
    return [word for match in kept for word in shlex.split(match[0])]


def walk(capsys, verb, *words):
    """Type `exoid VERB` with `words`, then with what is proposed until there is an answer; what was typed besides, and
    the answer.
    """
    typed, seen = [], set()
    while True:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            status = main([verb, *map(str, words), *typed])
        out, err = capsys.readouterr()
        assert not [mark for mark in INSIDE if re.search(rf"(?<!\w){re.escape(mark)}", out + err)], out + err
        proposal = err.partition("what to do:")[2] if status == 2 else out.partition("first give ")[2]
        option = first_option(proposal)
        if status == 0 or (status == 1 and not option):
            return typed, out
        assert option and err + out not in seen, err
        seen.add(err + out)
        assert len(seen) <= MOST, err
        typed += option
