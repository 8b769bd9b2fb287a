"""This checkout against another one, in one run: `python benchmarks/against.py OTHER RUN.csv ... --verify RUN.csv`.

Every row is measured in processes of its own, each time the two checkouts in turn, and the smallest times of each
count, by the clock and of the processor; linear algebra has one thread, and what is compiled is compiled before. Ratios
by the clock mean something on a quiet machine only; nothing is asserted.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from exoid.symbolic.effect_catalogue import catalogue  # noqa: E402
from exoid.symbolic.joints import LEG  # noqa: E402
from exoid.symbolic.term import places_of  # noqa: E402

PREPARE = """
import json, os, sys, time
train, verify = json.loads(sys.argv[1])
def now():
    return time.perf_counter(), sum(os.times()[:4])
"""
READ = """
from exoid.measurement import read_recording
from exoid.symbolic import Model
train, verify = ([read_recording(path) for path in group] for group in (train, verify))
"""
ROWS = {
    "imports of compare": """
began = now()
import exoid.workbench.command
from exoid.diagnosis import compare
from exoid.measurement import read_recording
from exoid.symbolic import Model
""",
    "reading the files": """
from exoid.measurement import read_recording
began = now()
for path in (*train, *verify):
    read_recording(path)
""",
    "choosing the cut-off": READ + """
from exoid.optimisation import prepare
began = now()
prepare(Model.standard(), train, verify)
""",
    "compare": READ + """
from exoid.diagnosis import compare
began = now()
compare(Model.standard(), train, verify)
""",
    "add": READ + """
from exoid.diagnosis.extend import add
began = now()
add(Model.standard(), "stribeck:knee", train, verify)
""",
    "discover": READ + """
from exoid.diagnosis import discover
began = now()
found = discover(Model.standard(), train, verify)
""",
}
REFIT = READ + """
from exoid.optimisation import identify
from exoid.optimisation import prepare
prepared = prepare(Model.standard(), train, verify, cutoff=5.0)
model = Model.standard().with_effect({effect!r}, {joint!r})
began = now()
identify(model, prepared.train, optimisers=())
"""
def seconds(checkout: Path, code: str, files: str) -> tuple[float, ...]:
    """Return the time in s, by the clock and of the processor, that `code` takes from its own beginning on."""
    # Byte code is kept, as where people use it: otherwise every import compiles its text again.
    environment = {**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "PYTHONDONTWRITEBYTECODE": ""}
    if not (checkout / "exoid" / "symbolic").is_dir():  # until November 2026 packages lay at the top
        code = code.replace("from exoid.", "from ").replace("import exoid.", "import ")
    whole = f"{PREPARE}{code}\nprint(read_recording.__code__.co_filename, *(b - a for a, b in zip(began, now())))"
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", whole, files],
        cwd=checkout, env=environment, check=True, capture_output=True, text=True,
    )  # fmt: skip
    file, *times = done.stdout.split()[-3:]
    if not Path(file).is_relative_to(checkout.resolve()):  # an installed package comes first where a folder is missing
        raise SystemExit(f"{file} was measured, which is not of {checkout}")
    return tuple(map(float, times))


def main() -> None:
    """Measure and print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("other", type=Path)
    parser.add_argument("train", nargs="+")
    parser.add_argument("--verify", nargs="*", default=[])
    parser.add_argument("--repeats", type=int, default=2)
    parser.add_argument("--only", nargs="*", default=[], help="rows whose names begin so")
    args = parser.parse_args()
    files = json.dumps([[str(Path(f).resolve()) for f in group] for group in (args.train, args.verify)])
    refits = [(one.id, places_of(one, LEG)[-1]) for one in catalogue().values()]
    rows = ROWS | {f"fit with {effect}": REFIT.format(effect=effect, joint=joint) for effect, joint in refits}
    for name, code in rows.items():
        if args.only and not name.startswith(tuple(args.only)):
            continue
        try:
            times = [[seconds(folder, code, files) for folder in (args.other, ROOT)] for _ in range(args.repeats + 1)]
        except subprocess.CalledProcessError as error:  # an effect that the other does not know
            sys.stdout.write(f"{name:24} {error.stderr.strip().splitlines()[-1]}\n")
            continue
        texts = []
        for which, what in enumerate(("clock", "processor")):
            other, own = (min(pair[k][which] for pair in times[1:]) for k in (0, 1))
            texts.append(f"{what} {other:7.2f} s {own:7.2f} s {other / max(own, 1e-9):5.1f} times faster")
        sys.stdout.write(f"{name:24} {'   '.join(texts)}\n")
        sys.stdout.flush()


if __name__ == "__main__":
    main()
