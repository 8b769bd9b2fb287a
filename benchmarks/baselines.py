"""What a plain regression would have said: the legs of the blind campaign, judged by textbook model selection.

    python benchmarks/baselines.py FOLDER                      one leg per variant, as apps/campaign/trials draws them
    python benchmarks/baselines.py FOLDER --kinds none --seeds 5

Both baselines get the very columns that `discover` weighs (same recordings, same filter, same catalogue, same trial
values of the shapes), and the same samples:

    bic     forward selection by the Bayesian information criterion of a regression with independent errors
    sindy   sequentially thresholded least squares of PySINDy (extra `peers`) on all columns at their best trial values,
            its threshold chosen by the error of the verification recording

They name effects, not look-alikes, so an answer counts as right when exactly the hidden effects are named, or, in the
second figure, when each is named or is structurally the same as one that is.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # must be set before NumPy is imported

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from exoid.apps.campaign.trials.cases import KINDS, Case, cases, simulated, subject  # noqa: E402
from exoid.diagnosis.evidence.columns import Columns  # noqa: E402
from exoid.diagnosis.evidence.fitted import FittedModel, fitted_model  # noqa: E402
from exoid.diagnosis.evidence.library import build_library  # noqa: E402
from exoid.diagnosis.grading import match  # noqa: E402
from exoid.optimisation.fitting.identify import identify  # noqa: E402
from exoid.optimisation.preparation.prepare import Prepared, prepare  # noqa: E402

MOST = 6
THRESHOLDS = np.geomspace(0.01, 0.5, 12)
"""Of a column's share in the torque, as standard deviations."""
SAME = {"com_offset_shank": "encoder_offset_knee", "drive_gain:hip": "drive_gain:knee"}
"""Exact look-alikes on every motion, either way round."""


def read_lines(path: Path) -> list[dict[str, Any]]:
    """Return the results so far; a line cut short by an interruption is left out."""
    out = []
    for text in path.read_text(encoding="utf-8").splitlines() if path.exists() else ():
        try:
            out.append(json.loads(text))
        except json.JSONDecodeError:
            continue
    return out


def stacked(prepared: Prepared, columns: list[Columns], count: int, node: int) -> np.ndarray:
    """Return the training samples (n, m) of one node, both joints, those a fit may use."""
    parts = [c.full(node)[p.used] for c, p in zip(columns[:count], prepared.all[:count], strict=True)]
    return np.concatenate(parts)


def bic(base: np.ndarray, y: np.ndarray, library: dict[str, list[np.ndarray]]) -> list[str]:
    """Return the names that forward selection adds; `library` holds each candidate's nodes (n, m)."""
    x, named = base, list[str]()
    best = _bic(x, y, 0)
    while len(named) < MOST:
        q, _ = np.linalg.qr(x)
        left = y - q @ (q.T @ y)
        tried = []
        for name, nodes in library.items():
            if name in named:
                continue
            for k, node in enumerate(nodes):
                new = node - q @ (q.T @ node)
                gain = left @ new @ np.linalg.lstsq(new, left, rcond=1e-9)[0]
                tried.append((float(gain) / node.shape[1] ** 0.5, name, k))
        _, name, k = max(tried)
        wider = np.hstack([x, library[name][k]])
        value = _bic(wider, y, len(named) + 1)
        if value >= best:
            break
        x, best = wider, value
        named.append(name)
    return named


def _bic(x: np.ndarray, y: np.ndarray, shapes: int) -> float:
    rest = y - x @ np.linalg.lstsq(x, y, rcond=None)[0]
    return len(y) * np.log(rest @ rest / len(y)) + (x.shape[1] + shapes) * np.log(len(y))


def sindy(base: np.ndarray, y: np.ndarray, best: dict[str, np.ndarray], unseen: tuple[Any, ...]) -> list[str]:
    """Return the names with a coefficient that survives PySINDy's thresholding; `best` has one node per candidate."""
    from pysindy import STLSQ

    names = [n for n, node in best.items() for _ in range(node.shape[1])]
    x = np.hstack([base, *best.values()])
    unseen_x, unseen_y = unseen
    scale, spread = np.maximum(x.std(axis=0), 1e-12), float(y.std())
    results = []
    for threshold in THRESHOLDS:
        model = STLSQ(threshold=threshold, alpha=1e-6)
        model.fit(x / scale, (y / spread)[:, None])
        coefficients = model.coef_.ravel() / scale * spread
        error = float(np.mean((unseen_y - unseen_x @ coefficients) ** 2))
        kept = {names[i - base.shape[1]] for i in np.flatnonzero(coefficients) if i >= base.shape[1]}
        results.append((error, sorted(kept)))
    least = min(error for error, _ in results)
    return next(kept for error, kept in reversed(results) if error <= 1.01 * least)


def run_case(case: Case) -> dict[str, Any]:
    """Return what the baselines name in one leg."""
    rng = np.random.default_rng(case.number)
    model, leg = subject(case, rng)
    hidden, runs = simulated(case, model, leg, rng)
    recordings = [run.recording for run in runs]
    prepared = prepare(model, recordings[:3], recordings[3:])
    fit = identify(model, prepared.train, optimisers=())
    now, count = fitted_model(fit, prepared), len(prepared.train)
    blocks = now.evidence(seed=0, draws=0).blocks
    base = np.concatenate([b.columns[b.use] for b in blocks[:count]])
    y = np.concatenate([p.torque[p.used] for p in prepared.train])
    columns = {}
    for candidate in build_library(model, prepared.all).candidates:
        found = [*build_columns(candidate, now)]
        columns[candidate.name] = found
    nodes = {n: [stacked(prepared, c, count, v) for v in range(c[0].values.shape[0])] for n, c in columns.items()}
    q, _ = np.linalg.qr(base)
    left = y - q @ (q.T @ y)
    chosen = {n: int(np.argmax([_gain(q, left, node) for node in each])) for n, each in nodes.items()}
    best = {n: nodes[n][v] for n, v in chosen.items()}
    last = prepared.verify[0]
    unseen_x = np.hstack(
        [blocks[count].columns[last.used], *(columns[n][count].full(v)[last.used] for n, v in chosen.items())]
    )
    named = {"bic": bic(base, y, nodes), "sindy": sindy(base, y, best, (unseen_x, last.torque[last.used]))}
    return {"case": case.name, "kind": case.kind, "hidden": [h.name for h in hidden], "named": named}


def build_columns(candidate: Any, fitted: FittedModel) -> list[Columns]:
    """Return the columns of a candidate on every recording."""
    from exoid.diagnosis.evidence.candidates import candidate_columns

    return [
        candidate_columns(candidate, rows, one, fitted)
        for rows, one in zip(candidate.nodes, fitted.prepared.all, strict=True)
    ]


def _gain(q: np.ndarray, left: np.ndarray, node: np.ndarray) -> float:
    new = node - q @ (q.T @ node)
    return float(left @ new @ np.linalg.lstsq(new, left, rcond=1e-9)[0])


def right(hidden: list[str], named: list[str], same: bool) -> bool:
    """Whether exactly what was hidden is named; with `same`, exact look-alikes count too."""
    twins = {**SAME, **{b: a for a, b in SAME.items()}} if same else {}
    answers = match(hidden, [(n, [twins[n]] if n in twins else []) for n in named])
    return None not in answers.values() and len(named) == len(hidden)


def main() -> int:
    text, _, rest = (__doc__ or "").partition("\n\n")
    parser = argparse.ArgumentParser(
        description=text, epilog=rest, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=Path, help="where baselines.jsonl is kept, outside the repository")
    parser.add_argument("--kinds", nargs="+", choices=KINDS, default=["single", "small", "pair", "none"])
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--only", default="")
    given = parser.parse_args()
    if given.folder.resolve().is_relative_to(ROOT):
        parser.error(f"{given.folder} is inside the repository; results are not part of it")
    given.folder.mkdir(parents=True, exist_ok=True)
    path = given.folder / "baselines.jsonl"
    known = {line["case"] for line in read_lines(path)}
    wanted = [c for c in cases(given.kinds, given.seeds, given.first) if given.only in c.name]
    for case in wanted:
        if case.name in known:
            continue
        began = time.perf_counter()
        line = run_case(case)
        with path.open("a", encoding="utf-8") as stream:
            stream.write(json.dumps(line) + "\n")
        print(f"{case.name}: {line['named']} ({time.perf_counter() - began:.1f} s)", flush=True)
    names = {c.name for c in wanted}
    lines = [line for line in read_lines(path) if line["case"] in names]
    for kind in given.kinds:
        some = [line for line in lines if line["kind"] == kind]
        for method in ("bic", "sindy"):
            plain, fair = (
                sum(right(line["hidden"], line["named"][method], same) for line in some) for same in (False, True)
            )
            count = np.mean([len(line["named"][method]) for line in some]) if some else float("nan")
            print(f"{kind:<7} {method:<6} right {plain}/{len(some)} ({fair} with exact look-alikes), named {count:.1f}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
