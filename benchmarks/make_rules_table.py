"""Write the table of thresholds in docs/statistics.md from the thresholds themselves, or check that it is current.

python benchmarks/make_rules_table.py            write the table
python benchmarks/make_rules_table.py --check    exit status 1 where it is out of date
"""

from __future__ import annotations

import sys
from itertools import groupby
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from exoid.diagnosis.thresholds import every_threshold  # noqa: E402 - the repository must be on the path first

PAGE = ROOT / "docs" / "statistics.md"
BEGIN, END = "<!-- rules: written by benchmarks/make_rules_table.py -->", "<!-- end of rules -->"


def table() -> str:
    lines: list[str] = []
    for group, rules in groupby(every_threshold(), key=lambda rule: rule.group):
        lines += ["", f"**{group.capitalize()}**", ""]
        lines += ["| threshold | value | what it is; what happens without it |", "|---|---|---|"]
        lines += [f"| `{r.name}` | {r.value:g} | {r.prevents} |" for r in rules]
    return "\n".join([*lines, ""])


def with_table(text: str) -> str:
    """Return the page with today's table between its two marks."""
    before, _, rest = text.partition(BEGIN)
    _, _, after = rest.partition(END)
    return f"{before}{BEGIN}{table()}\n{END}{after}"


def main() -> int:
    text = PAGE.read_text(encoding="utf-8")
    fresh = with_table(text)
    if "--check" in sys.argv[1:]:
        sys.stdout.write("the table is current\n" if fresh == text else "the table is out of date\n")
        return 0 if fresh == text else 1
    PAGE.write_text(fresh, encoding="utf-8")
    sys.stdout.write(f"{PAGE.relative_to(ROOT)}\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
