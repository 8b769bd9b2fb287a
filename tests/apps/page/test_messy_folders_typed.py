"""The folders that are dropped on the page, on the command line: the same answer, by typing what is proposed."""

from __future__ import annotations

import pytest

from tests.typed_remedies import walk

from . import messy

pytestmark = pytest.mark.slow  # a search each


@pytest.mark.parametrize("fill", messy.FOLDERS, ids=lambda fill: fill.__name__)
def test_a_messy_folder_is_answered_as_on_the_page(fill, tmp_path, capsys):
    folder = tmp_path / fill.__name__
    folder.mkdir()
    missing, asked = fill(folder)
    capsys.readouterr()
    models = list(folder.glob("*.toml"))
    typed, out = walk(capsys, "discover", folder, *(["--model", models[0]] if models else []))
    answer = " ".join(out.split())
    assert f"Found: {missing}" in answer
    assert len(typed) == 2 * bool(asked)  # the button of the page is one option here
