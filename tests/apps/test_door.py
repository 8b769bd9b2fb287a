"""The core and its apps together: names of `import exoid`, groups of commands."""

from __future__ import annotations

import exoid
from exoid.workbench.command import GROUPS, find_verbs, load_verb


def test_what_its_docstring_names_is_there():
    named = exoid.__doc__.split("the leg")[1].split("`dir(exoid)`")[0].split("`")[1::2]
    assert named and set(named) <= set(exoid.__all__)


def test_every_group_of_commands_has_one():
    assert {load_verb(verb).GROUP for verb in find_verbs()} == set(GROUPS)


def test_dir_shows_what_people_use_and_what_there_is():
    shown = dir(exoid)
    assert {"discover", "Model", "read_recording", "add", "simulate"} <= set(shown) <= {"__version__", *exoid.__all__}
    assert len(shown) < 40
