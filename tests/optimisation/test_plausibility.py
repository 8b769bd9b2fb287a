"""What a tool must say about a leg that cannot exist."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from paper_leg import NAMES, PAPER, THIGH, UNITS, Leg

from exoid.optimisation.fitting.plausibility import check_plausibility, mass_matrix
from exoid.symbolic.quantity import Estimate

PAPER_SSE = np.array([27.97, 12.15, 1.79, -8.41, 31.83, 15.25, 52.39, -5.89])


def estimates(linear, half):
    return [Estimate(n, v, u, v - half, v + half) for n, u, v in zip(NAMES, UNITS, linear, strict=True)]


def check(linear, half=0.5):
    linear = np.asarray(linear, dtype=float)
    return check_plausibility(Leg(), linear, estimates(linear, half))


def test_the_papers_huber_fit_is_a_possible_leg():
    assert check(PAPER) == ()


def test_the_papers_sse_fit_has_an_impossible_viscosity():
    (finding,) = check(PAPER_SSE)
    assert finding.severity == "warning"
    assert finding.where == "viscous:knee"
    assert "-5.89 N·m·s/rad is negative, which is physically impossible" in finding.what
    assert "interval excludes 0" in finding.what
    assert finding.value == -5.89
    assert finding.limit == 0.0
    assert "diagnose" in finding.remedy


def test_an_interval_that_reaches_zero_is_said_to():
    (finding,) = check(PAPER_SSE, half=10.0)
    assert finding.severity == "info"
    assert "cannot tell it from that" in finding.what


def test_negative_inertia_names_the_posture():
    findings = check([1.0, 7.42, 1.43, 8.0, 1, 1, 1, 1])
    inertia = next(f for f in findings if f.check == "inertia")
    assert "-1.62 to" in inertia.what
    assert inertia.value < 0.0


def test_mass_matrix_is_the_legs():
    angles = np.array([[0.2, -1.0], [0.5, -0.3]])
    mass = mass_matrix(Leg(), PAPER, None, angles)
    cosine = np.cos(angles[:, 1])
    assert np.allclose(mass[:, 0, 0], PAPER[0] + 2 * PAPER[2] * cosine)
    assert np.allclose(mass[:, 0, 1], PAPER[1] + PAPER[2] * cosine)
    assert np.allclose(mass, mass.transpose(0, 2, 1))


positive = st.floats(0.05, 5.0)


@given(m_th=positive, m_sh=positive, l_th=positive, l_sh=positive, i_th=positive, i_sh=positive)
def test_every_physical_leg_is_called_possible(m_th, m_sh, l_th, l_sh, i_th, i_sh):
    two = i_sh + m_sh * l_sh**2
    one = i_th + m_th * l_th**2 + m_sh * THIGH**2 + two
    four = m_th * THIGH * l_th - i_th - m_th * l_th**2
    assert check([one, two, m_sh * THIGH * l_sh, four, 1, 1, 1, 1]) == ()


def test_a_leg_without_masses_is_called_impossible():
    assert any(f.check == "realisable" for f in check([8.0, 7.42, 1.43, -3.0, 1, 1, 1, 1]))
    assert any(f.where == "Phi3" for f in check([25.0, 7.42, -1.43, -3.0, 1, 1, 1, 1]))
