"""A leg that follows two sines, written under any header."""

import numpy as np

COLUMNS = ("t", "q1", "q2", "tau1", "tau2")


def columns(count=1200, rate=100.0):
    """Columns {name: (count,)}: weight, viscous friction and noise."""
    t = np.arange(count) / rate
    q1, q2 = 0.6 + 0.5 * np.sin(2.0 * t), -0.9 + 0.5 * np.sin(3.1 * t + 1)
    noise = np.random.default_rng(1).normal(size=(2, count)) * 0.1
    tau2 = 10 * np.sin(q1 + q2) + np.gradient(q2, t)
    tau1 = 30 * np.sin(q1) + 10 * np.sin(q1 + q2) + np.gradient(q1, t)
    return {"t": t, "q1": q1, "q2": q2, "tau1": tau1 + noise[0], "tau2": tau2 + noise[1]}


def written(path, header, names=COLUMNS, degrees=False):
    """Write the columns `names` under `header` as CSV and return the path."""
    leg = columns()
    if degrees:
        leg |= {name: np.degrees(leg[name]) for name in ("q1", "q2")}
    cells = np.column_stack([leg[name] for name in names])
    path.write_text(header + "\n" + "\n".join(",".join(f"{x:.9g}" for x in row) for row in cells) + "\n")
    return path
