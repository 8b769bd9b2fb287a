"""The figure of the falling error: names of steps stand beside each other, however many there are."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest

from exoid.diagnosis.plots import UPRIGHT, falling_error

LONG = "+ Viscosity that grows less than speed at joint_2"


@pytest.mark.parametrize("unseen", [False, True])
@pytest.mark.parametrize(("steps", "joints"), [(2, 1), (3, 2), (4, 2), (13, 6)])
def test_no_name_is_printed_over_another(steps, joints, unseen):
    names = ["base", *[LONG if k % 2 else "+ Joint spring at joint_1" for k in range(1, steps)]]
    error = np.linspace(1.0, 0.2, steps)[:, None] * np.ones(joints)
    called = [f"joint_{k + 1}" for k in range(joints)]
    figure = falling_error(names, error, 1.1 * error if unseen else None, np.full(joints, 0.1), called)
    figure.canvas.draw()
    axes = figure.axes[0]
    texts = axes.get_yticklabels() if steps > UPRIGHT else axes.get_xticklabels()
    boxes = [text.get_window_extent() for text in texts if text.get_text()]
    assert len(boxes) == steps
    for one, other in combinations(boxes, 2):
        across, down = min(one.x1, other.x1) - max(one.x0, other.x0), min(one.y1, other.y1) - max(one.y0, other.y0)
        assert min(across, down) < 1.0
