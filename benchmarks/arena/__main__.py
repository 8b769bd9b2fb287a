"""The arena: everybody is asked the same, and the truth is counted; answers are kept, so that it can be interrupted.

    python -m benchmarks.arena FOLDER                        every case and entry; half an hour on two idle cores
    python -m benchmarks.arena FOLDER --cases 40 --entries exoid_discover base_model
    python -m benchmarks.arena FOLDER --only equations/1j --entries exoid_discover
    python -m benchmarks.arena FOLDER --other 1100                   as many cases of other machines and motions
    python -m benchmarks.arena FOLDER --cases 40 --against OTHER     beside another program's answers, case by case
    python -m benchmarks.arena FOLDER --page docs/arena.md           the page, from what was answered so far

FOLDER holds truths.jsonl and answers.jsonl, a line each. A case is drawn from its name alone, so that every machine
draws the same; entries get the recordings and the angles of one more motion, nothing else (`task.py`).
"""

from __future__ import annotations

import argparse
import importlib
import json
import os
import sys
import time
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # must be set before NumPy is imported

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from benchmarks.arena.cases import draw, folder, names  # noqa: E402 - the repository must be on the path first
from benchmarks.arena.referee import page, right  # noqa: E402
from benchmarks.arena.task import Left  # noqa: E402
from benchmarks.baselines import read_lines  # noqa: E402
from exoid.ground.errors import ExoidError  # noqa: E402

MARK = "<!-- made by: python -m benchmarks.arena FOLDER --page docs/arena.md -->"


def answered(case: str, entries: Sequence[str], sealed_before: bool) -> tuple[dict[str, Any] | None, list[Any]]:
    """Return the truth of a case, unless it is sealed already, and what each entry says; (None, []) if it is left."""
    try:
        sealed = draw(case)
    except Left as why:
        print(f"{case}: left out, {why}", flush=True)
        return None, []
    truth = None
    if not sealed_before:
        truth = {"case": case, "hidden": list(sealed.hidden), "size": sealed.size, "told": sealed.told}
    said = []
    for entry in entries:
        began = time.process_time()
        line: dict[str, Any] = {"case": case, "entry": entry, "names": [], "verdict": "", "away": None}
        try:
            answer = importlib.import_module(f"benchmarks.arena.entries.{entry}").answer(sealed.task)
            line |= {"names": [list(one) for one in answer.names], "verdict": answer.verdict}
            line["away"] = sealed.away(answer.torque) if sealed.judged else None
        except Left as why:
            print(f"{case}: {entry} left out, {why}", flush=True)
            continue
        except ExoidError as refusal:
            line["verdict"] = f"refused: {refusal}"
        said.append(line | {"seconds": time.process_time() - began})
    return truth, said


def run(path: Path, wanted: Sequence[str], entries: Sequence[str], processes: int) -> None:
    """Ask what was not answered yet, and keep every answer at once."""
    truths, answers = path / "truths.jsonl", path / "answers.jsonl"
    sealed = {line["case"] for line in read_lines(truths)}
    known = {(line["case"], line["entry"]) for line in read_lines(answers)}
    asked = [(case, [e for e in entries if (case, e) not in known]) for case in wanted]
    asked = [(case, missing) for case, missing in asked if missing]
    with ProcessPoolExecutor(max_workers=processes) as pool:
        waiting = [pool.submit(answered, case, missing, case in sealed) for case, missing in asked]
        for one in waiting:
            truth, said = one.result()
            for file, lines in ((truths, [truth] if truth else []), (answers, said)):
                with file.open("a", encoding="utf-8") as stream:
                    stream.writelines(json.dumps(line) + "\n" for line in lines)
            for line in said:
                told = ", ".join(name[0] for name in line["names"]) or "nothing"
                print(f"{line['case']}: {line['entry']}: {told} ({line['seconds']:.1f} s)", flush=True)


def beside(path: Path, other: Path, wanted: Sequence[str], entry: str) -> None:
    """Say where two folders hold different answers of an entry, and which are right."""
    truths = {line["case"]: line for line in read_lines(path / "truths.jsonl")}
    first, second = (
        {line["case"]: line for line in read_lines(p / "answers.jsonl") if line["entry"] == entry}
        for p in (other, path)
    )
    both = [case for case in wanted if case in first and case in second and case in truths]
    counts = {(a, b): 0 for a in (True, False) for b in (True, False)}
    for case in both:
        was, now = right(first[case], truths[case]), right(second[case], truths[case])
        counts[was, now] += 1
        if was != now:
            print(f"{case}: {'lost' if was else 'won'}; {_said(first[case])} -> {_said(second[case])}")
    print(
        f"{len(both)} cases: right before {counts[True, True] + counts[True, False]}, now "
        f"{counts[True, True] + counts[False, True]}; won {counts[False, True]}, lost {counts[True, False]}; "
        f"CPU {sum(first[c]['seconds'] for c in both):.0f} s, now {sum(second[c]['seconds'] for c in both):.0f} s"
    )


def _said(line: dict[str, Any]) -> str:
    return f"{line['verdict'].partition(':')[0]} {[name[0] for name in line['names']]}"


def main(words: Sequence[str] | None = None) -> int:
    """Run what the command line asks for."""
    text, _, rest = (__doc__ or "").partition("\n\n")
    form = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(prog="benchmarks.arena", description=text, epilog=rest, formatter_class=form)
    everybody = folder("entries")
    parser.add_argument("folder", type=Path, help="where answers are kept, outside the repository")
    parser.add_argument("--entries", nargs="+", choices=everybody, default=everybody, metavar="NAME")
    parser.add_argument("--cases", type=int, default=None, help="the first so many cases, kinds by turns (all)")
    parser.add_argument("--only", nargs="+", default=[""], help="cases whose name contains one of these")
    parser.add_argument("--other", type=int, default=0, metavar="N", help="other machines: seeds moved by N (0)")
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--page", type=Path, default=None, help="write the page and ask nothing")
    parser.add_argument("--against", type=Path, default=None, help="compare with the answers kept there")
    given = parser.parse_args(words)
    if given.folder.resolve().is_relative_to(ROOT):
        parser.error(f"{given.folder} is inside the repository; results are not part of it")
    given.folder.mkdir(parents=True, exist_ok=True)
    wanted = [case for case in names(given.other) if any(part in case for part in given.only)][: given.cases]
    if given.page is None:
        run(given.folder, wanted, given.entries, given.processes)
    if given.against is not None:
        for entry in given.entries:
            beside(given.folder, given.against, wanted, entry)
    answers, truths = read_lines(given.folder / "answers.jsonl"), read_lines(given.folder / "truths.jsonl")
    titles = {e: importlib.import_module(f"benchmarks.arena.entries.{e}").TITLE for e in everybody}
    found = page(answers, {line["case"]: line for line in truths}, titles)
    if given.page is None:
        print(found)
    else:
        before = given.page.read_text(encoding="utf-8").partition(MARK)[0]
        given.page.write_text(f"{before}{MARK}\n{found}", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
