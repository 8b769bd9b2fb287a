"""Write the recordings that `exoid demo` ships, or check that the bench still makes the shipped ones.

python benchmarks/make_demo.py            write workbench/demo_data/
python benchmarks/make_demo.py --check    compare byte for byte, exit status 1 where they differ
"""

import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from measurement.bench.demo import write_demo  # noqa: E402 - the repository must be on the path first

SHIPPED = ROOT / "workbench" / "demo_data"


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
