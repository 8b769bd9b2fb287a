"""Reproduce the paper on the virtual bench and write docs/paper.md with its figures: `python benchmarks/paper.py`.

`paper_page.md` is the page with {names} in the place of numbers; `paper_experiments.py` measures them. About a minute
on one core. The same seeds give the same numbers on the same machine.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

import numpy as np  # noqa: E402 - the repository must be on the path first
import paper_experiments as paper  # noqa: E402
import paper_figures as figures  # noqa: E402

from ground.figures import to_png  # noqa: E402
from measurement.trajectories.extremes import shortest_period  # noqa: E402
from measurement.trajectories.trajectory import paper_trajectory  # noqa: E402
from symbolic.model import TABLE_1  # noqa: E402

DOCS = ROOT / "docs"
SEARCHES = {
    "∞ outside the limits, coefficients within ±1 rad": (1.0, False),
    "∞ outside the limits, within ±0.2 rad": (0.2, False),
    "∞ outside the limits, within ±0.05 rad": (0.05, False),
    "rescaled into the limits, within ±1 rad": (1.0, True),
}
SEARCH_SEEDS = 5
ROUGH = "as large as the paper's δ, one way"


def main() -> None:
    """Measure, draw and write."""
    fits = paper.fit_all()
    curves = paper.converge(fits[ROUGH][0])
    searches = {name: paper.search_motion(*how, SEARCH_SEEDS) for name, how in SEARCHES.items()}
    designs = paper.designs(SEARCH_SEEDS)
    contest = paper.rivals_of_motion(SEARCH_SEEDS)
    published = paper.condition(paper_trajectory())
    drawn = {
        "trajectory": paper_trajectory().plot(),
        "search": figures.search(searches, published, designs[0].condition),
        "fit": figures.fit(fits[ROUGH][0]), "ratio": figures.ratios(fits, paper.PAPER_RATIO),
        "convergence": figures.convergence(curves), "rivals": contest.plot(),
    }  # fmt: skip
    for name, figure in drawn.items():
        (DOCS / f"paper_{name}.png").write_bytes(to_png(figure, dpi=90))
    page = (Path(__file__).parent / "paper_page.md").read_text(encoding="utf-8")
    for name, text in {
        **numbers(fits, curves, searches, designs, published), "rivals": rival_table(contest)
    }.items():  # fmt: skip
        page = page.replace("{" + name + "}", text)
    (DOCS / "paper.md").write_text(page, encoding="utf-8")
    sys.stdout.write("docs/paper.md\n")


def numbers(fits, curves, searches, designs, published) -> dict[str, str]:
    """Return every number and table of the page as text."""
    wrong = paper.misprint(paper.record(0, paper_trajectory()), paper.record(100, None))
    ratio = {name: np.median([one.ratio("true") for one in several]) for name, several in fits.items()}
    bench = next(iter(fits))
    return {
        "limits": limits(), "periods": periods(), "published": f"{published:.1f}",
        "searches": search_table(searches, designs),
        "best": f"{designs[0].condition:.1f}",
        "parameters": parameters(fits), "errors": errors(fits), "curves": curve_table(curves),
        "ratio_usual": f"{ratio[bench]:.2f}", "ratio_rough": f"{ratio[ROUGH]:.2f}",
        "square_rough": f"{ratio[ROUGH] ** 2:.2f}",
        "derived_hip": f"{wrong['derived'][0]:.2f}", "printed_hip": f"{wrong['printed'][0]:.2f}",
        "derived_knee": f"{wrong['derived'][1]:.2f}", "printed_knee": f"{wrong['printed'][1]:.2f}",
        "seeds": str(paper.SEEDS), "search_seeds": str(SEARCH_SEEDS),
        "radian": radian(), "shortest": f"{np.ceil(100 * shortest_period(paper_trajectory(), TABLE_1)) / 100:.2f}",
        "gap": f"{fits[ROUGH][0].proof.gap:.0e}",
    }  # fmt: skip


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a Markdown table."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def limits() -> str:
    """Return Table 1 beside what the published motion uses of it."""
    motion = paper_trajectory().at(np.linspace(0.0, 10.0, 2000))
    rows = []
    for j, (joint, limit) in enumerate(TABLE_1.items()):
        q, dq, ddq = motion.q[:, j], motion.dq[:, j], motion.ddq[:, j]
        low, high = limit.angle
        for name, allowed, used in (
            ("angle [rad]", f"{low:g} to {high:g}", f"{q.min():.3f} to {q.max():.3f}"),
            ("velocity [rad/s]", f"±{limit.velocity:g}", f"{np.abs(dq).max():.2f}"),
            ("acceleration [rad/s²]", f"±{limit.acceleration:g}", f"{np.abs(ddq).max():.2f}"),
        ):
            rows.append((joint, name, allowed, used))
    return table(("joint", "quantity", "Table 1", "published motion, degrees, 10 s"), rows)


def periods() -> str:
    """Return the condition number of the published motion for several periods."""
    rows = [(f"{p:g} s", f"{c:.1f}", "yes" if inside else "**no**") for p, c, inside in paper.published_motion()]
    return table(("period", "cond(Ȳ)", "inside Table 1"), rows)


def radian() -> str:
    """Return how far the published coefficients swing when they are read as radians."""
    degrees = paper_trajectory()
    swing = degrees.at(np.linspace(0.0, 10.0, 2000)).q - degrees.offset
    return f"{np.rad2deg(np.abs(swing)).max():.0f}"


def search_table(searches, designs) -> str:
    """Return how each search of the trajectory ended."""
    rows = []
    for name, one in searches.items():
        last = one.history[:, -1]
        found = last[np.isfinite(last)]
        ends = f"{np.median(found):.1f} ({found.min():.1f} to {found.max():.1f})" if found.size else "∞ in every run"
        rows.append((name, f"{found.size} of {last.size}", ends))
    own = [next(c.value for c in one.candidates if c.name == "CMA-ES, refined") for one in designs]
    ends = f"{np.median(own):.1f} ({min(own):.1f} to {max(own):.1f})"
    rows.append(("`exoid design`: eight runs of CMA-ES, each refined", f"{len(own)} of {len(own)}", ends))
    ipopt = min(c.value for c in designs[0].candidates if c.name.startswith("IPOPT"))
    rows.append(("IPOPT from three starts", "", f"{ipopt:.1f}"))
    return table(("NFO, 20 × 400 evaluations", "runs that found a motion inside", "cond(Ȳ), median (range)"), rows)


def rival_table(contest) -> str:
    """Return how near every optimiser came to the best motion known, rescaled and with the penalty."""
    best = contest.contest.best
    rows = []
    for name, middle, low, high, hits, runs, *_ in contest.rows():
        values = [f"{best * (1.0 + gap):.1f}" if np.isfinite(gap) else "∞" for gap in (middle, low, high)]
        how = "∞ outside, ±0.2 rad" if name.endswith("_penalty") else "rescaled, ±1 rad"
        who = name.removesuffix("_penalty").upper().replace("_", "-")
        rows.append((who, how, values[0], f"{values[1]} to {values[2]}", f"{hits} of {runs}"))
    head = ("20 × 400 evaluations", "limits", "cond(Ȳ), median", "quartiles", "runs within 1 % of the best known")
    return table(head, rows)


def parameters(fits) -> str:
    """Return truth, the paper's two fits and the medians found here."""
    rows = []
    rough, usual = fits[ROUGH], next(iter(fits.values()))
    own = np.median(paper.own_way(), axis=0)
    for k, parameter in enumerate(paper.LEG.parameters):
        cells = [f"{paper.PAPER_HUBER[k]:.2f}", f"{paper.PAPER_SSE[k]:.2f}"]
        for several, which in ((usual, "sse"), (usual, "huber"), (rough, "sse"), (rough, "huber")):
            cells.append(f"{np.median([getattr(one, which)[k] for one in several]):.2f}")
        rows.append((f"Φ{k + 1} [{parameter.unit}]", *cells, f"{own[k]:.2f}"))
    head = ("", "paper's Huber = the truth here", "paper's SSE", "SSE, bench", "Huber, bench", "SSE, one way",
            "Huber, one way", "`exoid identify`, bench")  # fmt: skip
    return table(head, rows)


def errors(fits) -> str:
    """Return δ and the errors on unseen motion for every kind of sensor error."""
    rows = []
    for name, several in fits.items():
        delta = np.median([one.delta for one in several], axis=0)
        cells = [f"{delta[0]:.0f} / {delta[1]:.0f}"]
        for against in ("true", "measured"):
            for which in ("sse", "huber"):
                cells.append(f"{np.median([one.error(getattr(one, which), against) for one in several]):.1f}")
            ratio = [one.ratio(against) for one in several]
            cells.append(f"**{np.median(ratio):.2f}** ({min(ratio):.2f} to {max(ratio):.2f})")
        rows.append((name, *cells))
    head = ("errors of the torque sensor", "δ hip / knee [N·m]", "SSE, true torque [N·m]", "Huber", "ratio",
            "SSE, measured torque [N·m]", "Huber", "ratio")  # fmt: skip
    return table(head, rows)


def curve_table(curves) -> str:
    """Return the distance to the certified optimum at the end of every run, and how soon it was within 1e-9."""
    rows = []
    for name, gaps in curves.gaps.items():
        last = gaps[:, -1]
        proven = gaps <= 1e-9
        soon = [int(curves.counts[name][np.argmax(one)]) for one in proven if one.any()]
        after = f"{np.median(soon):.0f}" if len(soon) == len(gaps) else "–"
        reached = f"{len(soon)} of {len(gaps)}"
        rows.append((name, f"{np.median(last):.0e}", f"{last.min():.0e} to {last.max():.0e}", reached, after))
    r = curves.reference
    rows.append((f"IPOPT ({r.iterations} iterations)", f"{max(curves.reference_gap, 1e-16):.0e}", "", "1 of 1", ""))
    head = ("method, 40 × 400 evaluations", "relative distance, median", "range", "runs within 1e-9", "after")
    return table(head, rows)


if __name__ == "__main__":
    main()
