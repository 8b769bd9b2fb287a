"""Closed forms that come close to a learnt curve: found as well as SciPy's bounded least squares finds them."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.optimize import least_squares

from exoid.diagnosis.evidence.remainder import suggest
from exoid.symbolic.joints import LEG

FORMS = {
    "exp": lambda x, m, w: np.exp(-(((x - m) / w) ** 2)),
    "tanh": lambda x, m, w: np.tanh((x - m) / w),
    "**2": lambda x, m, w: (x - m) ** 2,
    "**3": lambda x, m, w: (x - m) ** 3,
}


def _form_of(text: str) -> str:
    return next(name for name in FORMS if name in text.replace("exp(-((theta - m)/w)**2)", "exp"))


@pytest.mark.parametrize("name", FORMS)
@pytest.mark.parametrize("seed", range(4))
def test_the_form_that_a_curve_has_comes_first_with_the_numbers_that_scipy_finds(name: str, seed: int) -> None:
    rng = np.random.default_rng(seed)
    x = np.linspace(-1.0, 2.0, 121)
    truth = np.array([rng.uniform(-0.7, 1.7), rng.uniform(0.25, 0.9)])
    y = FORMS[name](x, *truth)
    y = y + 0.01 * np.ptp(y) * rng.standard_normal(x.size)
    curve = SimpleNamespace(x=x, y=y, variable="q1", factor="", index=0, directed=False, joints=LEG)
    found = suggest(curve)  # type: ignore[arg-type]
    best = next(s for s in found if _form_of(s.text) == name)
    assert best.share > found[0].share - 1e-3
    values = [entry[3] for entry in best.shape.values()]

    def misfit(p: np.ndarray) -> np.ndarray:
        g = FORMS[name](x, *[*p, 1.0][:2])
        g, own = g - g.mean(), y - y.mean()
        return own - float(g @ own) / float(g @ g) * g

    low, high = ([entry[k] for entry in best.shape.values()] for k in (1, 2))
    theirs = least_squares(misfit, truth[: len(values)], bounds=(low, high), xtol=1e-12, ftol=1e-12, gtol=1e-12)
    assert np.sum(misfit(np.array(values)) ** 2) <= 2.0 * theirs.cost * (1.0 + 1e-6)
    assert np.allclose(values, theirs.x, rtol=1e-3, atol=1e-3)


def test_a_curve_that_never_changes_suggests_nothing() -> None:
    x = np.linspace(0.0, 1.0, 121)
    flat = SimpleNamespace(x=x, y=0.0 * x, variable="q1", factor="", index=0, directed=False, joints=LEG)
    assert not suggest(flat)  # type: ignore[arg-type]
