"""How often a placebo is called significant at nominal 5 %, on recordings one has.

    python benchmarks/placebo_rate.py run_0.csv run_1.csv run_2.csv --verify run_3.csv

Every entry of the catalogue is shifted in time by a random amount, another one in every recording, so that it can have
nothing to do with them; then it goes through what every suspect goes through: the search over its shapes, held-out
fits, its own placebos. Of these p-values 5 % should be at most 0.05, also where residuals resemble themselves from
sample to sample, as those of real machines do. (The usual formula for independent samples calls most of them real.)
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # must be set before NumPy is imported

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from exoid.diagnosis.evidence.columns import Columns  # noqa: E402
from exoid.diagnosis.evidence.fitted import fitted_model  # noqa: E402
from exoid.diagnosis.evidence.library import build_library  # noqa: E402 - the repository must be on the path first
from exoid.diagnosis.evidence.ranking import placebo  # noqa: E402
from exoid.diagnosis.evidence.score import weigh  # noqa: E402
from exoid.measurement.reading.read import read_recording  # noqa: E402
from exoid.measurement.recording import Recording  # noqa: E402
from exoid.optimisation.fitting.identify import identify  # noqa: E402
from exoid.optimisation.preparation.prepare import prepare  # noqa: E402
from exoid.symbolic.model import Model  # noqa: E402
from exoid.symbolic.motion import Float  # noqa: E402

NOMINAL = 0.05
OWN_DRAWS = 199
"""Placebos of each shifted entry."""


def p_values(model: Model, train: Sequence[Recording], verify: Sequence[Recording], repeats: int, seed: int) -> Float:
    """Return the p-values of every catalogue entry, shifted at random `repeats` times; those without columns drop out.

    Where an entry is contained in the model on this motion it has no p-value.
    """
    prepared = prepare(model, train, verify)
    now = fitted_model(identify(model, prepared.train, optimisers=()), prepared)
    library = build_library(model, prepared.all)
    evidence = now.evidence(seed=seed, draws=OWN_DRAWS)
    shifts = now.evidence(seed=seed + 1, draws=repeats * len(library.candidates)).shifts
    out = []
    for number in range(repeats * len(library.candidates)):
        candidate = library.candidates[number % len(library.candidates)]
        columns = library.columns(candidate, now)
        moved = [
            Columns(c.joints, np.roll(c.values, -int(own[number]), axis=2))
            for c, own in zip(columns, shifts, strict=True)
        ]
        score = weigh(evidence, candidate, moved)
        if score.coefficients.any():
            out.append(placebo(evidence, score, moved).p_value)
    return np.array(out, dtype=float)


def main() -> int:
    text, _, rest = (__doc__ or "").partition("\n\n")
    form = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=text, epilog=rest, formatter_class=form)
    parser.add_argument("recordings", nargs="+")
    parser.add_argument("--verify", nargs="*", default=[])
    parser.add_argument("--thigh", type=float, default=0.40, help="length of the first link in m")
    parser.add_argument("--repeats", type=int, default=5, help="shifts of every entry")
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    train, verify = ([read_recording(path) for path in paths] for paths in (given.recordings, given.verify))
    found = p_values(Model.standard(thigh_length=given.thigh), train, verify, given.repeats, given.seed)
    rate = np.mean(found <= NOMINAL)
    print(f"{100 * rate:.1f} % of {found.size} placebos are called significant at {100 * NOMINAL:g} %")
    return 0


if __name__ == "__main__":
    sys.exit(main())
