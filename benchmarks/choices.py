"""Rules that could choose how many effects stand, on the same paths: which of them are right, and which add too many.

    python benchmarks/choices.py                        32 legs, about half an hour
    python benchmarks/choices.py --kinds none --cases 4

The legs are those of the blind trials (`exoid campaign`). From the model as given the best suspect is added again and
again, with nothing to stop it; each rule then chooses how many of the path stand. Losses are Huber's in blocks of time,
each recording by a fit to the others. `discover` itself is asked beside them, whose answer may be another path.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # must be set before NumPy is imported

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from exoid.apps.campaign.trials.cases import Case, cases, simulated, subject
from exoid.diagnosis import discover
from exoid.diagnosis.evidence.fitted import fitted_model
from exoid.diagnosis.evidence.library import build_library
from exoid.diagnosis.grading import match
from exoid.diagnosis.search.context import SearchContext
from exoid.diagnosis.search.state import Extension
from exoid.optimisation.fitting.identify import identify
from exoid.optimisation.preparation.prepare import Prepared, prepare

STEPS = 4
"""Effects of a path: two more than are hidden at most."""


@dataclass(frozen=True)
class Steps:
    """A path: `losses` (M, B) on motion the models were not fitted to, their numbers of parameters `counts` (M,), their
    mean squared residuals `squares` (M, J) N²·m², and the `samples` (J,) of each joint, as they are and independent.
    """

    losses: np.ndarray
    counts: np.ndarray
    squares: np.ndarray
    samples: np.ndarray
    independent: np.ndarray


def within(errors: float) -> Callable[[Steps], int]:
    """Return the rule that takes the fewest effects within so many standard errors of the best."""

    def choice(steps: Steps) -> int:
        more = steps.losses - steps.losses[np.argmin(steps.losses.sum(axis=1))]
        spread = np.sqrt(np.sum((more - more.mean(axis=1, keepdims=True)) ** 2, axis=1))
        return int(np.flatnonzero(more.sum(axis=1) <= errors * spread)[0])

    return choice


def schwarz(steps: Steps, samples: np.ndarray) -> int:
    """Return the choice of Schwarz's criterion (BIC) for so many `samples` (J,)."""
    fit = np.log(steps.squares) @ samples
    return int(np.argmin(fit + steps.counts * np.log(samples.sum())))


RULES: dict[str, Callable[[Steps], int]] = {
    "best": within(0.0),
    "one standard error": within(1.0),
    "two standard errors": within(2.0),
    "BIC": lambda steps: schwarz(steps, steps.samples),
    "BIC, effective samples": lambda steps: schwarz(steps, steps.independent),
}


def path_of(context: SearchContext, start: Extension) -> list[Extension]:
    """Return the models of a path, the given one first: each has the suspect more that explains most beside it."""
    path = [start]
    for step in range(STEPS):
        there = context.key(path[-1])
        ranked = (s for s in context.rank(path[-1], step + 1)[1] if s.share > 0.0 and not s.caution)
        best = next((score for score in ranked if score.name not in there), None)
        if best is None:
            break
        path.append(context.with_term(path[-1], best))
    return path


def unseen(one: Extension, prepared: Prepared, scale: np.ndarray) -> np.ndarray:
    """Return the losses (B,) of blocks of every recording, by a fit to the others."""
    out, own = [], any(entry.shape.per_recording for entry in one.fitted.model.shapes)
    for k, item in enumerate(prepared.all):
        others = tuple(other for other in prepared.all if other is not item)
        start = np.delete(one.fitted.shapes, k, axis=0) if own else one.fitted.fit.start
        fit = identify(one.fitted.model, others, optimisers=(), start=start)
        again = fitted_model(fit, replace(prepared, train=others, verify=(item,)))
        out.append(again.recording_losses(scale)[-1])
    return np.concatenate(out)


def steps_of(path: Sequence[Extension], prepared: Prepared) -> Steps:
    """Return the numbers by which the rules choose; samples are as alike as in what the last model leaves."""
    use = np.concatenate([item.used for item in prepared.all], axis=1)
    left = [np.concatenate(one.fitted.residuals, axis=1) for one in path]
    squares = np.array([[np.mean(np.square(row[seen])) for row, seen in zip(each, use, strict=True)] for each in left])
    last = [row[seen] for row, seen in zip(left[-1], use, strict=True)]
    alike = np.array([np.corrcoef(row[1:], row[:-1])[0, 1] for row in last])
    counts = np.array([one.fitted.linear.size + one.fitted.shape.size for one in path])
    samples = use.sum(axis=1).astype(float)
    losses = np.array([unseen(one, prepared, path[-1].fitted.scale) for one in path])
    return Steps(losses, counts, squares, samples, samples * (1.0 - alike) / (1.0 + alike))


def judged(case: Case) -> tuple[dict[str, int], bool, int]:
    """Return the number of effects by each rule, whether `discover` names the hidden ones, and how many it names."""
    rng = np.random.default_rng(case.number)
    model, leg = subject(case, rng)
    hidden, runs = simulated(case, model, leg, rng)
    recordings = [run.recording for run in runs]
    found = discover(model, recordings[:3], recordings[3:])
    prepared = prepare(model, recordings[:3], recordings[3:])
    context = SearchContext(prepared, build_library(model, prepared.all))
    steps = steps_of(path_of(context, context.fit(model)), prepared)
    named = match([one.name for one in hidden], [(one.name, one.look_alikes) for one in found.accepted])
    right = len(found.accepted) == len(hidden) and all(by is not None for by in named.values())
    return {name: rule(steps) for name, rule in RULES.items()}, right, len(found.accepted)


def main() -> None:
    """Judge the legs one by one, and count."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kinds", nargs="+", default=["single", "pair", "none"])
    parser.add_argument("--cases", type=int, default=32)
    parser.add_argument("--first", type=int, default=900, help="first seed")
    asked = parser.parse_args()
    every = cases(asked.kinds, 1, first=asked.first)
    chosen = [every[k] for k in np.random.default_rng(asked.first).permutation(len(every))[: asked.cases]]
    right: Counter[str] = Counter()
    more: Counter[str] = Counter()
    for case in chosen:
        counts, named, count = judged(case)
        for name, stand in counts.items():
            right[name] += stand == len(case.variants)
            more[name] += stand > len(case.variants)
        right["discover"] += named
        more["discover"] += count > len(case.variants)
        print(f"{case.name}: {', '.join(f'{name} {n}' for name, n in counts.items())}; discover {count}", flush=True)
    print(f"\n| rule | right of {len(chosen)} | too many |\n|---|---|---|")
    for name in ("discover", *RULES):
        print(f"| {name} | {right[name]} | {more[name]} |")


if __name__ == "__main__":
    main()
