"""--payload: known masses named on the command line."""

import pytest

from exoid.symbolic.mechanics.payload import PayloadError
from exoid.symbolic.model import Model
from exoid.workbench.command_line.inputs import payload_of, payloads
from exoid.workbench.command_line.parser import UsageError

PATHS = ["a/run.csv", "b/run.csv", "b/x=1.csv"]


def test_recordings_are_named_by_path_or_by_name_alone():
    found = payloads(["a/run.csv=2@0.35", "x=1.csv=thigh:1@0.2", "a/run.csv=1e0@.1"], PATHS)
    assert {k: [str(p) for p in v] for k, v in found.items()} == {
        "a/run.csv": ["shank:2@0.35", "shank:1@0.1"],
        "b/x=1.csv": ["thigh:1@0.2"],
    }
    assert payloads([], PATHS) == {}


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("run.csv=2@0.35", "more than one"),
        ("c.csv=2@0.35", "none of the recordings"),
        ("2@0.35", "not FILE=KG@M"),
        ("a/run.csv=2", "not KG@M"),
        ("a/run.csv=shank", "not KG@M"),
        ("a/run.csv=two@0.35", "not KG@M"),
        ("a/run.csv=2@0.35@1", "not KG@M"),
        ("", "not FILE=KG@M"),
    ],
)
def test_a_mistake_is_explained(text, word):
    with pytest.raises(UsageError, match=word):
        payloads([text], PATHS)


def test_units_and_links_are_checked():
    for text, word in (
        ("2@350", "m from"),
        (":2@0.3", "thigh or shank"),
        ("-1@0.2", "kg"),
    ):
        with pytest.raises(PayloadError, match=word):
            payload_of(text)
    with pytest.raises(PayloadError, match="thigh or shank"):
        payload_of("foot:2@0.3").added(Model.standard())
