"""The documents that are made of the tests, and how to write them again.

python -m bench.pages            # which of them say something else than the tests
python -m bench.pages --write    # write those
"""

from __future__ import annotations

import argparse
import sys

from bench.faults import report as faults
from bench.pages import checks, records

PAGES = {page.PAGE: page.current_page for page in (checks, faults, records)}


def main() -> int:
    """Name each page that is not current; 1 if it stays so."""
    parser = argparse.ArgumentParser(
        prog="python -m bench.pages",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--write", action="store_true", help="write them")
    is_writing = parser.parse_args().write
    old = [path for path, current in PAGES.items() if path.read_text() != current()]
    for path in old:
        if is_writing:
            path.write_text(PAGES[path]())
        print(f"pages: {path} {'is written' if is_writing else 'is not what the tests say'}")
    return 1 if old and not is_writing else 0


if __name__ == "__main__":
    sys.exit(main())
