"""The notebooks as they are committed: each opens with its question, was run, and is small. CI runs them anew."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

NOTEBOOKS = sorted((Path(__file__).resolve().parents[2] / "notebooks").glob("*.ipynb"))
LARGEST = 400_000


@pytest.fixture(params=NOTEBOOKS, ids=lambda path: path.stem)
def notebook(request):
    return json.loads(request.param.read_text(encoding="utf-8"))


def code(notebook):
    return [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]


def test_they_are_numbered_without_a_gap():
    assert [int(path.stem[:2]) for path in NOTEBOOKS] == list(range(1, len(NOTEBOOKS) + 1))


def test_it_opens_with_its_question(notebook):
    first = notebook["cells"][0]
    assert first["cell_type"] == "markdown"
    assert re.match(r"# .+\?$", "".join(first["source"]).splitlines()[0])


def test_it_was_run_from_top_to_bottom_without_a_warning(notebook):
    counts = [cell["execution_count"] for cell in code(notebook)]
    assert counts == list(range(1, len(counts) + 1))
    outputs = [output for cell in code(notebook) for output in cell["outputs"]]
    assert any("image/png" in output.get("data", {}) for output in outputs)
    assert not [o for o in outputs if o["output_type"] == "error" or o.get("name") == "stderr"]


def test_it_is_small_and_names_no_place_on_a_machine(notebook):
    assert len(json.dumps(notebook)) < LARGEST
    assert "widgets" not in notebook["metadata"]
    shown = json.dumps([cell["outputs"] for cell in code(notebook)])
    assert not re.search(r"(?<![\w/])/(home|root|work|Users)/", shown)
