"""Who finds the shape parameters: a grid with local searches, or a population? Same evaluations, same refinement.

    python benchmarks/shape_search.py [--seeds 5] [--only ripple]

The loss over shape parameters (velocity of a Stribeck peak, order of a ripple, a delay) is not convex; at every point
the linear parameters are solved exactly. Each case is a leg of the bench with these effects in it. Every method gets
400 evaluations, then the same local search from its three best points. *Found* means within 1e-6 (relative) of the best
loss that any method reached in that case; nothing is known about an optimum beyond that.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections.abc import Sequence
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # must be set before NumPy is imported

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from exoid.ground.errors import ExpressionError  # noqa: E402
from exoid.measurement.bench.hidden import parse_hidden  # noqa: E402
from exoid.measurement.bench.leg import standard_leg  # noqa: E402
from exoid.measurement.bench.simulation import Bench, simulate_runs  # noqa: E402 - the repository must be on the path first
from exoid.optimisation.fitting.assemble import Assembly, settle  # noqa: E402
from exoid.optimisation.fitting.shapes import SAME, STARTS, ShapeMethod, search_shape  # noqa: E402
from exoid.optimisation.linear.loss import huber  # noqa: E402
from exoid.optimisation.linear.problem import LinearData  # noqa: E402
from exoid.optimisation.linear.solve import delta_rule, solve_huber, solve_sse  # noqa: E402
from exoid.optimisation.optimisers import optimisers  # noqa: E402
from exoid.optimisation.preparation.prepare import prepare  # noqa: E402
from exoid.symbolic.model import Model  # noqa: E402
from exoid.symbolic.motion import Float  # noqa: E402

CASES: tuple[tuple[str, ...], ...] = (
    ("stribeck:knee=c=3,v_s=0.15",),
    ("torque_ripple:knee=a=0.8,b=0.3,n=24",),
    ("hysteresis:knee=c=1.5,sigma=60",),
    ("friction_drift:hip=c=1.5,T=12",),
    ("stribeck:knee=c=3,v_s=0.15", "torque_ripple:hip=a=0.8,b=0.3,n=31"),
    ("torque_ripple:hip=a=0.8,b=0.3,n=31", "torque_ripple:knee=a=0.8,b=0.3,n=24"),
    ("stribeck:hip=c=3,v_s=0.2", "stribeck:knee=c=3,v_s=0.12", "torque_ripple:knee=a=0.8,b=0.3,n=24"),
)
METHODS = ("multistart", "nfo", "de", "pso", "cma_es")


def run_case(case: Sequence[str], seed: int) -> dict[str, tuple[float, int, float]]:
    """Return (loss, evaluations, seconds) of every method."""
    hidden = [parse_hidden(text) for text in case]
    run = simulate_runs(1, None, standard_leg(), effects=hidden, seed=seed, bench=Bench(duration=20.0))[0]
    model = Model.standard()
    for one in hidden:
        model = model.with_effect(one.name)
    train = prepare(model, [run.recording]).train
    assembly = Assembly(model, train)
    delta = np.array([0.6, 0.6])
    spent = 0

    def solve(data: LinearData) -> Float:
        return solve_huber(data, delta, solve_sse(data))

    def loss(shape: Float) -> float:
        nonlocal spent
        spent += 1
        try:
            found = settle(assembly, shape, solve, None)
        except ExpressionError:
            return float("inf")
        return huber(found.data.residual(found.linear), delta)

    start = settle(assembly, model.typical_shape, solve_sse, None)
    delta = delta_rule(start.data.residual(start.linear), use=start.data.use)
    out = {}
    for name in METHODS:
        spent, began = 0, time.process_time()
        kind = None if name == "multistart" else optimisers()[name]()
        found = search_shape(loss, [s.shape for s in model.shapes], None, ShapeMethod(kind, STARTS, None, 0.05, seed))
        out[name] = found.value, spent, time.process_time() - began
    return out


def main() -> int:
    text, _, rest = (__doc__ or "").partition("\n\n")
    form = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=text, epilog=rest, formatter_class=form)
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--only", default="", help="only cases that contain this")
    given = parser.parse_args()
    head = " | ".join(METHODS)
    print(f"| effects in the leg and in the model | shapes | {head} |\n|---|---|{'---|' * len(METHODS)}")
    seconds, evaluations = dict.fromkeys(METHODS, 0.0), dict.fromkeys(METHODS, 0)
    total = dict.fromkeys(METHODS, 0)
    count = 0
    for case in (c for c in CASES if given.only in " ".join(c)):
        found = dict.fromkeys(METHODS, 0)
        for seed in range(given.seeds):
            results = run_case(case, seed)
            best = min(value for value, _, _ in results.values())
            count += 1
            for name, (value, spent, took) in results.items():
                found[name] += value <= best * (1.0 + SAME)
                seconds[name] += took
                evaluations[name] += spent
        for name in METHODS:
            total[name] += found[name]
        names = [parse_hidden(text).name for text in case]
        shapes = sum(len(Model.standard().with_effect(name).shapes) for name in names)
        cells = " | ".join(f"{found[name]} of {given.seeds}" for name in METHODS)
        print(f"| {', '.join(names)} | {shapes} | {cells} |", flush=True)
    print(f"| all | | {' | '.join(f'{total[n]} of {count}' for n in METHODS)} |")
    print(f"| evaluations, mean | | {' | '.join(f'{evaluations[n] / max(count, 1):.0f}' for n in METHODS)} |")
    fastest = min(seconds.values()) or 1.0
    print(f"| time, relative | | {' | '.join(f'{seconds[n] / fastest:.2f}' for n in METHODS)} |")
    return 0


if __name__ == "__main__":
    sys.exit(main())
