"""The cells of a spreadsheet as lines of JSON, in a process of its own: `python sheet_process.py FILE BYTES ROWS`.

Two cells in opposite corners make the reader ask for any amount of memory, and end the process when there is none. So
that happens here, below a bound. First comes a line with the number of sheets, then of each sheet its name, one line
per row, and `null`. A moment or a span of time is a list with one text or one number of seconds.
"""

from __future__ import annotations

import contextlib
import datetime
import json
import sys
from typing import Any

try:
    import resource
except ImportError:  # not every system has such a bound
    resource = None  # type: ignore[assignment]


def main(path: str, most_bytes: int, most_rows: int) -> None:
    """Write the sheets of the file to standard output."""
    if resource is not None:
        with contextlib.suppress(ValueError, OSError):  # a smaller bound is there already
            resource.setrlimit(resource.RLIMIT_AS, (most_bytes, most_bytes))
    import python_calamine

    try:
        with python_calamine.CalamineWorkbook.from_path(path) as book:
            write_line(len(book.sheet_names))
            for name in book.sheet_names:
                write_line(name)
                for row in book.get_sheet_by_name(name).to_python(skip_empty_area=True, nrows=most_rows):
                    write_line([plain_cell(cell) for cell in row])
                write_line(None)
    except BrokenPipeError:
        sys.exit(0)  # the one who asks has what he wants
    except (python_calamine.CalamineError, OSError, ValueError, TypeError, OverflowError, MemoryError) as error:
        sys.exit(f"{error or 'it takes too much memory'}"[:200])


def write_line(line: Any) -> None:
    """Write one line."""
    sys.stdout.write(json.dumps(line) + "\n")


def plain_cell(cell: Any) -> Any:
    """Return a cell as JSON knows it."""
    if isinstance(cell, datetime.timedelta):
        return [cell.total_seconds()]
    return [cell.isoformat()] if isinstance(cell, (datetime.datetime, datetime.time, datetime.date)) else cell


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]))
