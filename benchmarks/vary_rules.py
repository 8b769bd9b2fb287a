"""Which thresholds of the diagnosis decide: each one halved and doubled, and which answers change by it.

    python benchmarks/vary_rules.py                                        every threshold, a night
    python benchmarks/vary_rules.py --only nearest clear --kinds small none --cases 4
    python benchmarks/vary_rules.py --tests tests/measurement/test_audit.py   which of these tests fail, for every one

The legs are those of the blind trials (`exoid campaign`), so the truth is known: a line says for how many legs the
answer (verdict and accepted effects) changed, and how many were right before and after. A threshold that changes
nothing on any leg prevents nothing here; one that makes answers wrong on either side stands where it should. What
decides in audit, preparation, fits and watching is varied by --tests alone: legs of the bench are no bad recordings.
"""

from __future__ import annotations

import argparse
import io
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout
from dataclasses import replace
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # must be set before NumPy is imported

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from exoid.apps.campaign.trials.cases import KINDS, Case, cases, simulated, subject  # noqa: E402
from exoid.diagnosis.discovery import answer_of  # noqa: E402 - the repository must be on the path first
from exoid.diagnosis.grading import match  # noqa: E402
from exoid.diagnosis.question import Question  # noqa: E402
from exoid.diagnosis.results import Diagnosis  # noqa: E402
from exoid.diagnosis.rules import RULES, Rules  # noqa: E402
from exoid.diagnosis.settings import DiscoverySettings  # noqa: E402
from exoid.diagnosis.thresholds import every_threshold  # noqa: E402
from exoid.ground.suggest import did_you_mean  # noqa: E402
from exoid.ground.thresholds import Rule  # noqa: E402
from exoid.measurement.recording import Recording  # noqa: E402
from exoid.optimisation.preparation.prepare import Prepared, prepare  # noqa: E402

FACTORS = (0.5, 2.0)
PREPARING = ("whole_seconds", "stretch_seconds", "searched_seconds")
"""Thresholds that cut recordings before they are prepared; those of the trials are too short for them."""


class Trial:
    """One simulated leg, prepared once, and the answer under the thresholds in use."""

    def __init__(self, case: Case) -> None:
        rng = np.random.default_rng(case.number)
        self.model, leg = subject(case, rng)
        hidden, runs = simulated(case, self.model, leg, rng)
        self.name = case.name
        self.hidden = [one.name for one in hidden]
        self.recordings: list[Recording] = [run.recording for run in runs]
        self.prepared: Prepared = prepare(self.model, self.recordings[:3], self.recordings[3:])
        self.usual = self.answer(RULES)

    def answer(self, rules: Rules) -> tuple[str, tuple[str, ...], bool]:
        """Return the verdict, the accepted effects, and whether they are what is hidden."""
        question = Question(self.model, DiscoverySettings(rules=rules))
        found = answer_of(question, self.recordings[:3], self.recordings[3:], prepared=self.prepared)
        return found.verdict, tuple(sorted(one.name for one in found.accepted)), self._right(found)

    def _right(self, found: Diagnosis) -> bool:
        accepted = [(one.name, (*one.look_alikes, *one.never_separable)) for one in found.accepted]
        explained = match(self.hidden, accepted)
        return len(accepted) == len(self.hidden) and None not in explained.values()


def varied(only: list[str]) -> Iterator[tuple[str, Rules]]:
    """Yield the thresholds of the search at every factor."""
    for rule in RULES.table():
        if rule.name in PREPARING or (only and rule.name not in only):
            continue
        for value in halved_and_doubled(rule.value):
            yield f"{rule.name} = {value:g}", replace(RULES, **{rule.name: value})


@contextmanager
def in_force(rule: Rule, value: float) -> Iterator[None]:
    """Let a threshold have another value everywhere, as if it had been written so."""
    if not rule.module:
        object.__setattr__(RULES, rule.name, value)  # frozen for everybody else
        try:
            yield
        finally:
            object.__setattr__(RULES, rule.name, rule.value)
        return
    name = rule.name.rpartition(".")[2]
    old = getattr(sys.modules[rule.module], name)
    places = [one for one in list(sys.modules.values()) if getattr(one, "__dict__", {}).get(name) is old]
    for module in places:
        setattr(module, name, value)
    try:
        yield
    finally:
        for module in places:
            setattr(module, name, old)


class Failed:
    """What a run of pytest says of tests that fail."""

    def __init__(self) -> None:
        self.names: list[str] = []

    def pytest_runtest_logreport(self, report: Any) -> None:
        if report.failed:
            self.names.append(report.nodeid)


def by_tests(files: list[str], only: list[str], whole: bool) -> None:
    """Say for every threshold which tests fail where it is halved or doubled; the first one unless `whole`."""
    import pytest

    options = [*files, "-q", "--no-header", "--no-summary", "-p", "no:cacheprovider", *(() if whole else ("-x",))]
    for rule in every_threshold():
        if only and rule.name not in only:
            continue
        lines = []
        for value in halved_and_doubled(rule.value):
            failed = Failed()
            with in_force(rule, value), redirect_stdout(io.StringIO()):
                pytest.main(options, plugins=[failed])
            lines.append(f"{value:g}: {', '.join(failed.names) or 'none'}")
        print(f"{rule.name:26s} {'   '.join(lines)}", flush=True)


def halved_and_doubled(value: float) -> Iterator[float]:
    """Yield other values of a threshold; whole numbers stay whole and change by one at least."""
    for factor in FACTORS:
        other = value * factor
        if isinstance(value, int):
            other = max(1, int(other)) if factor < 1.0 else int(other)
        if other != value:
            yield other


def main(words: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", nargs="+", default=[], metavar="NAME", help="thresholds to vary (all)")
    parser.add_argument("--kinds", nargs="+", default=["small", "pair", "none", "outside"], choices=KINDS)
    parser.add_argument("--cases", type=int, default=8, help="legs of each kind (8)")
    parser.add_argument("--first", type=int, default=0, help="seed of the first leg (0)")
    parser.add_argument("--tests", nargs="+", default=[], metavar="FILE", help="run these tests instead of legs")
    parser.add_argument("--whole", action="store_true", help="with --tests: name all that fail, not the first")
    given = parser.parse_args(words)
    known = [rule.name for rule in every_threshold()]
    for name in given.only:
        if name not in known:
            parser.error(
                f"there is no threshold {name!r}; {did_you_mean(name, known) or 'docs/statistics.md has them'}"
            )
    if given.tests:
        by_tests(given.tests, given.only, given.whole)
        return 0
    trials = []
    for kind in given.kinds:
        trials += [Trial(case) for case in cases([kind], 1, given.first)[: given.cases]]
    for one in trials:
        verdict, accepted, right = one.usual
        print(
            f"{one.name}: {verdict}, {', '.join(accepted) or 'nothing accepted'}, {'right' if right else 'not right'}"
        )
    print(f"\nright as they are: {sum(one.usual[2] for one in trials)} of {len(trials)}", flush=True)
    for label, rules in varied(given.only):
        answers = [one.answer(rules) for one in trials]
        changed = [one.name for one, now in zip(trials, answers, strict=True) if now != one.usual]
        right = sum(now[2] for now in answers)
        print(f"{label:32s} right {right:3d}, changed {len(changed):3d}  {' '.join(changed[:4])}", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
