"""Prints the hazards, their checks and their tests, or writes them into docs/safety.md.

python -m tests.hazards            # the table, in Markdown
python -m tests.hazards --write    # into docs/safety.md
python -m tests.hazards --json     # as data
"""

from __future__ import annotations

import argparse
import json

from tests.hazards.page import PAGE, current_page, rows, table


def main() -> None:
    """What the page's table says, from table.py and the C++ sources."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--write", action="store_true", help="write it into docs/safety.md")
    parser.add_argument("--json", action="store_true", help="print one JSON document instead")
    arguments = parser.parse_args()
    if arguments.write:
        PAGE.write_text(current_page())
        print(f"hazards: written into {PAGE}")
    else:
        print(json.dumps(rows(), indent=2) if arguments.json else table())


if __name__ == "__main__":
    main()
