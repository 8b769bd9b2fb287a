"""What the mapping dialog is told of a file."""

from __future__ import annotations

import pytest

from measurement.reading.columns import canonical_columns
from symbolic.joints import LEG, Joint
from workbench.commands.demo import DATA
from workbench.page.given import Given, mapping_preview

SLIDE = (Joint("cart", kind="prismatic"), Joint("pole"))


@pytest.mark.parametrize(("joints", "units"), [(LEG, ["rad", "N·m"]), (SLIDE, ["m", "N"])])
def test_every_column_that_may_be_there_is_asked_for_in_its_unit(joints, units):
    shown = mapping_preview(Given(1, "run.csv", DATA / "train_1.csv"), joints)
    assert [one["name"] for one in shown["wanted"]] == list(canonical_columns(joints))
    si = {one["name"]: one["si"] for one in shown["wanted"]}
    assert [si["q1"], si["tau1"]] == units and si["q2"] == "rad"
    assert shown["guess"]["q1"]["column"] == "q1" and len(shown["columns"][0]["first"]) > 2
