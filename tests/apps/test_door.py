"""`import exoid` has the names of apps as well."""

from __future__ import annotations

import exoid


def test_what_its_docstring_names_is_there():
    named = exoid.__doc__.split("the leg")[1].split("`dir(exoid)`")[0].split("`")[1::2]
    assert named and set(named) <= set(exoid.__all__)
