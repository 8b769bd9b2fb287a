"""How often short recordings of a leg with nothing hidden raise an alarm, by length.

    python benchmarks/short_recordings.py                        20 legs of the bench at every length
    python benchmarks/short_recordings.py --legs 5 --seconds 8 12

Two recordings of each length are fitted and a third is kept aside; the usual instruments, 100 Hz. An alarm is an effect
that is accepted, or any verdict but adequate. The interval is that of Wilson (1927), 95 %.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from exoid.diagnosis.discovery import discover  # noqa: E402 - the repository must be on the path first
from exoid.measurement.bench.leg import random_leg  # noqa: E402
from exoid.measurement.bench.simulation import Bench, simulate_runs  # noqa: E402
from exoid.symbolic.model import Model  # noqa: E402

SECONDS = (3.0, 6.0, 8.0, 12.0, 20.0)


def alarm(seed: int, seconds: float) -> str:
    """Return what `discover` says is wrong with a leg that has nothing hidden; "" where it says that nothing is."""
    leg = random_leg(np.random.default_rng([seed, 77]))
    runs = simulate_runs(3, None, leg, seed=seed, bench=Bench(duration=seconds))
    recordings = [run.recording for run in runs]
    found = discover(Model.standard(thigh_length=leg.thigh_length), recordings[:2], recordings[2:])
    named = ", ".join(one.name for one in found.accepted)
    return named or ("" if found.verdict == "adequate" else found.verdict)


def wilson(count: int, of: int) -> tuple[float, float]:
    """Return the 95 % interval of a share."""
    z, p = 1.96, count / of
    middle, half = p + z * z / (2 * of), z * np.sqrt(p * (1 - p) / of + z * z / (4 * of * of))
    return (middle - half) / (1 + z * z / of), (middle + half) / (1 + z * z / of)


def main(arguments: Sequence[str] | None = None) -> int:
    text, _, rest = (__doc__ or "").partition("\n\n")
    form = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=text, epilog=rest, formatter_class=form)
    parser.add_argument("--legs", type=int, default=20)
    parser.add_argument("--seconds", type=float, nargs="+", default=SECONDS)
    parser.add_argument("--first", type=int, default=0, help="seed of the first leg")
    given = parser.parse_args(arguments)
    for seconds in given.seconds:
        said = [alarm(given.first + k, seconds) for k in range(given.legs)]
        wrong = [f"{given.first + k}: {text}" for k, text in enumerate(said) if text]
        low, high = wilson(len(wrong), given.legs)
        text = f"2 x {seconds:g} s: {len(wrong)} of {given.legs} ({100 * max(low, 0):.0f} to {100 * high:.0f} %)"
        print("; ".join([text, *wrong]), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
