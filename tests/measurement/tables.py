"""A simulated leg, simple enough for tests of reading, and the text tables people would write it in."""

from __future__ import annotations

import numpy as np

N = 1500
HEADER = "t,q1,q2,tau1,tau2"


def leg(count=N, rate=100.0, seed=1):
    """Columns {name: (count,)} of a two-link pendulum with friction that follows two sines."""
    rng = np.random.default_rng(seed)
    t = np.arange(count) / rate
    w1, w2 = 2.0, 3.1
    q1, q2 = 0.6 + 0.5 * np.sin(w1 * t), -0.9 + 0.5 * np.sin(w2 * t + 1)
    v1, v2 = 0.5 * w1 * np.cos(w1 * t), 0.5 * w2 * np.cos(w2 * t + 1)
    a1, a2 = -(w1**2) * (q1 - 0.6), -(w2**2) * (q2 + 0.9)
    c, s = np.cos(q2), np.sin(q2)
    tau1 = 2 * a1 + 0.6 * (a1 + a2) + 0.8 * (c * (2 * a1 + a2) - s * (2 * v1 * v2 + v2**2))
    tau1 += 30 * np.sin(q1) + 10 * np.sin(q1 + q2) + 2 * np.sign(v1) + v1
    tau2 = 0.6 * (a1 + a2) + 0.8 * (c * a1 + s * v1**2) + 10 * np.sin(q1 + q2) + np.sign(v2) + v2
    noise = rng.normal(size=(2, count)) * 0.3
    return {"t": t, "q1": q1, "q2": q2, "tau1": tau1 + noise[0], "tau2": tau2 + noise[1]}


def lines(columns=None, sep=",", decimal=".", header=HEADER, units=""):
    """The lines of a text table: header, unit row if any, rows."""
    columns = columns or leg()
    rows = [sep.join(f"{x:.9g}".replace(".", decimal) for x in row) for row in zip(*columns.values(), strict=True)]
    head = [text.replace(",", sep) for text in (header, units) if text]
    return head + rows


def text(columns=None, eol="\n", **layout):
    return eol.join(lines(columns, **layout)) + eol
