"""Effects as layers: every step can be undone and gone back to."""

from __future__ import annotations

import pytest

from exoid.apps.page.history import History
from exoid.ground.errors import EffectError


def test_a_layer_is_added_switched_off_and_removed():
    history = History().add("stribeck:knee").switch("stribeck:knee")
    assert history.now.names == () and [layer.name for layer in history.now.layers] == ["stribeck:knee"]
    assert history.switch("stribeck:knee").now.names == ("stribeck:knee",)
    assert history.remove("stribeck:knee").now.layers == ()


def test_undo_and_redo_go_the_whole_way_and_stop_at_its_ends():
    history = History().add("stribeck:knee", "backlash:hip")
    back = history.undo().undo().undo()
    assert back.now.names == () and back.at == 0
    assert back.redo().redo().redo() == history


def test_a_new_step_forgets_what_was_undone():
    history = History().add("stribeck:knee").undo().add("backlash:hip")
    assert [step.label for step in history.steps] == ["base", "+ backlash:hip"]


@pytest.mark.parametrize(
    "wrong",
    [
        lambda h: h.add("stribeck:knee"),
        lambda h: h.switch("backlash:hip"),
        lambda h: h.remove("backlash:hip"),
        lambda h: h.go(7),
        lambda h: h.from_json({"steps": [], "at": 0}),
        lambda h: h.from_json("nothing"),
    ],
)
def test_what_cannot_be_is_refused(wrong):
    with pytest.raises(EffectError):
        wrong(History().add("stribeck:knee"))


def test_a_history_survives_being_written_down():
    history = History().add("stribeck:knee", "backlash:hip").switch("backlash:hip").undo()
    assert History.from_json(history.to_json()) == history
