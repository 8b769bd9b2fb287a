"""Write the recordings that `exoid demo` ships, or check that the bench still makes the shipped ones.

python benchmarks/make_demo.py            write exoid/workbench/demo_data/
python benchmarks/make_demo.py --check    compare byte for byte, exit status 1 where they differ

A standard leg whose knee friction grows with its load: three runs to fit and one to verify, each on a motion of its
own. Load-dependent friction is a clear pick: real gears show it, it is invisible to Coulomb plus viscous friction, and
no other entry of the catalogue looks like it.
"""

import sys
import tempfile
from dataclasses import replace
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from exoid.measurement.bench.blind import write_runs  # noqa: E402 - the repository must be on the path first
from exoid.measurement.bench.hidden import Hidden  # noqa: E402
from exoid.measurement.bench.simulation import Bench, simulate_runs  # noqa: E402

SHIPPED = ROOT / "exoid" / "workbench" / "demo_data"
SEED = 20
HIDDEN = Hidden("load_friction", "knee", {"c": 0.22})
NAMES = ("train_1", "train_2", "train_3", "verify")


def write_demo(folder: str | Path) -> tuple[Path, ...]:
    """Write the demo's recordings and the seal with their truth into `folder`; return every path written."""
    runs = simulate_runs(len(NAMES), effects=[HIDDEN], seed=SEED, bench=Bench(duration=20.0))
    named = [replace(one, recording=replace(one.recording, name=name)) for name, one in zip(NAMES, runs, strict=True)]
    recordings, seal = write_runs(folder, named)
    return (*recordings, seal)


def main() -> int:
    if "--check" not in sys.argv[1:]:
        for path in write_demo(SHIPPED):
            print(f"{path.relative_to(ROOT)}  {path.stat().st_size / 1000:.0f} kB")
        return 0
    with tempfile.TemporaryDirectory() as folder:
        made = write_demo(folder)
        differ = [path.name for path in made if path.read_bytes() != (SHIPPED / path.name).read_bytes()]
    print(f"differ: {', '.join(differ)}" if differ else "every file regenerates byte for byte")
    return 1 if differ else 0


if __name__ == "__main__":
    sys.exit(main())
