"""Results become JSON in one place."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from exoid.ground.plain import AsJson, by_name, plain, plain_dict


@dataclass(frozen=True)
class Inner(AsJson):
    name: str
    value: float


@dataclass(frozen=True)
class Outer(AsJson):
    name: str
    inner: Inner

    @property
    def whole(self):
        return ("x", float("inf"))

    @property
    def both(self):
        return (self.inner, Inner("c", 3.0))

    def _json(self):
        return {"title": self.name, **super()._json(), "whole": self.whole, "values": by_name(self.both)}


def test_a_record_is_its_fields_in_json_unless_it_says_what_else():
    assert Outer("a", Inner("b", 2.0)).to_json() == {
        "title": "a", "name": "a", "inner": {"name": "b", "value": 2.0}, "whole": ["x", None],
        "values": {"b": {"name": "b", "value": 2.0}, "c": {"name": "c", "value": 3.0}},
    }  # fmt: skip


def test_everything_of_ours_becomes_what_json_has():
    given = {
        "array": np.array([1.0, np.inf]), "number": np.float64(2.0), "whole": np.int64(3), "flag": np.bool_(True),
        "inside": [Inner("a", float("nan"))], "pair": (1, None), "path": Path("run.csv"), 4: "key",
    }  # fmt: skip
    assert plain_dict(given) == {
        "array": [1.0, None], "number": 2.0, "whole": 3, "flag": True,
        "inside": [{"name": "a", "value": None}], "pair": [1, None], "path": "run.csv", "4": "key",
    }  # fmt: skip
    assert type(plain(np.float64(2.0))) is float and plain(True) is True


def test_what_has_no_json_form_is_refused():
    with pytest.raises(TypeError, match="object has no JSON form"):
        plain(object())
