"""How far the noise of encoders pulls inertias, for each way to differentiate, noise and cut-off.

    python benchmarks/derivatives.py [--draws 8]

The motion of the bench's leg (three periods of 10 s) is known exactly; to its angles white noise is added, again and
again. The torque is exact, so that whatever happens to the parameters comes from the angles. Printed is the mean error
of Φ1 and Φ2 in per cent (negative: pulled towards zero) and, in brackets, its scatter from draw to draw.
"""

from __future__ import annotations

import argparse
import os
import sys
from dataclasses import replace
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # must be set before NumPy is imported

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from exoid.measurement.bench.leg import standard_leg  # noqa: E402
from exoid.measurement.bench.sensors import Sensors  # noqa: E402
from exoid.measurement.bench.simulation import Bench, run_bench  # noqa: E402 - the repository must be on the path first
from exoid.measurement.signals.derivatives import METHODS  # noqa: E402
from exoid.measurement.trajectories.trajectory import random_trajectory  # noqa: E402
from exoid.optimisation.fitting.identify import identify  # noqa: E402
from exoid.optimisation.preparation.prepare import prepare  # noqa: E402
from exoid.symbolic.model import Model  # noqa: E402

NOISES = (1e-4, 5e-4, 2e-3)
"""rad, standard deviation of each sample; 17 bits of a turn are 5e-5."""
CUTOFFS = (4.0, 8.0)


def main() -> int:
    text, _, rest = (__doc__ or "").partition("\n\n")
    form = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=text, epilog=rest, formatter_class=form)
    parser.add_argument("--draws", type=int, default=8)
    given = parser.parse_args()
    model, leg = Model.standard(), standard_leg()
    path = random_trajectory(np.random.default_rng(3), model.limits, period=10.0)
    exact = run_bench(excitation=path, bench=Bench(duration=30.0, sensors=Sensors.ideal()), seed=3)
    clean = replace(exact.recording, q=exact.motion.q, tau=exact.torque)
    print("| noise [rad] | cut-off [Hz] | " + " | ".join(f"{m}: Φ1, Φ2 [%]" for m in METHODS) + " |")
    print("|---|---|" + "---|" * len(METHODS))
    for noise in NOISES:
        for cutoff in CUTOFFS:
            cells = []
            for method in METHODS:
                errors = []
                for draw in range(given.draws):
                    added = np.random.default_rng([draw, 5]).normal(0.0, noise, clean.q.shape)
                    noisy = replace(clean, q=clean.q + added)
                    train = prepare(model, [noisy], cutoff=cutoff, derivative=method).train
                    fit = identify(model, train, optimisers=())
                    errors.append(100.0 * (fit.linear[:2] / np.array(leg.base[:2]) - 1.0))
                mean, scatter = np.mean(errors, axis=0), np.std(errors, axis=0)
                cells.append(", ".join(f"{m:+.1f} ({s:.1f})" for m, s in zip(mean, scatter, strict=True)))
            print(f"| {noise:g} | {cutoff:g} | " + " | ".join(cells) + " |", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
