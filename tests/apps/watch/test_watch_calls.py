"""`exoid.watch` takes recordings in any form, as every function of exoid does."""

from __future__ import annotations

import pytest

import exoid
from exoid.workbench.commands.demo import DATA

FILES = sorted(map(str, DATA.glob("*.csv")))
LEG = exoid.Model.standard()


def test_a_path():
    assert list(exoid.watch(LEG, FILES[0]))


def test_a_frame():
    pandas = pytest.importorskip("pandas")
    assert list(exoid.watch(LEG, pandas.read_csv(FILES[0])))


def test_two_models():
    assert exoid.watch(LEG, LEG.with_effect("stribeck:hip"), FILES[:1], FILES[3])
